"""Verdicts on made-up ladders whose errors are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.reports.verdict import SHARP, Judgement, Step, judge
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


def ladder(error_of_dt, rungs: int = 8, round_off: float = 4 * EPS) -> list[Step]:
    """Rungs whose speed and angle are off by `error_of_dt(dt)` times a shape in time."""
    steps = []
    for k in range(rungs):
        dt = COARSEST / 2**k
        error = error_of_dt(dt) * np.sin(TIMES)
        floors = {"omega": round_off, "attitude": round_off}
        steps.append(Step(dt, round(5 / dt), turning(error, SPIN * error), floors))
    return steps


def judged(error_of_dt, order: int, signal: str = "omega", **known) -> Judgement:
    return judge(signal, ladder(error_of_dt, **known), TRUTH, order, 4 * EPS)


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


def test_a_limit_that_leaves_the_truth_midway_says_when():
    late = np.where(TIMES > 3.0, 1e-3, 0.0)
    steps = [
        Step(
            dt := COARSEST / 2**k,
            round(5 / dt),
            turning(dt**2 * np.sin(TIMES), SPIN * (late + dt**2 * np.sin(TIMES))),
            {"omega": 4 * EPS, "attitude": 4 * EPS},
        )
        for k in range(8)
    ]
    found = judge("omega", steps, TRUTH, 2, 4 * EPS)
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
