"""Integrates the motion of a top to the last digits of a double, by mixed-precision Taylor series.

docs/explanation/ode.md describes the equations and the accuracy.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from mpmath import mpf, workprec
from numpy.typing import NDArray

from ..scenarios import FloatArray
from .doubledouble import split
from .effect_terms import TERMS, turning
from .kernel import as_kernels_take
from .problem import Problem
from .taylor_coefficients import (
    AFTER,
    COLUMNS,
    EULER,
    INVERSE_MOMENT,
    NEXT,
    OMEGA,
    ROWS,
    STATE,
    Q,
    Terms,
)
from .taylor_march import LIFTED, PAUSED, STUCK, Tables, march

#: Most steps of an integration. A step takes 2 to 10 µs; more would take minutes, which no study
#: waits for.
MAX_STEPS = 20_000_000
#: The integration is given up if, at the mean step so far, it would take this many times
#: `MAX_STEPS`: only a motion that slows down by that factor could still finish.
HOPELESS = 2
#: Steps between checks for Ctrl-C: compiled code cannot be interrupted.
STEPS_AT_ONCE = 100_000
# Bits that hold (I₂ − I₃)/I₁ even for doubles that differ in the last bit only, at any scale met in
# practice.
_CONSTANT_BITS = 400


class IntegrationError(ArithmeticError):
    """A motion cannot be integrated over the time span that was asked for."""


class LiftOffError(IntegrationError):
    """A body leaves its table.

    Attributes
    ----------
    time : when the table would have to pull, or the com is no longer above it, s
    """

    def __init__(self, time: float) -> None:
        where = f"at {time:.6g} s"
        super().__init__(
            f"The body leaves the table, or falls flat on it, {where}. Ask for earlier times."
        )
        self.time = time


class Orders(NamedTuple):
    """Number of orders of a Taylor series, and how many of them are computed in double-double."""

    total: int
    double_double: int


#: The orders of the solution, and those of two series it is compared with: the cheaper series
#: bounds its error from above, the more expensive one measures it.
TRUTH_ORDERS = Orders(28, 10)
CHECK_ORDERS = Orders(22, 6)
FINE_ORDERS = Orders(34, 18)


@dataclass(frozen=True, eq=False)
class DoubleDoubleStates:
    """Attitude and angular velocity in double-double: each number is the sum of two doubles.

    Attributes
    ----------
    q_world_axes, q_low : high and low parts of attitudes, w x y z, (n, 4)
    omega_axes, omega_low : high and low parts of ω along the principal axes, rad/s, (n, 3)
    """

    q_world_axes: FloatArray
    omega_axes: FloatArray
    q_low: FloatArray
    omega_low: FloatArray


def integrate(
    problem: Problem, times: FloatArray, orders: Orders = TRUTH_ORDERS
) -> tuple[FloatArray, FloatArray]:
    """Return the motion at given times, rounded to double.

    Parameters
    ----------
    times : (n,) s, not decreasing, from 0 on; the problem's state is the one at t = 0
    orders : number of orders of the series, in all and in double-double

    Returns
    -------
    q_world_axes, (n, 4), w x y z, and omega_axes, (n, 3), rad/s

    Raises
    ------
    ValueError
        If the times decrease, are negative or are not finite.
    IntegrationError
        If numbers overflow or the motion takes more than `MAX_STEPS` steps.
    LiftOffError
        If a body leaves its table by the last of these times.
    """
    states = integrate_double_double(problem, times, orders)
    return states.q_world_axes, states.omega_axes


def integrate_double_double(
    problem: Problem, times: FloatArray, orders: Orders = TRUTH_ORDERS
) -> DoubleDoubleStates:
    """Return the motion at given times in double-double.

    The errors raised are those of `integrate`.

    Parameters
    ----------
    times : (n,) s, not decreasing, from 0 on; the problem's state is the one at t = 0
    orders : number of orders of the series, in all and in double-double
    """
    times = as_kernels_take(times)
    if not (np.isfinite(times).all() and (times >= 0).all() and (np.diff(times) >= 0).all()):
        raise ValueError("'times' must be finite, not negative and not decreasing.")
    states = np.zeros((len(times), STATE)), np.zeros((len(times), STATE))
    _march(problem, times, orders, states)
    for part in states:
        part.flags.writeable = False
    (q, q_low), (omega, omega_low) = (
        [part[:, first:last] for part in states] for first, last in ((Q, Q + 4), (OMEGA, OMEGA + 3))
    )
    return DoubleDoubleStates(q, omega, q_low, omega_low)


def _march(problem: Problem, times: FloatArray, orders: Orders, states: Tables) -> None:
    constants, terms = constants_of(problem), terms_of(problem)
    inverses = inverses_to(orders.total)
    series = np.zeros((orders.total + 1, COLUMNS)), np.zeros((orders.total + 1, COLUMNS))
    for column, x in enumerate((*problem.omega_axes, *problem.q_world_axes)):
        series[0][0, column], series[1][0, column] = split(x)
    clock = np.zeros(2)
    sample, steps, outcome = 0, 0, PAUSED
    while outcome == PAUSED:
        expected = steps * times[-1] / clock[0] if steps else 0.0
        if steps >= MAX_STEPS or expected > HOPELESS * MAX_STEPS:
            raise IntegrationError(
                f"The motion takes more than {MAX_STEPS} steps: {times[-1]} s were asked for, "
                f"{clock[0]} s reached. Ask for a shorter span: its fastest rate sets the step."
            )
        outcome, sample = march(
            constants,
            inverses,
            terms,
            orders.double_double,
            series,
            clock,
            times,
            states,
            sample,
            min(STEPS_AT_ONCE, MAX_STEPS - steps),
        )
        steps += STEPS_AT_ONCE
    if outcome == LIFTED:
        raise LiftOffError(float(clock[0]))
    if outcome == STUCK:
        raise IntegrationError(
            f"The motion leaves the range of doubles at {clock[0]} s: it is too fast for its "
            "unit of time. Ask for a shorter span, or measure time in a shorter unit."
        )


def terms_of(problem: Problem, effects: Iterable[str] | None = None) -> Terms:
    """Return which terms of the equations of motion some effects need.

    Parameters
    ----------
    effects : names of the effects; by default those that turn the body of the problem
    """
    forms = {TERMS[name].form for name in (turning(problem) if effects is None else effects)}
    vectors = "lever" in forms, "world" in forms, "plane" in forms
    return Terms(world_vectors=vectors, linear="linear" in forms, momentum="momentum" in forms)


def constants_of(problem: Problem) -> Tables:
    """Return the constants of the equations of motion, as high and low parts, rounded once.

    They are (ROWS, 3) each; the rows are named in `taylor_coefficients`.
    """
    return tables(_exact_constants(problem))


def derived_constants(problem: Problem, changed: Problem) -> Tables:
    """Return the derivatives of the constants of `constants_of` by a number they are linear in.

    They are high and low parts, (ROWS, 3) each.

    Parameters
    ----------
    changed : the problem with this number larger by one unit
    """
    with workprec(_CONSTANT_BITS):
        return tables(_exact_constants(changed) - _exact_constants(problem))


def _exact_constants(problem: Problem) -> NDArray[np.object_]:
    moments, rows = problem.moments, np.full((ROWS, 3), mpf(0))
    with workprec(_CONSTANT_BITS):
        for i, j, k in zip(range(3), NEXT, AFTER, strict=True):
            rows[EULER, i] = (moments[j] - moments[k]) / moments[i]
            rows[INVERSE_MOMENT, i] = 1 / moments[i]
            for terms in TERMS.values():
                for row, value in terms.constants(problem, i, j, k).items():
                    rows[row, i] = value
    return rows


@cache
def inverses_to(order: int) -> Tables:
    """Return 1/n in row 0 and 1/(2n) in row 1, for column n up to `order`, as high and low parts.

    Column 0 is not used.
    """
    with workprec(_CONSTANT_BITS):
        return tables(
            [[mpf(0)] + [1 / mpf(factor * n) for n in range(1, order + 1)] for factor in (1, 2)]
        )


def tables(rows: Iterable[Iterable[mpf]]) -> Tables:
    """Return rows of extended-precision numbers as two arrays, their high and their low parts."""
    pairs = np.array([[split(x) for x in row] for row in rows])
    return np.ascontiguousarray(pairs[..., 0]), np.ascontiguousarray(pairs[..., 1])
