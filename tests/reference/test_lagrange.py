"""Lagrange's top: every kind of nutation, a million periods on."""

from dataclasses import replace

import numpy as np
import pytest
from case_loops import each_case
from closed_form_checks import (
    GOAL,
    LATE,
    RESIDUAL,
    apart,
    apart_at,
    one_ulp_heavier,
    repeated_heavy,
)
from heavy_tops import DOWN, UP, tilted, top
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.heavy_symmetric_top import heavy_symmetric_top, nutation_period
from spincheck.reference.lagrange import lagrange
from spincheck.reference.taylor import FINE_ORDERS, integrate
from taylor_problems import problem
from textbook_periods import heavy_top

pytestmark = pytest.mark.slow

LOOP = top((0.0, 0.4, 3.0), tilted(0.5))
MOTIONS = {
    "loops": LOOP,
    "waves": top((-0.5, 0.1, 3.0), tilted(0.5)),
    "cusps": top((0.0, 0.0, 3.0), tilted(0.5)),
    "cusps, almost steady": top((0.0, 0.0, 300.0), tilted(1.0)),
    "hanging low": top((0.1, 0.2, 3.0), tilted(2.5)),
    "fast": top((0.1, 0.2, 1000.0), tilted(1.0)),
    "thin disc": top((0.1, 0.2, 3.0), tilted(1.0), I3=2.0),
    "nearly a sphere": top((0.1, 0.2, 3.0), tilted(1.0), I3=1.0 + 1e-14),
    "nearly weightless": top((0.1, 0.2, 3.0), tilted(1.0), kappa=1e-6),
    "spherical pendulum": top((0.3, 0.4, 0.0), tilted(2.0)),
    "swing": top((0.0, 0.4, 0.0), tilted(2.0)),
    "over the top": top((0.0, 5.0, 0.0), tilted(0.5)),
    "through the top": top((0.0, 0.5, 2.0), UP),
    "through the bottom": top((0.0, 0.5, 2.0), DOWN),
    "a microradian past the top": top((1e-6, 2.0, 0.5), tilted(0.001)),
    "falling from sleep": top((1e-5, 0.0, 0.2), UP),
    "1 − m = 3e-15": top((0.0, 0.0, 0.2), tilted(1e-7)),
    "asleep but for 1e-6": top((1e-6, 0.0, 5.0), UP),
    "steady to rounding": top((-np.sqrt(0.75), 0.0, 3.0), tilted(np.pi / 3)),
    "a nanoradian from rest": top((1e-9, 0.0, 0.0), (0.0, 1.0, 0.0, 1e-9)),
}


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request):
    p = MOTIONS[request.param]
    return p, lagrange(p), repeated_heavy(p)


@each_case("periods", LATE)
def test_the_motion_is_exact_after_any_number_of_periods(motion, periods):
    p, closed, exact = motion
    assert apart_at(closed, p, exact, periods) < GOAL


def test_the_constants_solve_the_equations(motion):
    assert motion[1].residual < RESIDUAL


def test_period_and_turning_points_are_the_textbooks(motion):
    p, closed, exact = motion
    assert closed.period == pytest.approx(float(exact.period), rel=GOAL)
    assert closed.turning_points == pytest.approx(heavy_top(p).limits, abs=GOAL)


def test_the_period_brings_the_tilt_back(motion):
    # Near the saddle errors of the sixty-digit ODE grow by 1/(1 − m).
    growth = 1 / heavy_top(motion[0]).m1
    assert motion[2].mismatch < RESIDUAL * growth


def test_one_ulp_in_a_moment_would_show():
    neighbour = lagrange(one_ulp_heavier(LOOP))
    assert apart_at(neighbour, LOOP, repeated_heavy(LOOP), LATE[-1]) > GOAL


def test_the_period_is_that_of_the_facts():
    top_of_loop = heavy_symmetric_top(LOOP)
    assert top_of_loop is not None
    assert lagrange(LOOP).period == pytest.approx(nutation_period(top_of_loop), rel=GOAL)


small = st.builds(lambda k, sign: sign * 10.0**k, st.floats(-9.0, -1.0), st.sampled_from((-1, 1)))
component = st.one_of(st.integers(-30, 30).map(lambda n: n / 10), st.floats(0.5, 3.0), small)


@settings(max_examples=60, deadline=None)
@given(
    I3=st.one_of(st.floats(1e-3, 2.0), small.map(lambda e: 1 + e / 2)),
    omega=st.tuples(component, component, component),
    q=st.tuples(*[component] * 4).filter(lambda q: max(map(abs, q)) > 0.0),
    kappa=st.one_of(st.floats(0.01, 10.0), small.map(abs)),
)
def test_any_motion_is_that_of_the_ode(I3, omega, q, kappa):
    """Over twenty radians, in which the ODE's own error of 1e-27 cannot grow to a double's."""
    p = top(omega, q, I3, kappa)
    times = np.linspace(0.0, 20.0 / (np.abs(omega).max() + np.sqrt(kappa)), 21)
    assert apart(closed_form(p).states(times), integrate(p, times, FINE_ORDERS)) < GOAL


@each_case(
    "p",
    [
        problem((1.0, 2.0, 2.5), (1.0, 1.0, 1.0), lever_axes=(0, 0, 1), gravity_world=(0, 0, -1)),
        replace(LOOP, lever_axes=(mpf("1e-9"), mpf(0), mpf(1))),
        replace(LOOP, lever_axes=(mpf(0), mpf(0), mpf(0))),
        replace(LOOP, drag=mpf(1)),
    ],
)
def test_what_is_not_lagranges_is_refused(p):
    with pytest.raises(ValueError, match="symmetric about the lever that gravity alone pulls at"):
        lagrange(p)


@each_case(
    "change",
    [
        {"drag": mpf(1)},
        {"torque_axes": (mpf(0), mpf(0), mpf(1))},
        {"torque_world": (mpf(0), mpf(0), mpf(1))},
        {"moments": (mpf(1), mpf(1) + mpf(10) ** -14, mpf(1) / 2)},
    ],
)
def test_no_closed_form_is_claimed_for_what_has_none(change):
    assert closed_form(LOOP) is not None
    assert closed_form(replace(LOOP, **change)) is None


def test_a_lever_without_gravity_is_a_free_top():
    weightless = replace(LOOP, gravity_world=(mpf(0), mpf(0), mpf(0)))
    times = np.linspace(0.0, 5.0, 11)
    assert apart(closed_form(weightless).states(times), integrate(weightless, times)) < GOAL


def test_precision_is_not_the_callers():
    with mp.workdps(15):
        few = lagrange(LOOP).states(np.array([1e6]))
    with mp.workdps(50):
        many = lagrange(LOOP).states(np.array([1e6]))
    assert apart(few, many) == 0.0
