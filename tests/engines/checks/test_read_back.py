"""Differences of a body that an engine holds, by their size."""

import numpy as np
import pytest
from case_loops import each_case
from scene_texts import scene
from spincheck.engines import BodyReading, State
from spincheck.engines.checks.read_back import READ_BACK_SLACK, Difference, differences
from spincheck.scenarios.rotation import matrix

#: m; beside it the tensor about the origin is that of the arm: m r² is 500 times the tensor's.
ARM = 25.0


def told(scenario, body=None, **misread):
    """The differences of a scene and of what is held of it, but for what is misread."""
    own, start = scenario.body, scenario.start
    held = {"q_world_body_wxyz": start.q_world_body_wxyz, "omega_body": start.omega_body} | misread
    state = State(*held.values(), start.position_world, start.velocity_world)
    body = body or BodyReading(own.mass, own.com, own.inertia_com)
    return differences(scenario, body, state, READ_BACK_SLACK)


def unlike(inertia, arm=ARM):
    """What is told of a body far from its origin that is held with that tensor."""
    far = scene(("com = [0.1, 0.2, 0.3]", f"com = [{arm}, 0.0, 0.0]"))
    return told(far, BodyReading(far.body.mass, far.body.com, inertia))


def test_a_tensor_is_measured_about_the_com():
    for times in (61.0, 1 + 1e-6):
        (difference,) = unlike(times * np.diag([1.0, 2.0, 2.5]))
        assert difference.what == "inertia_com"
        assert difference.relative == pytest.approx(times - 1)


def test_a_tensor_is_reported_within_its_own_rounding_however_long_the_arm():
    assert unlike(np.diag([1.0, 2.0, 2.5]) * (1 + READ_BACK_SLACK / 2)) == []
    assert len(unlike(np.diag([1.0, 2.0, 2.5]) * (1 + 2 * READ_BACK_SLACK))) == 1


def test_a_tensor_that_is_held_about_the_origin_rounds_there():
    arm, tensor = 1e4, np.diag([1.0, 2.0, 2.5])
    ulp = float(np.spacing(2.0 * arm**2)) * np.diag([0.0, 1.0, 1.0])
    assert 2 * ulp.max() > 1e3 * READ_BACK_SLACK
    assert unlike(tensor + 2 * ulp, arm) == []
    assert len(unlike(tensor + 16 * ulp, arm)) == 1


ORDER = "its components are permuted, w x y z for x y z w"
INVERSE = "it is conjugated"


@each_case(
    ("misread", "words"),
    [
        (lambda q: np.roll(q, -1), ORDER),
        (lambda q: -np.roll(q, 1), ORDER),
        (lambda q: q * [1, -1, -1, -1], f"{INVERSE}, world to body instead of body to world"),
        (lambda q: np.roll(q * [1, -1, -1, -1], -1), f"{ORDER}, and {INVERSE}"),
        (lambda q: q * [1, 1, -1, -1], ""),
    ],
)
def test_a_quaternion_that_is_permuted_or_conjugated_is_told_so_first(misread, words):
    start = scene().start
    q = misread(start.q_world_body_wxyz)
    found = told(scene(), q_world_body_wxyz=q, omega_body=2 * start.omega_body)
    named = {one.what: one for one in found}
    assert (next(iter(named)) == "q_world_body_wxyz") == bool(words)
    assert named["q_world_body_wxyz"].why == words
    assert named["q_world_body_wxyz"].complaint.endswith(f": {words}" if words else "]")


@each_case(
    ("misread", "is_turned"),
    [
        (lambda omega, R_world_body: R_world_body @ omega, True),
        (lambda omega, R_world_body: R_world_body.T @ omega, True),
        (lambda omega, R_world_body: R_world_body @ R_world_body @ omega, False),
        (lambda omega, R_world_body: -omega, False),
    ],
)
def test_omega_along_the_other_axes_is_told_so(misread, is_turned):
    start = scene().start
    omega_body = misread(start.omega_body, matrix(start.q_world_body_wxyz))
    (off,) = told(scene(), omega_body=omega_body)
    assert ("along the other axes" in off.complaint) == is_turned


@pytest.mark.parametrize("relative", [0.03, 3e-5, 3e-9, np.inf, np.nan])
def test_a_remark_shows_in_which_digit_a_quantity_differs(relative: float) -> None:
    wanted = np.array([0.2])
    differing = Difference("mass", wanted, wanted * (1 + relative), relative)
    got, _, others = differing.remark.removeprefix("'mass' reads back as ").partition(", not ")
    assert got != others.partition(":")[0]
    assert f"off by {100 * relative:.2g}%" in others
