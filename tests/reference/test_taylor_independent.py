"""Every term of the equations, against the second derivation.

All are compared at once, and none; that each counts shows where it is off by an ulp.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from mpmath import mp, mpf
from second_derivation import DIGITS, State, of_problem, rotation
from spincheck.reference.taylor import TRUTH_ORDERS, integrate_double_double
from taylor_problems import distance, problem, q_and_omega, truncation

pytestmark = pytest.mark.slow

#: s; a dozen steps of the series and more.
DURATION = 2.0
#: 1/s, at the most.
RATE = 4.0
EPS = float(np.finfo(float).eps)
BOUND = truncation(TRUTH_ORDERS)

FREE = problem((1.0, 1.3, 0.7), (0.5, -1.0, 2.0))
TERMS: dict[str, dict[str, object]] = {
    "free": {},
    "everything": {
        "lever_axes": (mpf(1) / 5, -mpf(1) / 8, mpf(1) / 2),
        "gravity_world": (mpf(2), -mpf(4), mpf(9)),
        "torque_axes": (mpf(1) / 3, -mpf(1) / 2, mpf(2) / 3),
        "torque_world": (-mpf(1) / 7, mpf(2), mpf(1) / 2),
        "drag": mpf(1) / 9,
        "kept": (mpf(1) / 3, -mpf(2)),
        "kept_axes": ((mpf(3) / 5, mpf(0), mpf(4) / 5), (mpf(0), mpf(1), mpf(0))),
    },
}


@cache
def second_solution(name: str) -> State:
    """The state after `DURATION`."""
    (state,) = of_problem(replace(FREE, **TERMS[name])).motion([DURATION], RATE)
    return state


@pytest.mark.parametrize("name", ["free", "everything"])
def test_the_motion_is_that_of_a_second_derivation(name: str) -> None:
    p = replace(FREE, **TERMS[name])
    q, omega = q_and_omega(integrate_double_double(p, np.array([DURATION])), 0)
    with mp.workdps(DIGITS):
        second = second_solution(name)
        assert distance(omega, second.omega) < BOUND
        assert distance(rotation(q).ravel(), second.R.ravel()) < BOUND


def times_ulp(value: object, ulp: mpf) -> object:
    """A number, or all numbers of a tuple, times a factor."""
    return tuple(times_ulp(x, ulp) for x in value) if isinstance(value, tuple) else value * ulp


@pytest.mark.parametrize("name", sorted(TERMS["everything"]))
def test_every_term_shows_when_it_is_off_by_one_ulp(name: str) -> None:
    p = replace(FREE, **TERMS["everything"])
    nudged = times_ulp(getattr(p, name), 1 + mpf(EPS))
    states = integrate_double_double(replace(p, **{name: nudged}), np.array([DURATION]))
    with mp.workdps(DIGITS):
        assert distance(q_and_omega(states, 0)[1], second_solution("everything").omega) > BOUND
