"""Differences by their size and cause, on bodies that are made up."""

import numpy as np
import pytest
from case_loops import each_case
from scipy.spatial.transform import Rotation
from spincheck.engines import BodyReading
from spincheck.engines.users_models import AGREES, FileProblem, Stated, cause, difference
from spincheck.engines.users_models.compare import angle_between_axes
from spincheck.reports.users_models.inspection import START, TIMES, attitude_apart

EPS = float(np.finfo(float).eps)
MOMENTS = np.diag([1.0, 2.0, 2.5])
TURN = Rotation.from_euler("zyx", [40, 30, 20], degrees=True).as_matrix()
#: By 28.6°.
TILT = Rotation.from_euler("x", 0.5).as_matrix()
NO_COM = np.zeros(3)


def stated(inertia=MOMENTS, mass=2.0, com=NO_COM, unturned=None):
    unturned = inertia if unturned is None else unturned
    return Stated(mass, np.array(com), inertia, unturned=unturned)


def cause_of(one, other, problems=(), made_up=""):
    return cause(one, other, difference(one, other), problems, made_up)[1]


def turned(inertia, R):
    return R @ inertia @ R.T


def test_a_body_is_not_different_from_itself():
    apart = difference(stated(), BodyReading(2.0, NO_COM, MOMENTS))
    assert (apart.mass, apart.com, apart.inertia, apart.axes_deg) == (0, 0, 0, 0)


@pytest.mark.parametrize("angle", [1e-6, 0.5, 89.0, 91.0, 179.0])
def test_the_angle_is_the_least_that_brings_the_axes_together(angle):
    R = Rotation.from_euler("x", angle, degrees=True).as_matrix()
    angle_deg = np.degrees(angle_between_axes(turned(MOMENTS, TURN), turned(MOMENTS, TURN @ R)))
    # The axes' rounding is that of the tensor over the least gap of its moments.
    assert angle_deg == pytest.approx(min(angle, 180 - angle), abs=np.degrees(64 * EPS * 2.5 / 0.5))


def test_equal_moments_turn_freely():
    round_body = np.diag([1.0, 1.0, 1.5])
    about_its_axis = Rotation.from_euler("z", 1.0).as_matrix()
    assert angle_between_axes(round_body, turned(round_body, about_its_axis)) <= 8 * EPS
    tilted = Rotation.from_euler("x", 0.3).as_matrix()
    assert angle_between_axes(round_body, turned(round_body, tilted)) == pytest.approx(0.3)
    assert angle_between_axes(np.eye(3), MOMENTS) == 0


def test_a_com_is_measured_by_the_radius_of_gyration():
    gyration = np.sqrt(5.5 / (2 * 2.0))
    apart = difference(stated(), BodyReading(2.0, np.array([0, 0, 0.1 * gyration]), MOMENTS))
    assert apart.com == pytest.approx(0.1)


def test_a_radius_of_gyration_that_overflows_hides_no_other_difference():
    """Without a warning of NumPy's, which tests turn into errors."""
    tiny = stated(mass=1e-320)
    assert difference(tiny, tiny).worst == 0
    assert difference(tiny, BodyReading(2e-320, NO_COM, MOMENTS)).mass == pytest.approx(1)


ZERO = BodyReading(2.0, NO_COM, np.zeros((3, 3)))
TURNED = BodyReading(2.0, NO_COM, turned(MOMENTS, TILT))
IMPOSSIBLE = FileProblem("triangle inequality", "0.1 + 0.3 < 0.9: no body has it")
MADE_UP = "made up from shapes"
#: By what is told: what the file states, and the body that an engine holds.
CAUSES = {
    "moments kept, axes turned by 28.6°": (stated(), TURNED),
    "moments kept, axes turned by 28.6°: the rotation of its inertial frame is lost": (
        stated(turned(MOMENTS, TILT), unturned=MOMENTS),
        BodyReading(2.0, NO_COM, MOMENTS),
    ),
    "products of inertia dropped: tensor off by": (
        stated(turned(MOMENTS, TURN)),
        BodyReading(2.0, NO_COM, np.diag(np.diag(turned(MOMENTS, TURN)))),
    ),
    "tensor 61 times the file's": (stated(), BodyReading(2.0, NO_COM, 61 * MOMENTS)),
    "tensor 1/8 of the file's": (stated(), BodyReading(2.0, NO_COM, MOMENTS / 8)),
    "1 kg, not 2 kg": (stated(), BodyReading(1.0, NO_COM, MOMENTS)),
    "com 3 mm off": (stated(), BodyReading(2.0, np.array([0, 3e-3, 0]), MOMENTS)),
    "tensor set to zero": (stated(), ZERO),
    "tensor set to zero: no body has it, 0.1 + 0.3 < 0.9": (stated(), ZERO, (IMPOSSIBLE,)),
    "made up from shapes: tensor 3 times the file's": (
        *(stated(), BodyReading(2.0, NO_COM, 3 * MOMENTS), (), MADE_UP),
    ),
}


@each_case(("words", "case"), [*CAUSES.items()])
def test_a_difference_is_reported_by_its_cause(words, case):
    assert cause_of(*case).startswith(words)


def test_what_is_off_by_less_than_the_limit_has_no_cause():
    assert cause_of(stated(), BodyReading(2.0, NO_COM, MOMENTS * (1 + AGREES / 2))) == ""


def test_motions_apart_are_those_of_the_closed_form_of_a_ball():
    """A ball turns steadily about its start; a top precesses: both by hand."""
    top = np.diag([1.0, 1.0, 1.5])
    times = np.array(TIMES)
    for time, angle in zip(times, attitude_apart(top, np.eye(3), times), strict=True):
        # Goldstein, §5.6: spin about the axis by (1 − I3/I1) ω3 after a turn by L/I1.
        about_L = Rotation.from_rotvec(np.diag(top) * START * time)
        spin = Rotation.from_rotvec([0, 0, (1 - 1.5) * START[2] * time])
        steady = Rotation.from_rotvec(START * time)
        expected = ((about_L * spin).inv() * steady).magnitude()
        assert angle == pytest.approx(expected, abs=1e-11)


def test_a_tensor_of_another_size_moves_alike():
    assert attitude_apart(MOMENTS, 61 * MOMENTS, np.array(TIMES)).max() <= 1e-12


@pytest.mark.parametrize("tensor", [np.zeros((3, 3)), np.diag([0.1, 0.3, 0.9])])
def test_what_no_body_has_does_not_move(tensor):
    assert attitude_apart(MOMENTS, tensor, np.array(TIMES)) is None
    assert attitude_apart(tensor, MOMENTS, np.array(TIMES)) is None
