"""Free bodies with three distinct moments, up to and on the separatrix, a million periods on."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form_checks import GOAL, apart
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.free_asymmetric import free_asymmetric
from spincheck.reference.taylor import FINE_ORDERS, integrate
from spincheck.scenarios.exact import product
from taylor_problems import problem
from textbook_periods import DIGITS

pytestmark = pytest.mark.slow

TILTED = (1.0, 0.2, -0.3, 0.4)
#: Three distinct principal axes to spin about, and each order of the moments.
SPINS = [
    problem((2.0, 1.0, 3.0), tuple(2.0 * (k == axis) for k in range(3)), TILTED)
    for axis in range(3)
]


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
