"""Extremely large and small numbers: solved to a finite motion, or refused in one sentence."""

import numpy as np
import pytest
from case_loops import each_case
from mutated_scenes import LEAST, Raw, changed, leaves, with_entries, written
from spincheck.reference import IntegrationError, solve
from spincheck.scenarios import Scenario, ScenarioError, loads

pytestmark = pytest.mark.slow

SIZES = ("0", "-1.0", "1e25", "1e150", "1e300", "1e308", "-1e308", "1e-150", "1e-300", "5e-324")
#: Numbers that set the motion; those of [[published]] and [[expect]] are only compared with.
MOVING = {
    leaf.name: leaf
    for leaf in leaves()
    if leaf.numbers and leaf.keys[0] not in ("published", "expect")
}
HEAVY = {"gravity": {"acceleration": [0.0, 0.0, -9.81]}, "pivot": {}}


def scene_or_refusal(file) -> Scenario | str:
    try:
        return loads(written(file), "made")
    except ScenarioError as refusal:
        return str(refusal)


def assert_solved_or_refused(scene: Scenario | str) -> None:
    if isinstance(scene, str):
        assert scene.startswith("made:")
        assert scene.isprintable()
        return
    try:
        solution = solve(scene, np.linspace(0, scene.window.duration, 3))
    except IntegrationError:
        return
    for values in vars(solution.trajectory).values():
        assert np.isfinite(values).all()
    assert all(np.isfinite(value) for _, value in solution.uncertainty)


@each_case("size", SIZES)
@each_case("leaf", MOVING)
def test_an_extreme_size_is_solved_or_refused(leaf, size):
    for _, value in list(with_entries(leaf.example, Raw(size)))[:1]:
        assert_solved_or_refused(scene_or_refusal(changed(leaf.file, leaf.keys, value)))


@each_case("size", SIZES)
@each_case("keys", [("body", "mass"), ("body", "com"), ("start", "omega_body")])
def test_an_extreme_heavy_top_is_solved_or_refused(keys, size):
    value = Raw(size) if keys[-1] == "mass" else [0.0, 0.0, Raw(size)]
    assert_solved_or_refused(scene_or_refusal(changed({**LEAST, "effects": HEAVY}, keys, value)))


@each_case(
    ("keys", "value", "rule"),
    [
        (("window", "duration"), 1e15, "cannot be followed"),
        (("start", "omega_body"), [0.0, 0.0, 1e300], "too large to be computed with"),
        (("body", "mass"), 1e-300, "too small to be computed with"),
        (("body", "inertia"), [1e-20, 1.0, 1.0], "times the least"),
    ],
)
def test_what_cannot_be_computed_is_refused_as_it_is_read(keys, value, rule):
    assert rule in scene_or_refusal(changed(LEAST, keys, value))


@each_case("turns", [0.99e9, 1.01e9])
def test_the_span_is_refused_just_where_it_is_said_to_be(turns):
    file = changed(LEAST, ("start", "omega_body"), [0.0, 0.0, turns])
    assert isinstance(scene_or_refusal(file), Scenario) == (turns < 1e9)
