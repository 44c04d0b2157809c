"""Motions of Lagrange's top that formulas divide by zero at: poles, rest, steady, separatrix."""

import numpy as np
import pytest
from closed_form_checks import GOAL, apart
from extended_motion import DIGITS
from heavy_tops import DOWN, UP, tilted, top
from mpmath import mp, mpf
from spincheck.reference.lagrange import lagrange
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import integrate

pytestmark = pytest.mark.slow

LATER = np.array([0.0, 1.0, 1e3, 1e9])
#: |B| = sin β/2 of a top that has fallen far from upright.
FALLEN = 0.9

UPRIGHT = {
    "asleep": top((0.0, 0.0, 5.0), UP),
    "asleep, barely": top((0.0, 0.0, 4.0), UP),  # (I3 ω3)² = 4 M g l I1
    "asleep, unstably": top((0.0, 0.0, 0.1), UP),
    "asleep, turned": top((0.0, 0.0, -5.0), (0.6, 0.0, 0.0, 0.8)),
    "balanced": top((0.0, 0.0, 0.0), UP),
    "hanging": top((0.0, 0.0, 0.0), DOWN),
    "hanging, spinning": top((0.0, 0.0, 3.0), (0.0, 0.6, 0.8, 0.0)),
    "hanging by a negative lever": top((0.0, 0.0, 3.0), UP, kappa=-1.0),
}


def test_a_kick_of_a_millionth_wakes_an_unstable_one():
    times = np.linspace(0.0, 40.0, 401)
    q, _ = lagrange(top((1e-6, 0.0, 0.1), UP)).states(times)
    assert np.hypot(q[:, 1], q[:, 2]).max() > FALLEN


def steady(cos_beta: mpf, precession: mpf) -> Problem:
    """κ = Ω (p_γ − I1 Ω cos β) (Goldstein §5.7) for I1 = κ = 1, I3 = 1/2, in sixty digits."""
    p = top((0.0, 0.0, 0.0), UP)
    with mp.workdps(DIGITS):
        spin = 2 * (1 / precession + precession * cos_beta)
        half = mp.acos(cos_beta) / 2
        q = (mp.cos(half), mpf(0), mp.sin(half), mpf(0))
        omega = (-precession * mp.sin(2 * half), mpf(0), spin)
        return Problem(**{**vars(p), "q_world_axes": q, "omega_axes": omega})


STEADY = {
    "slow": steady(mpf(1) / 2, mpf(1) / 3),
    "fast": steady(mpf(1) / 2, mpf(5)),
    "level": steady(mpf(0), mpf(1)),
    "low": steady(-mpf(3) / 4, mpf(2)),
    "nearly upright": steady(1 - mpf(10) ** -24, mpf(1)),
    "conical pendulum": steady(-mpf(1) / 4, mpf(2)),  # 1/Ω = −Ω cos β: no spin
}


def moduli(q, omega):
    """|A|, |B|, ω across the axis and along it over the largest ω at the start, (n, 4)."""
    speed = max(1.0, np.abs(omega[0]).max())
    pairs = (q[:, [0, 3]], q[:, [1, 2]], omega[:, :2] / speed, omega[:, 2:] / speed)
    return np.column_stack([np.linalg.norm(pair, axis=1) for pair in pairs])


@pytest.mark.parametrize("p", [*UPRIGHT.values(), *STEADY.values()], ids=[*UPRIGHT, *STEADY])
def test_tilt_and_spin_stay_and_it_turns_as_the_ode_has_it(p):
    start = (np.array([row], float) for row in (p.q_world_axes, p.omega_axes))
    found = moduli(*lagrange(p).states(np.concatenate([LATER, np.linspace(1e6, 1e6 + 10, 50)])))
    assert np.abs(found - moduli(*start)).max() < GOAL
    soon = np.linspace(0.0, 10.0, 21)
    assert apart(lagrange(p).states(soon), integrate(p, soon)) < GOAL


@pytest.mark.parametrize("p", STEADY.values(), ids=STEADY)
def test_a_nudge_makes_it_nutate(p):
    w1, w2, w3 = p.omega_axes
    nudged = Problem(**{**vars(p), "omega_axes": (w1, w2 + mpf(10) ** -5, w3)})
    q, _ = lagrange(nudged).states(np.linspace(0.0, 20.0, 200))
    assert np.ptp(np.hypot(q[:, 1], q[:, 2])) > 1e6 * GOAL


def test_a_pendulum_an_ulp_faster_goes_on():
    q, _ = lagrange(top((0.0, np.nextafter(2.0, 3.0), 0.0), DOWN)).states(np.linspace(0, 1e3, 1001))
    assert np.hypot(q[200:, 1], q[200:, 2]).max() > FALLEN


def test_a_pendulum_is_huygens():
    """Small swings have period 2π√(I1/M g l), and amplitude β0 lengthens them by 1 + β0²/16."""
    beta0 = 1e-3
    pendulum = lagrange(top((0.0, 0.0, 0.0), tilted(np.pi - beta0)))
    # cos β has twice the frequency; the next term of the series is 11 β0⁴/3072.
    assert 2 * pendulum.period == pytest.approx(2 * np.pi * (1 + beta0**2 / 16), rel=beta0**4)
    assert 2 * pendulum.period != pytest.approx(2 * np.pi, rel=beta0**4)
