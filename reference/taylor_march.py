"""The march of a Taylor integrator: one polynomial for each step, evaluated at every sample in it.

Orders up to a bound, the state and the clock are double-doubles; higher orders are doubles. This
suffices because term n of the series is at most e⁻²ⁿ of the state, and its rounding error is
smaller by the same factor.
"""

import math

import numpy as np

from ..scenarios import FloatArray
from .doubledouble import DoubleDouble, dd_add, dd_mul, quick_two_sum, two_sum
from .kernel import allocating, kernel
from .taylor_coefficients import (
    DOWN_AND_RADIUS,
    OMEGA,
    ON_TABLE,
    PRESSED,
    STATE,
    TIP,
    UP,
    WORLD_CONSTANTS,
    WORLD_VECTORS,
    Q,
    Terms,
    extend,
    see_world_vector,
)
from .taylor_numbers import Table, load_double, store, zero

Tables = tuple[FloatArray, FloatArray]

# How a call of `march` ends: all samples are written; the limit of steps is reached; the step is
# too small for the clock, or numbers overflow; or the body leaves its table.
DONE, PAUSED, STUCK, LIFTED = 0, 1, 2, 3

#: Step over radius of convergence that costs least (Jorba & Zou 2005, section 3.2).
STEP = math.exp(-2.0)
#: A coefficient smaller than this may have lost digits to underflow, and is replaced by it.
SMALLEST = 1e-290
#: rad/s; a spin that has decayed below this is set to 0, before underflow spoils it.
STOPPED = 1e-240
#: Number of times in a step at which lift-off from the table is tested, and of halvings of the
#: interval in which it is found. Over a step the series is close to a polynomial of low degree.
LOOKS, HALVINGS = 32, 60
#: A step shorter than this fraction of the time makes no difference on a double-double clock.
CLOCK_TICK = 2.0**-104


@kernel
def row_size(coefficients: FloatArray, n: int, first: int, last: int) -> float:
    """Return the 1-norm of columns first to last − 1 of row n of a series.

    Unlike a maximum it is NaN if any of the numbers is.
    """
    total = 0.0
    for i in range(first, last):
        total += abs(coefficients[n, i])
    return total


@kernel
def step_size(coefficients: FloatArray, order: int) -> float:
    """Return the step, s, at which the last term of the series is e⁻²ᴺ of the state.

    It is computed from the last two of N = `order` orders (Jorba & Zou 2005, section 3). The size
    of the state is 1 for q, and for ω the larger of ‖ω‖ and its change in the step, so that a body
    may start from rest. The step is inf for a body that stays at rest, and 0 where numbers
    overflowed.
    """
    speed = row_size(coefficients, 0, OMEGA, OMEGA + 3)
    gain = row_size(coefficients, 1, OMEGA, OMEGA + 3)
    if speed == 0.0 and gain == 0.0:
        return np.inf
    radius = np.inf
    for n in range(order - 1, order + 1):
        turn = row_size(coefficients, n, Q, Q + 4)
        last = row_size(coefficients, n, OMEGA, OMEGA + 3)
        if not math.isfinite(speed + gain + turn + last):
            return 0.0
        radius = min(radius, max(turn, SMALLEST) ** (-1.0 / n))
        if last > 0.0:
            kept = (speed / last) ** (1.0 / n)
            radius = min(radius, max(kept, (gain / last) ** (1.0 / (n - 1))))
    return STEP * radius


@kernel
def evaluate(
    series: Tables, total: int, paired: int, t: DoubleDouble, state: FloatArray, low: FloatArray
) -> None:
    """Write the state at a time t after the centre of the series, by Horner's rule.

    Parameters
    ----------
    series : Taylor coefficients of the state, high and low parts
    total, paired : number of orders, and how many of them are in double-double
    t : s, high and low part
    state, low : high and low parts of the state, which are written, (STATE,)
    """
    high_orders, low_orders = series
    for i in range(STATE):
        state[i], low[i] = 0.0, 0.0
    for n in range(total, paired, -1):
        for i in range(STATE):
            state[i] = state[i] * t[0] + high_orders[n, i]
    for n in range(paired, -1, -1):
        for i in range(STATE):
            scaled = dd_mul((state[i], low[i]), t)
            state[i], low[i] = dd_add(scaled, (high_orders[n, i], low_orders[n, i]))


@kernel
def _stop_if_stopped(series: Table) -> None:
    speed = 0.0
    for i in range(OMEGA, OMEGA + 3):
        speed += abs(load_double(series, 0, i))
    if speed < STOPPED:
        for i in range(OMEGA, OMEGA + 3):
            store(series, 0, i, zero(series))


@kernel
def start_from_state(series: Table, constants: Table, terms: Terms) -> None:
    """Complete order 0 of a Taylor series, to which the state has been written.

    The vectors that are fixed in the world and in `terms`, such as the vertical, are added, in body
    axes. Under drag, an ω below `STOPPED`, rad/s, is set to 0.

    Parameters
    ----------
    series : Taylor coefficients, a row for each order; only the row of order 0 is used
    constants : constants of the equations of motion
    terms : which terms the equations have
    """
    if terms.linear:
        _stop_if_stopped(series)
    for v in range(len(WORLD_VECTORS)):
        if terms.world_vectors[v]:
            see_world_vector(series, constants, WORLD_CONSTANTS[v], WORLD_VECTORS[v])


@kernel
def _expand(
    series: Tables, constants: Tables, inverses: Tables, terms: Terms, total: int, paired: int
) -> None:
    """Compute orders 1 to `total` of a Taylor series, those up to `paired` in double-double.

    Parameters
    ----------
    series : Taylor coefficients, high and low parts; order 0 has the state
    constants, inverses, terms : what `taylor.constants_of`, `inverses_to` and `terms_of` return
    total, paired : number of orders after order 0, and how many of them are in double-double
    """
    start_from_state(series, constants, terms)
    extend(series, constants, inverses, terms, 0, paired)
    extend(series[0], constants[0], inverses[0], terms, paired, total)


@kernel
def _rests(series: FloatArray, constants: FloatArray, total: int, t: float) -> bool:
    """Whether the table pushes up and the com is above it, at a time t, s, from a step's start.

    `series` has the orders 0 to `total` − 1 of the step, and `constants` are the constants of the
    equations of motion; of both, the high parts alone are given.
    """
    force, along = 0.0, 0.0
    for n in range(total - 1, -1, -1):
        force = force * t + series[n, PRESSED]
        lever = 0.0
        for i in range(3):
            lever += constants[TIP, i] * series[n, UP + i]
        along = along * t + lever
    return force > 0.0 and constants[DOWN_AND_RADIUS, 1] > along


@kernel
def _lifts_off(series: FloatArray, constants: FloatArray, total: int, h: float) -> float:
    """Return the time, from the start of a step of h seconds, at which a body leaves its table.

    It is inf if the body does not leave the table in the step. `series` has the orders 0 to
    `total` − 1 of the step, and `constants` are the constants of the equations of motion; of both,
    the high parts alone are given.
    """
    before = 0.0
    for k in range(LOOKS + 1):
        after = h * k / LOOKS
        if not _rests(series, constants, total, after):
            for _ in range(HALVINGS):
                middle = (before + after) / 2
                if _rests(series, constants, total, middle):
                    before = middle
                else:
                    after = middle
            return after
        before = after
    return np.inf


@allocating
def march(
    constants: Tables,
    inverses: Tables,
    terms: Terms,
    paired: int,
    series: Tables,
    clock: FloatArray,
    times: FloatArray,
    states: Tables,
    first: int,
    steps: int,
) -> tuple[int, int]:
    """Write the states at sample times, from sample `first` on, in a limited number of steps.

    Parameters
    ----------
    constants, inverses, terms : what `taylor.constants_of`, `inverses_to` and `terms_of` return
    paired : number of orders that are in double-double
    series : order 0 has the state at the time `clock`; it is overwritten
    clock : the time, as high and low part, s, (2,); it is advanced
    times : sample times, s, (n,)
    states : high and low parts of the states, which are written, (n, STATE) each
    first : index of the first sample to write
    steps : largest number of steps

    Returns
    -------
    Why the march ended, and the index of the first sample that is not written. The reason is
    `DONE`, `PAUSED` (the limit of steps is reached), `STUCK` (the step is too small for the clock,
    or numbers overflow) or `LIFTED`: the body leaves its table at the time that `clock` then has
    """
    total = series[0].shape[0] - 1
    state, low = np.empty(STATE), np.empty(STATE)
    for _ in range(steps):
        _expand(series, constants, inverses, terms, total, paired)
        h = step_size(series[0], total)
        if not h > CLOCK_TICK * clock[0]:
            return STUCK, first
        if terms.world_vectors[ON_TABLE] and constants[0][DOWN_AND_RADIUS, 2] > 0.0:
            left = _lifts_off(series[0], constants[0], total, min(h, times[-1] - clock[0]))
            if math.isfinite(left):
                clock[0] += left
                return LIFTED, first
        while first < times.size and times[first] <= clock[0] + h:
            s, f = two_sum(times[first], -clock[0])
            inside = quick_two_sum(s, f - clock[1])
            evaluate(series, total, paired, inside, states[0][first], states[1][first])
            first += 1
        if first == times.size:
            return DONE, first
        evaluate(series, total, paired, (h, 0.0), state, low)
        for i in range(STATE):
            store(series, 0, i, (state[i], low[i]))
        t, e = two_sum(clock[0], h)
        clock[0], clock[1] = quick_two_sum(t, e + clock[1])
    return PAUSED, first
