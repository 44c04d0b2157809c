"""What the series leaves out is within its bound, and no ulp of a double after a thousand periods.

That the equations are right, term by term: `test_taylor_independent`.
"""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mpf
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    integrate,
    integrate_double_double,
)
from taylor_problems import apart, problem, truncation

EPS = float(np.finfo(float).eps)
TIMES = np.array([0.0, 0.7, 1.9, 10.0])

ASYMMETRIC = problem((1.0, 1.3, 0.7), (0.5, -1.0, 3.0))
PUSHED = replace(ASYMMETRIC, torque_world=(mpf(1) / 4, mpf(-2), mpf(3) / 8))
HEAVY = problem(
    (1.0, 1.3, 0.7), (0.5, 1.0, 3.0), lever_axes=(0.2, 0.1, 0.9), gravity_world=(0, 0, -1)
)

#: Not chaotic: its errors grow as a power of time.
REGULAR = replace(HEAVY, q_world_axes=(mpf(24) / 25, mpf(0), mpf(7) / 25, mpf(0)))


def faster(p: Problem) -> Problem:
    """The problem with its start changed by one ulp."""
    w1, w2, w3 = (w * (1 + mpf(EPS)) for w in p.omega_axes)
    return replace(p, omega_axes=(w1, w2, w3))


@pytest.mark.parametrize("p", [ASYMMETRIC, HEAVY, PUSHED], ids=["free", "heavy", "pushed"])
def test_what_the_orders_leave_out_is_within_the_stated_bound(p: Problem) -> None:
    coarse, exact_motion, fine = (
        integrate_double_double(p, TIMES, orders)
        for orders in (CHECK_ORDERS, TRUTH_ORDERS, FINE_ORDERS)
    )
    assert apart(exact_motion, fine) < truncation(TRUTH_ORDERS)
    assert apart(coarse, fine) < truncation(CHECK_ORDERS)
    assert apart(coarse, fine) > truncation(FINE_ORDERS)


@pytest.mark.parametrize("p", [ASYMMETRIC, REGULAR], ids=["free", "heavy"])
def test_doubles_are_right_to_the_last_digit_after_a_thousand_periods(p: Problem) -> None:
    times = np.array([7500.0])
    exact_motion, fine = (integrate_double_double(p, times, o) for o in (TRUTH_ORDERS, FINE_ORDERS))
    rounding = EPS / 2
    assert apart(exact_motion, fine) < rounding
    assert apart(integrate_double_double(faster(p), times), fine) > rounding


def test_rounded_states_are_the_high_parts() -> None:
    q_world_axes, omega_axes = integrate(HEAVY, TIMES)
    states = integrate_double_double(HEAVY, TIMES)
    np.testing.assert_array_equal(q_world_axes, states.q_world_axes)
    np.testing.assert_array_equal(omega_axes, states.omega_axes)
