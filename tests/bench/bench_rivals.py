"""Other integrators of the same equations of motion: scipy's DOP853, and heyoka if it is installed.

Euler's equations along the principal axes with gravity as the body sees it, and q' = ½ q ω: what a
user would write down. All take the problem's numbers, rounded to their own precision.
"""

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from mpmath import mp, mpf
from numba import njit
from scipy.integrate import solve_ivp
from spincheck.reference.problem import Problem
from spincheck.scenarios import FloatArray
from spincheck.scenarios.exact import DIGITS

HEYOKA = find_spec("heyoka") is not None
#: Digits that a long double is read from: two more than it has.
LONG_DIGITS = 21

#: ω and q at times (n,): (n, 7) double or long double.
Solver = Callable[[FloatArray], np.ndarray]


class Constants(NamedTuple):
    """Of the equations, in any arithmetic: (Ij − Ik)/Ii and l/I by axis, and g in world axes.

    Whether the top is heavy spares a free one what comes to nothing.
    """

    heavy: bool
    euler: Sequence[Any]
    next_: Sequence[Any]
    after: Sequence[Any]
    gravity: Sequence[Any]


def constants(problem: Problem, kind: type) -> Constants:
    """Rounded once, from sixty digits."""
    cyclic = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    moments, lever = problem.moments, problem.lever_axes
    with mp.workdps(DIGITS):
        return Constants(
            any(lever) and any(problem.gravity_world),
            [rounded((moments[j] - moments[k]) / moments[i], kind) for i, j, k in cyclic],
            [rounded(lever[j] / moments[i], kind) for i, j, k in cyclic],
            [rounded(-lever[k] / moments[i], kind) for i, j, k in cyclic],
            [rounded(g, kind) for g in problem.gravity_world],
        )


def rounded(x: mpf, kind: type) -> Any:
    """The number of a type nearest to x."""
    return kind(mp.nstr(x, LONG_DIGITS, min_fixed=0, max_fixed=0))


def rates(y: Sequence[Any], c: Constants) -> list[Any]:
    """ω' and q' in whatever the numbers are: floats, or heyoka's expressions."""
    w1, w2, w3, q0, q1, q2, q3 = y
    spin1, spin2, spin3 = c.euler[0] * w2 * w3, c.euler[1] * w3 * w1, c.euler[2] * w1 * w2
    if c.heavy:
        g = c.gravity
        # Gravity as the body sees it: the columns of the rotation matrix times g.
        gamma1 = (q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3) * g[0]
        gamma1 = gamma1 + 2 * (q1 * q2 + q0 * q3) * g[1] + 2 * (q1 * q3 - q0 * q2) * g[2]
        gamma2 = (q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3) * g[1]
        gamma2 = gamma2 + 2 * (q1 * q2 - q0 * q3) * g[0] + 2 * (q2 * q3 + q0 * q1) * g[2]
        gamma3 = (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3) * g[2]
        gamma3 = gamma3 + 2 * (q1 * q3 + q0 * q2) * g[0] + 2 * (q2 * q3 - q0 * q1) * g[1]
        spin1 = spin1 + c.next_[0] * gamma3 + c.after[0] * gamma2
        spin2 = spin2 + c.next_[1] * gamma1 + c.after[1] * gamma3
        spin3 = spin3 + c.next_[2] * gamma2 + c.after[2] * gamma1
    return [
        spin1,
        spin2,
        spin3,
        (q1 * w1 + q2 * w2 + q3 * w3) * -0.5,
        (q0 * w1 + q2 * w3 - q3 * w2) * 0.5,
        (q0 * w2 + q3 * w1 - q1 * w3) * 0.5,
        (q0 * w3 + q1 * w2 - q2 * w1) * 0.5,
    ]


def start(problem: Problem, kind: type) -> np.ndarray:
    """ω and q at t = 0, (7,)."""
    values = (*problem.omega_axes, *problem.q_world_axes)
    return np.array([rounded(x, kind) for x in values], dtype=kind)


def dop853(problem: Problem, tolerance: float, compiled: bool) -> Solver:
    """Scipy's, its right side in Python floats or compiled by numba."""
    c, y0 = constants(problem, float), start(problem, float)

    def in_python(_: float, y: FloatArray) -> list[float]:
        return rates(y.tolist(), c)

    right_side: Callable[..., Any] = in_python
    if compiled:
        frozen = Constants(c.heavy, *(tuple(row) for row in c[1:]))
        shared = njit(rates)

        @njit  # type: ignore[untyped-decorator]
        def by_numba(_: float, y: FloatArray) -> FloatArray:
            return np.array(shared((y[0], y[1], y[2], y[3], y[4], y[5], y[6]), frozen))

        right_side = by_numba

    def solve(times: FloatArray) -> np.ndarray:
        solved = solve_ivp(
            right_side, (0, times[-1]), y0, "DOP853", times, rtol=tolerance, atol=tolerance
        )
        return np.asarray(solved.y.T)

    return solve


def heyoka(problem: Problem, kind: type) -> Solver:
    """Its Taylor integrator at the precision of a type, compiled once, with compensated sums."""
    import heyoka as hy

    symbols = hy.make_vars("w1", "w2", "w3", "q0", "q1", "q2", "q3")
    y0 = start(problem, kind)
    heavy, *numbers = constants(problem, kind)
    # Wrapped, for numpy's scalars would take the product upon themselves.
    c = Constants(heavy, *([hy.expression(x) for x in column] for column in numbers))
    right_sides = rates(symbols, c)
    integrator = hy.taylor_adaptive(
        list(zip(symbols, right_sides, strict=True)), y0, fp_type=kind, high_accuracy=True
    )

    def solve(times: FloatArray) -> np.ndarray:
        integrator.time = kind(0)
        integrator.state[:] = y0
        return np.asarray(integrator.propagate_grid(times.astype(kind))[-1])

    return solve
