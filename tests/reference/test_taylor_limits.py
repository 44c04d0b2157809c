"""Difficult cases of the step-size rule: rest, turning points, scales, long decay, overflow."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf
from spincheck.reference import taylor
from spincheck.reference.taylor import (
    TRUTH_ORDERS,
    IntegrationError,
    Orders,
    integrate,
    integrate_double_double,
)
from taylor_problems import apart, problem, truncation

EPS = float(np.finfo(float).eps)
BOUND = truncation(TRUTH_ORDERS)
UPRIGHT = (1, 0, 0, 0)
PENDULUM = {"lever_axes": (0, 0, 1), "gravity_world": (0, 0, -10)}
HEAVY = problem(
    (1.0, 1.3, 0.7), (0.5, 1.0, 3.0), lever_axes=(0.2, 0.1, 0.9), gravity_world=(0, 0, -1)
)


@pytest.mark.parametrize("t", [1e-300, 1.0, 1e300])
def test_a_body_at_rest_stays_at_rest(t: float) -> None:
    resting = problem((1, 2, 3), (0, 0, 0))
    start, end = integrate(resting, np.array([0.0, t]))[0]
    np.testing.assert_array_equal(start, end)


@pytest.mark.parametrize("q", [UPRIGHT, (0, 1, 0, 0)], ids=["standing", "hanging"])
def test_a_pendulum_in_balance_stays_there(q: tuple[float, ...]) -> None:
    balanced = problem((2, 2, 1), (0, 0, 0), q, **PENDULUM)
    q_end, omega_end = integrate(balanced, np.array([1e6]))
    np.testing.assert_array_equal(q_end, [q])
    np.testing.assert_array_equal(omega_end, [[0, 0, 0]])


@pytest.mark.parametrize("nudge", [1e-3, 1e-150], ids=["some", "hardly any"])
def test_a_pendulum_let_go_near_the_top_falls_at_the_rate_of_the_linear_law(nudge: float) -> None:
    """Ω = √(M g l / I), angle = start × cosh Ωt, while both are far below 1."""
    p = problem((2, 2, 1), (0, 0, 0), (1, nudge, 0, 0), **PENDULUM)
    t, rate = 1.0, np.sqrt(5.0)
    q, omega = integrate(p, np.array([t]))
    angle = 2 * nudge
    cubed = angle**2 * np.cosh(rate * t) ** 3
    assert 2 * q[0, 1] == pytest.approx(angle * np.cosh(rate * t), rel=4 * EPS + cubed)
    expected = angle * rate * np.sinh(rate * t)
    assert omega[0, 0] == pytest.approx(expected, rel=4 * EPS + cubed)
    assert omega[0, 0] != pytest.approx(expected * (1 + nudge), rel=4 * EPS + cubed) or nudge < EPS


def test_a_pendulum_passes_its_turning_points() -> None:
    """Released at 90°, it is back after 4 K(½) / Ω, and one ulp of g later it is not."""
    released = problem((2, 2, 1), (0, 0, 0), (1, 1, 0, 0), **PENDULUM)
    with mp.workdps(50):
        period = 4 * mp.ellipk(mpf(1) / 2) / mp.sqrt(5)
    times = np.array([0.0, float(period)])
    start, back = integrate(released, times)[0]
    late = abs(float(period) - period) * 5
    assert np.abs(back - start).max() < EPS + late
    ahead = replace(released, gravity_world=(mpf(0), mpf(0), mpf(-10) * (1 + 2**-24)))
    assert np.abs(integrate(ahead, times)[0][1] - start).max() > EPS + late


@pytest.mark.parametrize("shift", [-40, -20, 20, 28])
def test_faster_motion_is_the_same_motion_in_less_time(shift: int) -> None:
    """Torques grow as the square of the rate; powers of two change no digit."""
    rate, t = 2.0**shift, np.array([0.0, 1.0, 10.0])
    w, g = HEAVY.omega_axes, HEAVY.gravity_world
    quick = replace(
        HEAVY, omega_axes=tuple(x * rate for x in w), gravity_world=tuple(x * rate**2 for x in g)
    )
    slow, fast = integrate_double_double(HEAVY, t), integrate_double_double(quick, t / rate)
    slowed = replace(fast, omega_axes=fast.omega_axes / rate, omega_low=fast.omega_low / rate)
    assert apart(slowed, slow) < BOUND
    mistimed = integrate_double_double(quick, t / rate * (1 + EPS))
    assert np.abs(mistimed.q_low - slow.q_low).max() > BOUND


@pytest.mark.parametrize("shift", [-40, 40])
def test_a_heavier_body_moves_the_same(shift: int) -> None:
    scale = 2.0**shift
    heavier = replace(
        HEAVY,
        moments=tuple(x * scale for x in HEAVY.moments),
        lever_axes=tuple(x * scale for x in HEAVY.lever_axes),
    )
    t = np.array([10.0])
    assert apart(integrate_double_double(heavier, t), integrate_double_double(HEAVY, t)) == 0
    longer = replace(heavier, lever_axes=tuple(x * (1 + mpf(EPS)) for x in heavier.lever_axes))
    assert apart(integrate_double_double(longer, t), integrate_double_double(HEAVY, t)) > BOUND


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_spin_about_a_principal_axis_leaves_the_others_at_zero(axis: int) -> None:
    omega = [0.0, 0.0, 0.0]
    omega[axis] = 3.0
    _, spun = integrate(problem((1, 2, 2.5), omega), np.array([1000.0]))
    np.testing.assert_array_equal(spun, [omega])


@pytest.mark.parametrize("decay_times", [1.0, 500.0, 1e6, 1e12])
def test_drag_brings_a_sphere_to_rest_where_it_should_stop(decay_times: float) -> None:
    """All of the turn is |ω| I / c, however long one waits."""
    sphere = problem((2, 2, 2), (0, 0, 3), UPRIGHT, drag=0.5)
    q, omega = integrate(sphere, np.array([4.0 * decay_times]))
    angle = 12.0 * -np.expm1(-decay_times)
    np.testing.assert_allclose(q[0], [np.cos(angle / 2), 0, 0, np.sin(angle / 2)], atol=2 * EPS)
    # e^-x is as uncertain as its argument, x ulp.
    expected = 3.0 * np.exp(-decay_times)
    assert omega[0, 2] == pytest.approx(expected, rel=EPS * decay_times + EPS, abs=1e-230)
    assert abs(q[0, 3] - np.sin(angle / 2 * (1 + 8 * EPS))) > 2 * EPS


def test_gravity_without_a_lever_changes_no_digit() -> None:
    free = problem((1.0, 1.3, 0.7), (0.5, 1.0, 3.0))
    t = np.array([10.0])
    falling = replace(free, gravity_world=(mpf(0), mpf(0), mpf(-9)))
    assert apart(integrate_double_double(falling, t), integrate_double_double(free, t)) == 0


def test_samples_change_no_step() -> None:
    dense = np.linspace(0.0, 10.0, 1001)
    all_of_it, end = (
        integrate_double_double(HEAVY, dense),
        integrate_double_double(HEAVY, dense[-1:]),
    )
    np.testing.assert_array_equal(all_of_it.q_low[-1], end.q_low[0])


def test_a_time_asked_for_twice_is_answered_twice_and_at_0_by_the_start() -> None:
    q, omega = integrate(HEAVY, np.array([0.0, 0.0, 2.0, 2.0]))
    np.testing.assert_array_equal(q[::2], q[1::2])
    np.testing.assert_array_equal(q[0], [float(x) for x in HEAVY.q_world_axes])
    np.testing.assert_array_equal(omega[0], [float(x) for x in HEAVY.omega_axes])


def test_pauses_change_no_digit(monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.linspace(0.0, 50.0, 11)
    unbroken = integrate_double_double(HEAVY, t)
    monkeypatch.setattr(taylor, "STEPS_AT_ONCE", 3)
    paused = integrate_double_double(HEAVY, t)
    assert apart(paused, unbroken) == 0


@pytest.mark.parametrize("orders", [Orders(20, 20), Orders(36, 36)], ids=str)
def test_all_orders_may_be_double_double(orders: Orders) -> None:
    t = np.array([10.0])
    exact = integrate_double_double(HEAVY, t)
    assert apart(integrate_double_double(HEAVY, t, orders), exact) < max(truncation(orders), BOUND)


@pytest.mark.parametrize("times", [[0.0, np.nan], [0.0, np.inf], [-1.0, 0.0], [1.0, 0.5]], ids=str)
def test_times_that_cannot_be_are_refused(times: list[float]) -> None:
    with pytest.raises(ValueError, match="'times' must be finite, not negative and not decreasing"):
        integrate(HEAVY, np.array(times))


@pytest.mark.parametrize(
    "omega", [(mpf(0), mpf(0), mpf("1e200")), (mpf(0), mpf("nan"), mpf(0))], ids=["huge", "nan"]
)
def test_a_motion_out_of_range_is_an_error(omega: tuple[mpf, mpf, mpf]) -> None:
    with pytest.raises(IntegrationError, match="leaves the range of doubles at 0"):
        integrate(replace(HEAVY, omega_axes=omega), np.array([1.0]))


def test_a_motion_of_too_many_steps_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(taylor, "MAX_STEPS", 20)
    assert integrate(HEAVY, np.array([1.0]))[0].shape == (1, 4)
    with pytest.raises(IntegrationError, match="more than 20 steps: 100"):
        integrate(HEAVY, np.array([100.0]))


def test_a_span_that_is_out_of_reach_is_seen_to_be_so_at_the_first_look(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calls = []

    def counted(*arguments: Any) -> Any:
        calls.append(1)
        return march(*arguments)

    march = taylor.march
    monkeypatch.setattr(taylor, "march", counted)
    with pytest.raises(IntegrationError, match=r"1000000000\.0 s were asked for"):
        integrate(HEAVY, np.array([1e9]))
    assert len(calls) == 1


def test_states_cannot_be_written_to() -> None:
    for values in integrate(HEAVY, np.array([0.0])):
        with pytest.raises(ValueError, match="read-only"):
            values[0, 0] = 1.0
