"""Methods of an order are known by the leading term of their error, whichever methods they are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hidden import changed
from planted_motions import Case, case, exactly, rates_of, stepped
from reported_faults import Arrays
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.explaining.search import LEFT
from spincheck.reports.harness.recorded.files.exact_at import exact_at
from spincheck.reports.harness.recorded.files.motion import reading_of, recorded_motion
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.fits.leading_error import (
    ATTITUDE,
    BOTH,
    OMEGA,
    leading_errors,
    left_by_methods,
    trees,
)
from spincheck.reports.harness.recorded.fits.other_physics import NEXT_TERM
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.samples.intervals import (
    Intervals,
    intervals_of,
    root_mean_squares,
)

BODY, TOP = case(324, samples=101), case(323, is_pivoted=True, duration=2.0, samples=201)
#: Tableaus that somebody meant to be RK4's, their orders, and of a method that has order 3.
HALF, SIXTHS = [[], [0.5], [0, 0.5], [0, 0, 1]], np.array([1, 2, 2, 1]) / 6
WRONG = {
    "a last stage at half of the step": ([[], [0.5], [0, 0.5], [0, 0, 0.5]], SIXTHS, 1),
    "a second stage at the step's end": ([[], [1], [0, 0.5], [0, 0, 1]], SIXTHS, 1),
    "weights in another order": (HALF, np.array([1, 2, 1, 2]) / 6, 1),
    "equal weights": (HALF, np.ones(4) / 4, 2),
    "a third stage from the first": ([[], [0.5], [0.5, 0], [0, 0, 1]], SIXTHS, 2),
}
KUTTA = [[], [0.5], [-1, 2]], np.array([1, 4, 1]) / 6, 3


def made_by(
    one: Case,
    tableau: list[list[float]],
    weights: np.ndarray,
    steps: int,
    *,
    is_world: bool = False,
) -> Arrays:
    """The motion by so many steps of a Runge–Kutta method from sample to sample.

    Its variables are q and ω along body axes, or along world axes if `is_world`.
    """
    of_body, times, start = rates_of(one), one.scenario.times, one.scenario.start

    def of_world(q: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        R = Rotation.from_quat(q, scalar_first=True)
        turning, accelerated = of_body(q, R.inv().apply(omega))
        return turning, R.apply(accelerated)

    rates, omega = of_body, start.omega_body
    if is_world:
        rates = of_world
        omega = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True).apply(omega.copy())
    h, y, rows = float(times[1]) / steps, np.hstack([start.q_world_body_wxyz, omega]), []
    for _ in times:
        rows.append(y)
        for _ in range(steps):
            stages: list[np.ndarray] = []
            for row in tableau:
                at = y + h * sum((a * k for a, k in zip(row, stages, strict=True)), np.zeros(7))
                stages.append(np.concatenate(rates(at[:4], at[4:])))
            y = y + h * (weights @ stages)
            y[:4] /= np.linalg.norm(y[:4])
    q, omega = np.split(np.array(rows), [4], axis=1)
    if is_world:
        omega = Rotation.from_quat(q, scalar_first=True).inv().apply(omega)
    return {"t": times.copy(), "q": q, "omega": omega}


def intervals(one: object, arrays: Arrays) -> Intervals:
    """The intervals of a recording, in units of their differences from the exact motion."""
    recording = Recording(Path("motion.csv"), arrays, {})
    exact = exact_at(one.scenario, arrays["t"]).trajectory
    motion = recorded_motion(one.scenario, recording, reading_of(recording), exact).trajectory
    data = intervals_of(one.scenario, motion, None, 1, np.full(2, 1e-13), most=60)
    assert data is not None
    return data.with_error(root_mean_squares(data.apart(data.base)))


def test_there_are_as_many_trees_as_in_the_literature() -> None:
    """Hairer, Nørsett & Wanner I, table II.2.1; of two colours §II.15, half with either root."""
    assert [len(trees(count, [BOTH])) for count in range(1, 8)] == [1, 1, 2, 4, 9, 20, 48]
    assert [len(trees(count, [ATTITUDE, OMEGA])) for count in range(1, 5)] == [2, 4, 14, 52]


@pytest.mark.parametrize("steps", [1, 10])
@pytest.mark.parametrize("one", [BODY, TOP], ids=["free", "heavy"])
def test_the_leading_error_of_its_order_alone_explains_a_method(one: object, steps: int) -> None:
    for tableau, weights, order in (*WRONG.values(), KUTTA):
        data = intervals(one, made_by(one, tableau, weights, steps))
        turn = float(np.linalg.norm(data.starts[:, 4:], axis=1).max() * data.spans[0, 0]) / steps
        left = {n: np.sqrt(np.mean(left_by_methods(data, [n]) ** 2)) for n in (1, 2, 3)}
        # The next term is as much smaller as a step turns the body. Other orders leave more.
        assert left.pop(order) < NEXT_TERM * turn < min(left.values())


@pytest.mark.parametrize("order", [1, 3])
def test_a_method_with_omega_along_world_axes_has_other_leading_errors(order: int) -> None:
    """As Drake's: those of ω along body axes leave two thirds of a third-order error."""
    tableau, weights = ([[]], np.ones(1)) if order == 1 else KUTTA[:2]
    steps = 10
    data = intervals(BODY, made_by(BODY, tableau, weights, steps, is_world=True))
    turn = float(np.linalg.norm(data.starts[:, 4:], axis=1).max() * data.spans[0, 0]) / steps
    assert np.sqrt(np.mean(left_by_methods(data, [order]) ** 2)) < NEXT_TERM * turn


def test_the_coefficients_of_explicit_euler_are_one_half() -> None:
    """Its step is off by h²/2 of the second derivative, whose sign is that of what is left out."""
    data = intervals(TOP, made_by(TOP, [[]], np.ones(1), 10))
    errors = leading_errors(data, [1], float(data.spans[0, 0]) / 10)
    columns = (errors / data.scale).reshape(len(errors), -1).T
    seen = np.linalg.norm(columns, axis=0) > LEFT**2 * np.linalg.norm(columns, axis=0).max()
    residuals = data.deviations(data.base[None]).ravel()
    best = np.linalg.lstsq(columns[:, seen], residuals, rcond=None)[0]
    assert best == pytest.approx(-0.5, abs=0.02)


@pytest.mark.parametrize("wrong", WRONG)
def test_a_method_of_a_lower_order_than_the_stated_one_is_named(wrong: str) -> None:
    tableau, weights, order = WRONG[wrong]
    recording = Recording(
        Path("motion.csv"), made_by(TOP, tableau, weights, 10), {"timestep": "0.001"}
    )
    found = judged_motion(TOP.scenario, recording, 4)
    (words,) = found.explained_by
    assert words.startswith(f"its method is of order {order}, not 4")
    assert not judged_motion(TOP.scenario, recording, order).explained_by


def test_a_drag_of_the_other_sign_is_no_error_of_a_method() -> None:
    """Of linear drag the leading error is a drag, too, but a small part of it."""
    sphere = {"mass": 1.5, "inertia": np.diag([0.5, 0.5, 0.5]).tolist()}
    drag = {"effects": {"drag": {"rotational": 0.05}}}
    one = replace(changed(BODY, body=sphere, **drag), inertia=0.5 * np.eye(3))
    arrays = exactly(one, rates_of(one, torque=lambda omega: 0.05 * omega))
    of_omega = left_by_methods(intervals(one, arrays), [1]).reshape(-1, 2, 3)[:, 1]
    assert np.mean(of_omega**2) > 1 - LEFT


def test_drag_beside_a_method_of_first_order_is_not_taken_for_its_error() -> None:
    """As it would be if ω along body axes and along world axes were fitted together."""
    one = case(701, is_pivoted=True, duration=2.0, samples=101)
    slowed = rates_of(one, torque=lambda omega: -0.01 * omega)
    made = stepped(one.scenario, slowed, 1, 0.01, np.random.default_rng(3))
    recording = Recording(Path("motion.csv"), made, {"timestep": "0.01"})
    (words,) = judged_motion(one.scenario, recording).explained_by
    assert words == "it moves as if it were slowed by 0.01 N m s"
