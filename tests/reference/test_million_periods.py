"""After a million periods every closed form is as accurate as in the first.

The exact motion is the textbooks' way by Legendre's integrals in 120 digits (`legendre_motion`,
`legendre_top`), with mpmath's functions; it shares no formula with the theta quotients but the
constants of motion, and is itself held against the ODE.
"""

from dataclasses import replace

import numpy as np
import pytest
from legendre_motion import LegendreMotion, free_body, free_symmetric_body
from legendre_top import heavy_top
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import FINE_ORDERS, integrate_double_double
from spincheck.reference.theta_quotients import ClosedForm
from spincheck.scenarios.exact import DIGITS, exact, normalised
from taylor_problems import TILTED, distance, problem, q_and_omega, truncation

pytestmark = pytest.mark.slow

EPS = float(np.finfo(float).eps)
#: To half an ulp each: the argument, numerator, denominator and their quotient, the phase and its
#: product, two products of quaternions, and the constants; 1.0e-15 in all.
ROUNDINGS = 9
BOUND = ROUNDINGS * EPS / 2

MILLION = 1_000_000
#: Parts of a period, none of them special.
FRACTIONS = (0.0, 0.13, 0.37, 0.5, 0.81)

DOWN = (0.0, 0.0, -9.81)
LEVER = (0.0, 0.0, 0.5)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
HANGING = (0.0, 1.0, 0.0, 0.0)


def heavy(omega_axes, q_world_axes=TILTED, spin_moment=0.4, lever_axes=LEVER, gravity=DOWN):
    """A top of unit moment across its axis."""
    moments = (1.0, 1.0, spin_moment)
    return problem(moments, omega_axes, q_world_axes, lever_axes, gravity)


def dropped(spin: float, tilt: float = 1.0) -> Problem:
    """Let go with spin about its tilted axis alone: u̇ and |W| vanish together, a cusp."""
    return heavy((0.0, 0.0, spin), (np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0))


def near_separatrix(relative: float) -> Problem:
    """D = L² − 2 E I2 = I1 (I1 − I2) ω1² + I3 (I3 − I2) ω3² but for so small a part."""
    return problem((1.0, 2.0, 3.0), (0.3, 1.0, 0.3 / np.sqrt(3.0) * (1 + relative)))


SYMMETRIC = {
    "oblate": problem((2.0, 2.0, 3.0), (0.3, 0.4, 1.1)),
    "prolate about e1, turning back": problem((0.5, 2.0, 2.0), (-1.0, 0.2, 0.7)),
    "nearly a sphere": problem((1.0, 1.0, 1.0 + 1e-9), (0.3, 0.4, 1.1)),
}
ASYMMETRIC = {
    "generic": problem((1.0, 2.0, 3.0), (0.5, 1.0, 0.7)),
    "about the least moment": problem((1.0, 2.0, 2.5), (2.0, 0.3, -0.4)),
    "flat": problem((1.0, 1.5, 2.5), (0.5, 1.0, -0.7)),
    "symmetric but for 1e-14": problem((1.0, 1.0 + 1e-14, 3.0), (0.5, 1.0, 0.7)),
    "tennis racket": problem((1.0, 2.0, 3.0), (1e-8, 1.0, 2e-8)),
    "separatrix but for 1e-14": near_separatrix(1e-14),
    "just below the separatrix": near_separatrix(-1e-14),
}
HEAVY = {
    "wave": heavy((1.0, 0.5, 30.0)),
    "loop": heavy((0.1, 0.4, 10.0), (0.9, 0.0, 0.4, 0.0)),
    "cusp": dropped(8.0),
    "cusp, almost steady": dropped(1000.0),
    "pendulum in space": heavy((0.5, 1.0, 0.0)),
    "pendulum that rotates": heavy((0.0, 9.0, 0.0), (1.0, 0.0, 0.3, 0.0)),
    "sleeping but for 1e-6": heavy((1e-6, 0.0, 15.0), UPRIGHT),
    "waking from 1e-6": heavy((1e-6, 0.0, 5.0), UPRIGHT),
    "through the top": heavy((2.0, 1.0, 5.0), UPRIGHT),
    "1e-6 past the top": heavy((2.0, 1e-6, 5.0), (1.0, 1e-6, 0.0, 0.0)),
    "through the bottom": heavy((2.0, 1.0, 5.0), HANGING),
    "com below": heavy((1.0, 0.5, 3.0), lever_axes=(0.0, 0.0, -0.5)),
    "gravity aslant": heavy((1.0, 0.5, 3.0), gravity=(3.0, -2.0, -8.0)),
}
TOPS = {
    **{name: (p, free_symmetric_body) for name, p in SYMMETRIC.items()},
    **{name: (p, free_body) for name, p in ASYMMETRIC.items()},
    **{name: (p, heavy_top) for name, p in HEAVY.items()},
}
#: Tops whose ODE forgets no digits on the way.
REGULAR = ("oblate", "generic", "about the least moment", "flat", "wave", "loop", "cusp")
every_top = pytest.mark.parametrize(("top", "solved"), TOPS.values(), ids=TOPS)


def distance_of_states(state, true_state) -> float:
    """Largest difference in q, up to its sign, and in ω over its size."""
    (q, omega), (true_q, true_omega) = state, true_state
    with mp.workdps(DIGITS):
        either = [distance([sign * x for x in q], true_q) for sign in (1, -1)]
        return max(distance(omega, true_omega), min(either))


def error(form: ClosedForm, exact_motion: LegendreMotion, t: float) -> float:
    """Of a closed form at a time."""
    (q,), (omega,) = form.states(np.array([t]))
    return distance_of_states((exact(q), exact(omega)), exact_motion.state(t))


@every_top
def test_a_million_periods_on_a_closed_form_is_right_to_rounding(top, solved):
    form, exact_motion = closed_form(top), solved(top)
    for part in FRACTIONS:
        assert error(form, exact_motion, float((MILLION + part) * exact_motion.period)) <= BOUND


@every_top
def test_rates_rounded_to_double_are_noticed(top, solved):
    form = closed_form(top)
    clock, phases = form.tables.clock.copy(), form.tables.phases.copy()
    clock[..., 1] = phases[..., 1] = 0
    rounded = replace(form, tables=form.tables._replace(clock=clock, phases=phases))
    exact_motion = solved(top)
    assert (
        error(rounded, exact_motion, float((MILLION + FRACTIONS[1]) * exact_motion.period)) > BOUND
    )


@pytest.mark.parametrize("name", REGULAR)
def test_the_exact_motion_solves_the_equations_of_motion(name):
    top, solved = TOPS[name]
    exact_motion = solved(top)
    times = np.array([float(part * exact_motion.period) for part in FRACTIONS])
    states = integrate_double_double(top, times, FINE_ORDERS)
    for k, t in enumerate(times):
        assert distance_of_states(q_and_omega(states, k), exact_motion.state(t)) <= truncation(
            FINE_ORDERS
        )


@pytest.mark.parametrize("name", REGULAR)
def test_one_ulp_in_the_attitude_is_noticed(name):
    """By the exact motion, of the comparison above."""
    top, solved = TOPS[name]
    w, x, y, z = top.q_world_axes
    turned = replace(top, q_world_axes=normalised((w, x + mpf(EPS), y, z)))
    exact_motion = solved(top)
    t = float(exact_motion.period)
    states = integrate_double_double(turned, np.array([t]), FINE_ORDERS)
    assert distance_of_states(q_and_omega(states, 0), exact_motion.state(t)) > truncation(
        FINE_ORDERS
    )
