"""The march of a motion together with its derivative by one parameter, in duals.

The recurrences of `taylor_coefficients`, computed in duals, are the variational equations, term by
term (docs/explanation/sensitivities.md). Only the terms of a change δI of the inertia are added
here. The axes stay those in which I is diagonal; δI need not be diagonal in them::

    I δω' = … − δI ω' + (δI ω) × ω
"""

import math

import numpy as np

from ..scenarios import FloatArray
from .doubledouble import quick_two_sum, two_sum
from .dual_numbers import Dual
from .kernel import allocating, kernel
from .taylor_coefficients import (
    COLUMNS,
    INVERSE_MOMENT,
    OMEGA,
    OTHER,
    STATE,
    Q,
    Terms,
    cross_omega,
    extend,
    support,
)
from .taylor_march import (
    CLOCK_TICK,
    DONE,
    PAUSED,
    SMALLEST,
    STEP,
    STUCK,
    evaluate,
    row_size,
    start_from_state,
    step_size,
)
from .taylor_numbers import (
    Table,
    add,
    add_product,
    load,
    multiply,
    negative,
    rounded,
    store,
    zero,
)

#: First column of δI ω in the series of the motion, and number of columns of that series in all.
MOVED, WIDTH = COLUMNS, COLUMNS + 3
#: Row that holds n, in the table whose other rows are 1/n and 1/(2n).
COUNT = 2
#: A step is chosen by the last terms of a derivative relative to its first 1/`LOWER` of all terms.
LOWER = 4


@kernel
def _move(series: Dual, tensor: Table, n: int) -> None:
    """Write the n-th Taylor coefficient of δI ω into `series`, which has that of ω.

    `tensor` is δI, the derivative of the inertia.
    """
    for i in range(3):
        moved = zero(series.value)
        for j in range(3):
            moved = add_product(moved, load(tensor, i, j), load(series.value, n, OMEGA + j))
        store(series.value, n, MOVED + i, rounded(moved))


@kernel
def _add_inertia(
    series: Dual, constants: Dual, inverses: Dual, terms: Terms, tensor: Table, n: int
) -> None:
    """Add what a change δI of the inertia contributes to order n of δω' and order n + 1 of δω.

    The orders are those of Taylor series, and δω is the derivative of ω. Order n of ω', and of δω'
    at constant inertia, must be known.

    Parameters
    ----------
    series : Taylor coefficients of state and derivative, which are written
    constants, inverses : the constants of the equations, and the table of 1/n, 1/(2n) and n, each
        with its derivative as the tangent
    terms : which terms the equations of motion have
    tensor : δI, the derivative of the tensor of inertia, kg m², principal axes, (3, 3)
    n : the order
    """
    _move(series, tensor, n + 1)
    turned = cross_omega(series.value, MOVED, n)
    for i in range(3):
        moved = multiply(load(inverses.value, COUNT, n + 1), load(series.value, n + 1, MOVED + i))
        torque = add(turned[i], negative(moved))
        rate, factor = load(series, n, OTHER + i), load(constants.value, INVERSE_MOMENT, i)
        rate = Dual(rate.value, add(rate.tangent, multiply(factor, torque)))
        store(series, n, OTHER + i, rate)
        store(series, n + 1, OMEGA + i, multiply(load(inverses, 0, n + 1), rate))
    support(series, constants, inverses, terms, n)


@kernel
def _extend_with_inertia(
    series: Dual,
    constants: Dual,
    inverses: Dual,
    terms: Terms,
    tensor: Table,
    first: int,
    last: int,
) -> None:
    for n in range(first, last):
        extend(series, constants, inverses, terms, n, n + 1)
        _add_inertia(series, constants, inverses, terms, tensor, n)


@kernel
def _tangent_step(tangent: FloatArray, order: int) -> float:
    """Return the step, s, at which the last two terms of the derivative's series are small.

    `tangent` has the terms of orders 0 to `order`, one in each row. Term n must be at most e⁻²⁽ⁿ⁻ᵏ⁾
    of one of the lower terms k, for ω and for q. It is not compared with term 0 alone, because that
    may be zero: a derivative may be zero at first, and that of a body at rest may grow. The step is
    0 if one of these terms is not finite.
    """
    radius = np.inf
    for first, last in ((OMEGA, OMEGA + 3), (Q, Q + 4)):
        for n in range(order - 1, order + 1):
            size = row_size(tangent, n, first, last)
            if not math.isfinite(size):
                return 0.0
            nearest = 0.0
            for k in range(order // LOWER):
                lower = row_size(tangent, k, first, last)
                nearest = max(nearest, (lower / max(size, SMALLEST)) ** (1.0 / (n - k)))
            if nearest > 0.0 and size > 0.0:
                radius = min(radius, nearest)
    return STEP * radius


@allocating
def march_with_tangent(
    constants: Dual,
    inverses: Dual,
    terms: Terms,
    tensor: Table,
    paired: int,
    series: Dual,
    clock: FloatArray,
    times: FloatArray,
    states: FloatArray,
    tangents: FloatArray,
    first: int,
    steps: int,
) -> tuple[int, int]:
    """Write states and their derivatives by one parameter at sample times, from `first` on.

    It does what `taylor_march.march` does, but it does not detect that a body leaves its table.

    Parameters
    ----------
    constants, inverses : the constants of the equations, and the table of 1/n, 1/(2n) and n, each
        with its derivative by the parameter as the tangent
    terms : which terms the equations of motion have
    tensor : δI, the derivative of the tensor of inertia, kg m², principal axes, (3, 3)
    paired : number of orders that are in double-double
    series : order 0 has the state and its derivative at the time `clock`; it is overwritten
    clock : the time, as high and low part, s, (2,); it is advanced
    times : sample times, s, (n,)
    states, tangents : the states and their derivatives, doubles, which are written, (n, STATE) each
    first : index of the first sample to write
    steps : largest number of steps

    Returns
    -------
    Why the march ended, and the index of the first sample that is not written. The reason is
    `DONE`, `PAUSED` (the limit of steps is reached) or `STUCK` (the step is too small for the
    clock, or numbers overflow)
    """
    total = series.value[0].shape[0] - 1
    state, low = np.empty(STATE), np.empty(STATE)
    tangent, tangent_low = np.empty(STATE), np.empty(STATE)
    rounded_series = Dual(series.value[0], series.tangent[0])
    rounded_constants = Dual(constants.value[0], constants.tangent[0])
    rounded_inverses = Dual(inverses.value[0], inverses.tangent[0])
    for _ in range(steps):
        start_from_state(series, constants, terms)
        _move(series, tensor, 0)
        _extend_with_inertia(series, constants, inverses, terms, tensor, 0, paired)
        _extend_with_inertia(
            rounded_series, rounded_constants, rounded_inverses, terms, tensor[0], paired, total
        )
        h = min(step_size(series.value[0], total), _tangent_step(series.tangent[0], total))
        if not h > CLOCK_TICK * clock[0]:
            return STUCK, first
        while first < times.size and times[first] <= clock[0] + h:
            s, f = two_sum(times[first], -clock[0])
            inside = quick_two_sum(s, f - clock[1])
            evaluate(series.value, total, paired, inside, states[first], low)
            evaluate(series.tangent, total, paired, inside, tangents[first], tangent_low)
            first += 1
        if first == times.size:
            return DONE, first
        evaluate(series.value, total, paired, (h, 0.0), state, low)
        evaluate(series.tangent, total, paired, (h, 0.0), tangent, tangent_low)
        for i in range(STATE):
            store(series, 0, i, Dual((state[i], low[i]), (tangent[i], tangent_low[i])))
        t, e = two_sum(clock[0], h)
        clock[0], clock[1] = quick_two_sum(t, e + clock[1])
    return PAUSED, first
