"""Numbers of a scene file varied by path: exactly the number asked for is changed."""

import tomllib

import numpy as np
import pytest
from case_loops import each_case
from spincheck.scenarios import ScenarioError, find, load, loads
from spincheck.scenarios.vary import (
    DEFAULT_COUNT,
    MAX_COUNT,
    Axis,
    VaryError,
    check_path,
    numbers,
    parse_axis,
    varied,
)
from spincheck.scenarios.write import to_toml

EPS = np.finfo(float).eps
TEXT = """
spincheck = 1
title = "A top"
source = "made up"
[body]
mass = 2
inertia = [1.0, 2.0, 2.5]
com = [0.0, 0.0, 0.1]
[start]
euler_zyz_deg = [10.0, 40.0, 70.0]
omega_body = [1.0, 2.0, 0.5]
[effects.gravity]
acceleration = [0.0, 0.0, -9.81]
[effects.pivot]
[window]
duration = 1.0
samples = 11
[[published]]
t = 1.0
omega_body = [1.0, 2.0, 3.0]
tolerance = 1e-3
source = "made up"
[[expect]]
engine = "mujoco"
method = "RK4"
timestep = 0.001
omega = 1e-6
"""
TOP = loads(TEXT, "top")
LIBRARY_FILES = find([])
#: A value that the scene has nowhere, and with which it is still one.
OTHER = 1.6009765625


@each_case(
    ("text", "axis"),
    [
        ("a.b[2]=1:3:3", Axis("a.b[2]", (1.0, 2.0, 3.0), False)),
        ("a=-1:1:2", Axis("a", (-1.0, 1.0), False)),
        ("timestep=0.25:4:3:log", Axis("timestep", (0.25, 1.0, 4.0), True)),
    ],
)
def test_a_range_is_read(text, axis):
    assert parse_axis(text) == axis


@each_case("tail", ["", ":log"])
def test_without_a_count_there_is_the_default_one(tail):
    assert len(parse_axis(f"a=1:2{tail}").values) == DEFAULT_COUNT


@each_case("spacing", ["", ":log"])
@each_case("low", [1e-300, 1e-4, 3.0])
def test_the_ends_are_the_very_numbers_asked_for(low, spacing):
    axis = parse_axis(f"a={low!r}:{7 * low!r}:13{spacing}")
    assert (axis.values[0], axis.values[-1]) == (low, 7 * low)


def test_logarithmic_values_are_evenly_spaced_in_their_logarithms():
    steps = np.diff(np.log(parse_axis("a=1e-3:1e3:31:log").values))
    assert np.ptp(steps) <= 16 * EPS * np.log(1e3)


@each_case(
    ("text", "complaint"),
    [
        ("a", "must be 'PATH=LO:HI"),
        ("a=1", "must be 'PATH=LO:HI"),
        ("a=1:two", "must be 'PATH=LO:HI"),
        ("a=1:2:lin", "must be 'PATH=LO:HI"),
        ("a=1:2:3:4", "must be 'PATH=LO:HI"),
        ("a=1:2:log:3", "must be 'PATH=LO:HI"),
        ("a=1:2:1.5", "must be 'PATH=LO:HI"),
        ("=1:2", "must be 'PATH=LO:HI"),
        ("a=2:1", "a: LO must be less than HI, got 2 and 1"),
        ("a=1:1", "a: LO must be less than HI"),
        ("a=nan:1", "a: LO must be less than HI"),
        ("a=1:inf", "a: LO must be less than HI"),
        ("a=1:2:1", f"a: COUNT must be 2 to {MAX_COUNT}, got 1"),
        (f"a=1:2:{MAX_COUNT + 1}", "a: COUNT must be 2 to"),
        ("a=0:1:log", "a: LO of a logarithmic range must be positive, got 0"),
        ("timestep=0:1", "timestep: a timestep must be positive, got 0"),
        ("a=1:1.000000000000001", "a: no 20 different doubles"),
        ("a=-1e308:1.7e308", "a: no 20 different doubles"),
    ],
)
def test_a_range_that_cannot_be_used_names_path_rule_and_value(text, complaint):
    with pytest.raises(VaryError) as refusal:
        parse_axis(text)
    assert complaint in str(refusal.value)


def test_every_number_of_a_scene_has_a_path():
    assert list(numbers(tomllib.loads(TEXT))) == [
        "body.mass",
        "body.inertia[0]",
        "body.inertia[1]",
        "body.inertia[2]",
        "body.com[0]",
        "body.com[1]",
        "body.com[2]",
        "start.euler_zyz_deg[0]",
        "start.euler_zyz_deg[1]",
        "start.euler_zyz_deg[2]",
        "start.omega_body[0]",
        "start.omega_body[1]",
        "start.omega_body[2]",
        "effects.gravity.acceleration[0]",
        "effects.gravity.acceleration[1]",
        "effects.gravity.acceleration[2]",
        "window.duration",
        "window.samples",
    ]


def test_an_unknown_path_names_the_near_one_and_all_of_them():
    with pytest.raises(VaryError) as refusal:
        check_path(TOP, "start.omega[2]")
    assert "start.omega[2]: no number of top; did you mean 'start.omega_body[2]'?" in str(
        refusal.value
    )
    assert "window.duration" in str(refusal.value)


@each_case(
    "path",
    ["body", "body.inertia", "body.inertia[3]", "title", "spincheck", "effects.drag.rotational"],
)
def test_a_path_that_names_no_number_of_the_scene_is_refused(path):
    with pytest.raises(VaryError, match="no number of top"):
        check_path(TOP, path)


@each_case("path", list(numbers(tomllib.loads(TEXT))))
def test_one_number_is_set_and_no_other(path):
    """Compared by the paths' own list, so that a wrong place or a second one is seen."""
    check_path(TOP, path)
    value = 12.0 if path == "window.samples" else OTHER
    before, after = (_leaves(tomllib.loads(s.text)) for s in (TOP, varied(TOP, {path: value})))
    changed = {key for key in before if before[key] != after.get(key, before[key])}
    assert changed == {path}
    assert after[path] == value


def test_several_numbers_are_set_at_once_and_the_scene_itself_is_not_changed():
    before = TOP.text
    scene = varied(TOP, {"body.mass": 3.0, "start.omega_body[2]": 1e-7})
    assert (scene.body.mass, float(scene.start.omega_body[2])) == (3.0, 1e-7)
    assert scene.name == "top"
    assert scene.title == "A top, with body.mass = 3.0, start.omega_body[2] = 1e-07"
    # What holds of the scene alone is left out.
    assert (scene.document.published, scene.expect, TOP.text) == ((), (), before)


def test_a_varied_scene_is_judged_like_a_file():
    with pytest.raises(ScenarioError, match="may exceed the sum of the other two"):
        varied(TOP, {"body.inertia[0]": 5.0})


@each_case("path", LIBRARY_FILES)
def test_every_scene_of_the_library_is_written_as_it_was_read(path):
    tables = tomllib.loads(load(path).text)
    assert tomllib.loads(to_toml(tables)) == tables


def test_text_of_every_kind_is_written_as_it_was_read():
    tables = {"a": 'quotes " and \\ and\nlines, \x7f, \x01, ω', "b": {"c": [], "d": True}}
    assert tomllib.loads(to_toml(tables)) == tables


def _leaves(tables: dict) -> dict[str, object]:
    def at(path: str) -> object:
        place: object = tables
        for step in path.replace("]", "").replace("[", ".").split("."):
            place = place[int(step) if step.isdigit() else step]
        return place

    return {path: at(path) for path in numbers(tables)}
