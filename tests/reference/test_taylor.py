"""Motions with a closed form come out to all digits of a double-double run, and one ulp shows."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    integrate,
    integrate_double_double,
)
from spincheck.scenarios.exact import DIGITS, Quaternion, Vector, conjugate, product, rotate
from taylor_problems import apart, distance, problem, q_and_omega, truncation
from two_turns import turn, two_turns

EPS = float(np.finfo(float).eps)
BOUND = truncation(TRUTH_ORDERS)
TIMES = np.array([0.0, 0.7, 1.9, 10.0])

#: Jacobi's parameter of problem B5 of Hull, Enright, Fellen & Sedgwick, "Comparing numerical
#: methods for ordinary differential equations", SIAM J. Numer. Anal. 9 (1972) 603-637.
M_B5 = mpf("0.51")

SPHERE = problem((2, 2, 2), (0.5, -1.0, 3.0), drag=0.125)
SPUN_UP = problem((2, 2, 2), (0, 0, 0), torque_axes=(0.25, -0.5, 1.0))
SYMMETRIC = problem((2, 2, 0.75), (0.5, -1.0, 3.0))
ROCKET = problem((2, 2, 0.75), (0.5, -1.0, 3.0), torque_axes=(0, 0, 0.3))
ASYMMETRIC = problem((1.0, 1.3, 0.7), (0.5, -1.0, 3.0))
PUSHED = replace(ASYMMETRIC, torque_world=(mpf(1) / 4, mpf(-2), mpf(3) / 8))
HEAVY = problem(
    (1.0, 1.3, 0.7), (0.5, 1.0, 3.0), lever_axes=(0.2, 0.1, 0.9), gravity_world=(0, 0, -1)
)

#: Not chaotic: its errors grow as a power of time.
REGULAR = replace(HEAVY, q_world_axes=(mpf(24) / 25, mpf(0), mpf(7) / 25, mpf(0)))


def b5() -> Problem:
    """A body for which ω in these units is (sn, cn, dn)(t | 0.51)."""
    start = problem((2, 3, 1), (0, 0, 0))
    with mp.workdps(DIGITS):
        return replace(start, omega_axes=(mpf(0), *b5_units()[1:]))


def b5_units() -> Vector:
    """Units of ω that make (I₂−I₃)/I₁ = 1, (I₃−I₁)/I₂ = −1/3, (I₁−I₂)/I₃ = −1 those of B5."""
    return mp.sqrt(3 * M_B5), mp.sqrt(M_B5), mp.sqrt(mpf(3))


def omega_b5(_: Problem, t: mpf) -> list[mpf]:
    values = [mp.ellipfun(name, t, m=M_B5) for name in ("sn", "cn", "dn")]
    return [unit * value for unit, value in zip(b5_units(), values, strict=True)]


def omega_decaying(p: Problem, t: mpf) -> list[mpf]:
    return [w * mp.exp(-p.drag * t / p.moments[0]) for w in p.omega_axes]


def omega_growing(p: Problem, t: mpf) -> list[mpf]:
    return [n * t / i for n, i in zip(p.torque_axes, p.moments, strict=True)]


def omega_about_axis(p: Problem, t: mpf) -> list[mpf]:
    """I₁ = I₂ and a torque along axis 3: ω₁ + iω₂ turns by the integral of ω₃."""
    (i1, _, i3), (w1, w2, w3), n3 = p.moments, p.omega_axes, p.torque_axes[2]
    turn = (1 - i3 / i1) * (w3 * t + n3 * t**2 / (2 * i3))
    across = mp.mpc(w1, w2) * mp.expj(-turn)
    return [across.real, across.imag, w3 + n3 * t / i3]


def q_decaying(p: Problem, t: mpf) -> Quaternion:
    rate = p.drag / p.moments[0]
    speed = mp.sqrt(sum(w * w for w in p.omega_axes))
    return product(p.q_world_axes, turn(p.omega_axes, speed * -mp.expm1(-rate * t) / rate))


def q_growing(p: Problem, t: mpf) -> Quaternion:
    torque = mp.sqrt(sum(n * n for n in p.torque_axes))
    return product(p.q_world_axes, turn(p.torque_axes, torque * t**2 / (2 * p.moments[0])))


def q_precessing(p: Problem, t: mpf) -> Quaternion:
    L = angular_momentum_axes(p, list(p.omega_axes))
    return two_turns(p.moments[0], L, p.q_world_axes, p.omega_axes, 2, t)[0]


def angular_momentum_axes(p: Problem, omega: list[mpf]) -> Vector:
    L1, L2, L3 = (i * w for i, w in zip(p.moments, omega, strict=True))
    return L1, L2, L3


def omega_error(p: Problem, by_hand: Callable[[Problem, mpf], list[mpf]], of: Problem) -> float:
    """Largest error of the ω of one problem as the motion of another, at `TIMES` after 0."""
    states = integrate_double_double(p, TIMES)
    with mp.workdps(DIGITS):
        return max(
            distance(q_and_omega(states, k)[1], by_hand(of, mpf(TIMES[k])))
            for k in range(1, len(TIMES))
        )


def q_error(p: Problem, by_hand: Callable[[Problem, mpf], Quaternion], of: Problem) -> float:
    """The same of the attitude, quaternions of the same sign."""
    states = integrate_double_double(p, TIMES)
    with mp.workdps(DIGITS):
        return max(
            distance(q_and_omega(states, k)[0], by_hand(of, mpf(TIMES[k])))
            for k in range(len(TIMES))
        )


def faster(p: Problem) -> Problem:
    """The problem with its motion changed by one ulp, in what drives it."""
    w1, w2, w3 = (w * (1 + mpf(EPS)) for w in p.omega_axes)
    n1, n2, n3 = (n * (1 + mpf(EPS)) for n in p.torque_axes)
    return replace(p, omega_axes=(w1, w2, w3), torque_axes=(n1, n2, n3))


OMEGA_KNOWN = {
    "DETEST B5": (b5(), omega_b5),
    "sphere slowed by drag": (SPHERE, omega_decaying),
    "sphere spun up from rest": (SPUN_UP, omega_growing),
    "torque along the axis of symmetry": (ROCKET, omega_about_axis),
    "free symmetric top": (SYMMETRIC, omega_about_axis),
}
Q_KNOWN = {
    "sphere slowed by drag": (SPHERE, q_decaying),
    "sphere spun up from rest": (SPUN_UP, q_growing),
    "free symmetric top": (SYMMETRIC, q_precessing),
}


@pytest.mark.parametrize(("p", "by_hand"), OMEGA_KNOWN.values(), ids=OMEGA_KNOWN)
def test_angular_velocity_is_the_closed_form(
    p: Problem, by_hand: Callable[[Problem, mpf], list[mpf]]
) -> None:
    assert omega_error(p, by_hand, p) < BOUND
    assert omega_error(faster(p), by_hand, p) > BOUND


@pytest.mark.parametrize(("p", "by_hand"), Q_KNOWN.values(), ids=Q_KNOWN)
def test_attitude_is_the_closed_form(
    p: Problem, by_hand: Callable[[Problem, mpf], Quaternion]
) -> None:
    assert q_error(p, by_hand, p) < BOUND
    assert q_error(faster(p), by_hand, p) > BOUND


def test_a_torque_constant_in_the_world_adds_to_L_in_proportion_to_time() -> None:
    states = integrate_double_double(PUSHED, TIMES)
    with mp.workdps(DIGITS):
        start, *later = (
            rotate(tuple(q), angular_momentum_axes(PUSHED, omega))
            for q, omega in (q_and_omega(states, k) for k in range(len(TIMES)))
        )
        for t, L_world in zip(TIMES[1:], later, strict=True):
            right, wrong = (
                [L + n * mpf(t) * ulp for L, n in zip(start, PUSHED.torque_world, strict=True)]
                for ulp in (mpf(1), 1 + mpf(EPS))
            )
            assert distance(L_world, right) < BOUND
            assert distance(L_world, wrong) > BOUND


def energy_and_vertical(p: Problem, q: list[mpf], omega: list[mpf]) -> list[mpf]:
    """E, and L along gravity."""
    L_axes = angular_momentum_axes(p, omega)
    kinetic = sum(L * w for L, w in zip(L_axes, omega, strict=True)) / 2
    lever_world, L_world = rotate(tuple(q), p.lever_axes), rotate(tuple(q), L_axes)
    potential = -sum(a * b for a, b in zip(p.gravity_world, lever_world, strict=True))
    return [kinetic + potential, sum(a * b for a, b in zip(p.gravity_world, L_world, strict=True))]


def test_a_heavy_asymmetric_top_keeps_energy_and_vertical_angular_momentum() -> None:
    states = integrate_double_double(HEAVY, TIMES)
    with mp.workdps(DIGITS):
        start, end = (energy_and_vertical(HEAVY, *q_and_omega(states, k)) for k in (0, -1))
        q, omega = q_and_omega(states, -1)
        nudged = energy_and_vertical(HEAVY, q, [w * (1 + mpf(EPS)) for w in omega])
    assert distance(end, start) < BOUND
    assert distance(nudged, start) > BOUND


def test_q_keeps_its_norm_though_nothing_renormalises_it() -> None:
    q, _ = q_and_omega(integrate_double_double(HEAVY, TIMES), -1)
    with mp.workdps(DIGITS):
        assert abs(sum(x * x for x in q) - 1) < BOUND
        assert abs(sum(float(x) ** 2 for x in q) - 1) < 4 * EPS


def test_gravity_in_any_direction_is_the_world_turned() -> None:
    with mp.workdps(DIGITS):
        tilt = turn((mpf(1), mpf(-2), mpf(1) / 2), mpf(1.1))
        tilted = replace(
            HEAVY,
            q_world_axes=product(tilt, HEAVY.q_world_axes),
            gravity_world=rotate(tilt, HEAVY.gravity_world),
        )
    upright, turned = (q_and_omega(integrate_double_double(p, TIMES), -1) for p in (HEAVY, tilted))
    with mp.workdps(DIGITS):
        back = product(conjugate(tilt), tuple(turned[0]))
        assert distance(back, upright[0]) < BOUND
        assert distance(turned[1], upright[1]) < BOUND
        assert distance(turned[0], upright[0]) > BOUND


@pytest.mark.parametrize("p", [ASYMMETRIC, HEAVY, PUSHED], ids=["free", "heavy", "pushed"])
def test_what_the_orders_leave_out_is_within_the_stated_bound(p: Problem) -> None:
    coarse, exact_motion, fine = (
        integrate_double_double(p, TIMES, orders)
        for orders in (CHECK_ORDERS, TRUTH_ORDERS, FINE_ORDERS)
    )
    assert apart(exact_motion, fine) < truncation(TRUTH_ORDERS)
    assert apart(coarse, fine) < truncation(CHECK_ORDERS)
    assert apart(coarse, fine) > truncation(FINE_ORDERS)


@pytest.mark.parametrize("p", [b5(), REGULAR], ids=["free", "heavy"])
def test_doubles_are_right_to_the_last_digit_after_a_thousand_periods(p: Problem) -> None:
    period = 4 * float(mp.ellipk(M_B5))
    times = np.array([1000 * period])
    exact_motion, fine = (integrate_double_double(p, times, o) for o in (TRUTH_ORDERS, FINE_ORDERS))
    rounding = EPS / 2
    assert apart(exact_motion, fine) < rounding
    assert apart(integrate_double_double(faster(p), times), fine) > rounding


def test_rounded_states_are_the_high_parts() -> None:
    q_world_axes, omega_axes = integrate(HEAVY, TIMES)
    states = integrate_double_double(HEAVY, TIMES)
    np.testing.assert_array_equal(q_world_axes, states.q_world_axes)
    np.testing.assert_array_equal(omega_axes, states.omega_axes)
