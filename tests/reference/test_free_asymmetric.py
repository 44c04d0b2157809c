"""Free bodies with three distinct moments, up to and on the separatrix, a million periods on."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form_checks import (
    GOAL,
    LATE,
    RESIDUAL,
    apart,
    apart_at,
    one_ulp_heavier,
    repeated_free,
)
from extended_motion import ExtendedMotion
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.free_asymmetric import free_asymmetric
from spincheck.reference.taylor import FINE_ORDERS, integrate
from spincheck.scenarios.exact import product
from taylor_problems import problem
from textbook_periods import DIGITS, free_body

pytestmark = pytest.mark.slow

TILTED = (1.0, 0.2, -0.3, 0.4)
GENERIC = problem((1.0, 2.0, 3.0), (0.3, 0.5, 1.0), TILTED)
#: ω circulates about the third axis; 1 − m down to 2e-14, moments equal to 1e-14.
MOTIONS = {
    "about the largest moment": GENERIC,
    "about the smallest moment": problem((3.0, 2.0, 1.0), (-0.3, 0.5, 1.0), TILTED),
    "backwards": problem((1.0, 2.0, 3.0), (0.3, -0.5, -1.0), TILTED),
    "1 − m = 1e-6": problem((1.0, 2.0, 3.0), (1e-3, 1.0, 8e-4), TILTED),
    "1 − m = 2e-14": problem((2.0, 3.0, 6.0), (3.0, 1.0, 1.0 + 1e-14), TILTED),
    "below the separatrix": problem((6.0, 3.0, 2.0), (1.0 - 1e-14, 1.0, 3.0), TILTED),
    "tennis racket": problem((1.0, 2.0, 3.0), (1e-8, 1.0, 2e-8), TILTED),
    "nearly oblate": problem((1.0, 1.0 + 1e-14, 2.0), (0.3, 0.4, 0.5), TILTED),
    "nearly prolate": problem((1.0, 1.0 - 1e-14, 0.5), (0.3, 0.4, 0.5), TILTED),
    "nearly steady": problem((1.0, 2.0, 3.0), (1e-9, 1e-9, 1.0), TILTED),
    "starting flat": problem((1.0, 2.0, 3.0), (0.5, 0.0, 1.0), TILTED),
}
#: 2 (3 − 2) 3² = 6 (6 − 3) 1²: L² = 2 E I2, in doubles. All four branches, and both orders.
SEPARATRICES = {
    "++": problem((2.0, 3.0, 6.0), (3.0, 1.0, 1.0), TILTED),
    "+-": problem((2.0, 3.0, 6.0), (3.0, 1.0, -1.0), TILTED),
    "-+": problem((2.0, 3.0, 6.0), (-3.0, -1.0, 1.0), TILTED),
    "--": problem((2.0, 3.0, 6.0), (-3.0, 0.0, -1.0), TILTED),
    "reversed": problem((6.0, 3.0, 2.0), (1.0, -1.0, 3.0), TILTED),
}
#: Three distinct principal axes to spin about, and each order of the moments.
SPINS = [
    problem((2.0, 1.0, 3.0), tuple(2.0 * (k == axis) for k in range(3)), TILTED)
    for axis in range(3)
]


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request):
    p = MOTIONS[request.param]
    return p, free_asymmetric(p), repeated_free(p)


@pytest.mark.parametrize("periods", LATE)
def test_the_motion_is_exact_after_any_number_of_periods(motion, periods):
    p, closed, exact_motion = motion
    assert apart_at(closed, p, exact_motion, periods) < GOAL


def test_the_constants_solve_the_equations(motion):
    assert motion[1].residual < RESIDUAL


def test_the_period_is_the_textbooks(motion):
    p, closed, exact_motion = motion
    book = free_body(p)
    with mp.workdps(DIGITS):
        assert closed.period == pytest.approx(float(4 * book.K / book.p), rel=GOAL)
    assert exact_motion.mismatch < RESIDUAL  # and brings |A| and |B| back


def test_one_ulp_in_a_moment_would_show():
    neighbour = free_asymmetric(one_ulp_heavier(GENERIC))
    assert apart_at(neighbour, GENERIC, repeated_free(GENERIC), LATE[-1]) > GOAL


def test_sn_cn_dn_are_a_motion():
    """Problem B5 of DETEST (Hull & Enright et al., SIAM J. Numer. Anal. 9 (1972) 603).

    y1' = y2 y3, y2' = −y1 y3, y3' = −0.51 y1 y2 from (0, 1, 1) are Euler's equations of a plate,
    I2 = I1 + I3 and (I1 − I3)/I2 = 0.51, for y = (ω1, ω3, ω2).
    """
    times = np.array([0.0, 0.5, 1.0, 2.0, 5.0, 20.0, 1e4])
    with mp.workdps(DIGITS):
        plate = tuple(mpf(i) / 100 for i in (151, 200, 49))
        y = [
            [mp.ellipfun(name, mpf(t), m=mpf(51) / 100) for name in ("sn", "dn", "cn")]
            for t in times
        ]
    p = replace(problem((1.0, 1.0, 1.0), (0.0, 1.0, 1.0)), moments=plate)
    _, omega = free_asymmetric(p).states(times)
    assert np.abs(omega - np.array(y, dtype=float)).max() < GOAL


def exact_separatrix(p, times):
    """In sixty digits, by the ODE; the poles of sech(p t) are π/2p from the real axis."""
    book = free_body(p)
    with mp.workdps(DIGITS):
        rate = mp.sqrt(mp.fdot(p.omega_axes, p.omega_axes))
        motion = ExtendedMotion(p, mp.pi / 2 / book.p, rate, mpf(times[-1]) * mpf("1.01"))
    states = [motion.state(mpf(t)) for t in times]
    return tuple(np.array([s[k] for s in states], dtype=float) for k in range(2))


@pytest.mark.parametrize("p", SEPARATRICES.values(), ids=SEPARATRICES)
def test_the_separatrix_is_exact_until_it_has_come_to_rest_on_the_saddle(p):
    times = np.linspace(0.0, 20.0, 11)
    assert apart(free_asymmetric(p).states(times), exact_separatrix(p, times)) < GOAL


@pytest.mark.parametrize("p", SEPARATRICES.values(), ids=SEPARATRICES)
def test_the_separatrix_never_leaves_the_saddle(p):
    _, omega = free_asymmetric(p).states(np.array([1e3, 1e9]))
    assert np.abs(omega[:, [0, 2]]).max() < GOAL
    assert free_asymmetric(p).period == np.inf


def test_a_motion_next_to_the_separatrix_leaves():
    neighbour = free_asymmetric(one_ulp_heavier(SEPARATRICES["++"]))
    _, omega = neighbour.states(np.linspace(0.0, 1e3, 1001))
    assert np.abs(omega[500:, 0]).max() > 1


@pytest.mark.parametrize("p", SPINS, ids=["middle", "smallest", "largest"])
def test_a_spin_about_a_principal_axis_stays_one(p):
    closed = free_asymmetric(p)
    q, omega = closed.states(np.array([0.0, np.pi / 2, 1e9]))
    assert (omega == np.array(p.omega_axes, dtype=float)).all()
    half_a_turn = product(p.q_world_axes, (0, *(w / 2 for w in p.omega_axes)))
    assert np.abs(q[1] - np.array(half_a_turn, dtype=float)).max() < GOAL


#: Sizes of small differences, of either sign.
small = st.builds(lambda k, sign: sign * 10.0**k, st.floats(-12.0, -1.0), st.sampled_from((-1, 1)))
component = st.one_of(st.integers(-30, 30).map(lambda n: n / 10), st.floats(0.5, 3.0), small)
bodies = st.one_of(
    st.tuples(st.floats(0.1, 1.0), st.floats(0.1, 1.0), st.floats(0.01, 0.99)).map(
        lambda v: (v[0], v[1], abs(v[0] - v[1]) + v[2] * (v[0] + v[1] - abs(v[0] - v[1])))
    ),
    st.tuples(st.floats(0.3, 1.0), small, small).map(
        lambda v: (v[0], v[0] * (1 + v[1] / 4), v[0] * (1 + v[2] / 4))
    ),
    st.tuples(st.floats(0.3, 1.0), st.floats(0.3, 1.0), small).map(
        lambda v: (v[0], v[1], (v[0] + v[1]) * (1 - abs(v[2]) / 2))
    ),
).flatmap(st.permutations)


@settings(max_examples=60, deadline=None)
@given(
    moments=bodies, omega=st.tuples(component, component, component), q=st.tuples(*[component] * 4)
)
def test_any_motion_is_that_of_the_ode(moments, omega, q):
    """Over twenty radians, in which the ODE's own error of 1e-27 cannot grow to a double's."""
    speed = max(map(abs, omega))
    if not (speed > 0 and np.linalg.norm(q) > 0):
        return
    p = problem(moments, omega, q)
    times = np.linspace(0.0, 20.0 / speed, 21)
    assert apart(closed_form(p).states(times), integrate(p, times, FINE_ORDERS)) < GOAL


@pytest.mark.parametrize(
    "p",
    [
        problem((1.0, 2.0, 2.0), (1.0, 1.0, 1.0)),
        replace(GENERIC, drag=mpf(1)),
        replace(GENERIC, lever_axes=(0, 0, mpf(1)), gravity_world=(0, 0, mpf(-9))),
    ],
    ids=["symmetric", "drag", "heavy"],
)
def test_what_is_not_free_and_asymmetric_is_refused(p):
    with pytest.raises(ValueError, match="must be a free body with three distinct moments"):
        free_asymmetric(p)
