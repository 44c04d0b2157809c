"""Verdicts on made-up ladders whose errors are known."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.richardson import RichardsonSequence
from spincheck.reports.harness.verdict import SHARP, Judgement, judge
from spincheck.scenarios import Trajectory

TIMES = np.linspace(0.0, 5.0, 51)
EPS = float(np.finfo(float).eps)
SPIN = 3.0
COARSEST = 0.1


def turning(angle_error: np.ndarray, omega_error: np.ndarray) -> Trajectory:
    """A steady spin about z, with given errors in angle (rad) and speed (rad/s), each (n,)."""
    n = len(TIMES)
    angles = SPIN * TIMES + angle_error
    q = Rotation.from_rotvec(np.outer(angles, [0, 0, 1])).as_quat(scalar_first=True)
    omega = np.outer(SPIN + omega_error, [0, 0, 1])
    return Trajectory(TIMES, q, omega, np.zeros((n, 3)), np.zeros((n, 3)))


TRUTH = turning(0 * TIMES, 0 * TIMES)


def approach(
    errors_of_dt: Callable[[float], tuple[np.ndarray, np.ndarray]],
    order: int,
    signal: str = "omega",
    rungs: int = 8,
    round_off: float = 4 * EPS,
    uncertainty: float = 4 * EPS,
) -> RichardsonSequence:
    """Rungs whose angle and speed are off by `errors_of_dt(dt)`, both (n,)."""
    ladder = RichardsonSequence(signal, TRUTH, order, uncertainty)
    for k in range(rungs):
        dt = COARSEST / 2**k
        ladder.add(dt, turning(*errors_of_dt(dt)), round_off)
    return ladder


def judged(error_of_dt: Callable[[float], float], order: int, *known, **more) -> Judgement:
    """Of rungs that are off by `error_of_dt(dt)` times a shape in time."""

    def errors(dt: float) -> tuple[np.ndarray, np.ndarray]:
        error = error_of_dt(dt) * np.sin(TIMES)
        return error, SPIN * error

    return judge(approach(errors, order, *known, **more))


@pytest.mark.parametrize("signal", ["omega", "attitude"])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_method_of_its_declared_order_converges(signal, order):
    found = judged(lambda dt: dt**order + dt ** (order + 1), order, signal)
    assert found.word == "converges"
    assert found.order == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("signal", ["omega", "attitude"])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_limit_that_is_not_the_truth_disagrees(signal, order):
    offset = 10 * (COARSEST / 2**5) ** order
    found = judged(lambda dt: offset + dt**order + dt ** (order + 1), order, signal)
    assert found.word == "disagrees"
    assert found.limit_error == pytest.approx(offset, rel=0.1)


def test_a_limit_that_is_exact_and_not_the_truth_disagrees():
    """As of a rule that makes no error in a parabola, and follows another one."""
    found = judged(lambda dt: 0.5 + 2 * EPS * np.sign(np.sin(1 / dt)), order=4)
    assert found.word == "disagrees"


def test_a_limit_that_leaves_the_truth_midway_says_when():
    late = np.where(TIMES > 3.0, 1e-3, 0.0)

    def errors(dt: float) -> tuple[np.ndarray, np.ndarray]:
        off = dt**2 * np.sin(TIMES)
        return off, SPIN * (late + off)

    found = judge(approach(errors, 2))
    assert found.word == "disagrees"
    assert "from t = 3.1 s on" in found.reason


def test_an_order_below_the_declared_one_does_not_converge():
    assert judged(lambda dt: 0.1 * dt, order=4).word != "converges"


def test_an_order_above_the_declared_one_converges():
    found = judged(lambda dt: dt**2, order=1)
    assert found.word == "converges"
    assert "or better" in found.reason


def test_errors_that_grow_as_steps_shrink_do_not_converge():
    assert judged(lambda dt: 1e-6 / dt, order=1).word != "converges"


def test_the_order_of_a_diverging_ladder_is_negative():
    found = judged(lambda dt: 1e-6 / dt, order=1)
    assert found.order == pytest.approx(-1, abs=0.01)


def test_a_ladder_too_coarse_to_tell_is_unresolved_and_says_what_would_resolve_it():
    found = judged(lambda dt: np.sin(2000 * dt), order=1, rungs=4)
    assert found.word == "unresolved"
    assert found.needed_timestep < COARSEST / 2**3


def test_errors_at_round_off_throughout_converge_without_an_order():
    found = judged(lambda dt: 2 * EPS * np.sign(np.sin(1 / dt)), order=4)
    assert found.word == "converges"
    assert found.order is None


def test_round_off_below_the_order_is_not_mistaken_for_a_limit():
    floor = 1e-9
    found = judged(lambda dt: dt**4 + 0.5 * floor * np.sin(1e6 / dt), order=4, round_off=floor)
    assert found.word == "converges"
    assert found.order == pytest.approx(4, abs=0.25)


def test_a_blurred_limit_is_no_convergence():
    found = judged(lambda dt: dt**0.3, order=1)
    assert found.word == "unresolved"
    assert found.limit_estimate > SHARP


@pytest.mark.parametrize("signal", ["omega", "attitude"])
def test_rungs_added_one_by_one_are_judged_as_all_at_once(signal):
    ladder = RichardsonSequence(signal, TRUTH, 1, 4 * EPS)
    for k in range(8):
        dt = COARSEST / 2**k
        error = (dt + dt**2) * np.sin(TIMES)
        ladder.add(dt, turning(error, SPIN * error), 4 * EPS)
        if k >= 2:
            found = judge(ladder)
    assert found == judged(lambda dt: dt + dt**2, 1, signal)


@pytest.mark.parametrize("given", ["round_off", "uncertainty"])
def test_where_rounding_or_the_reference_hides_the_limit_nothing_is_claimed(given):
    found = judged(lambda dt: 5 * dt**2, 2, **{given: 2 * SHARP})
    assert found.word == "unresolved"
    assert "no timestep would tell" in found.reason


def test_errors_within_a_round_off_that_is_no_small_error_are_no_convergence():
    assert judged(lambda dt: 0.5, 2, round_off=1.0).word == "unresolved"
    assert judged(lambda dt: 0.5 * SHARP, 2, round_off=1.0).word == "converges"


def test_what_would_resolve_a_ladder_is_told_in_steps_too():
    found = judged(lambda dt: np.sin(2000 * dt), order=1, rungs=4)
    assert f"{TIMES[-1] / found.needed_timestep:.1e} steps" in found.reason
