"""Integrates equations of motion that need not be a scene's, by integrators known to this module.

All numbers are plain doubles. If the equations are a scene's, the integrator `EXACT` agrees with
`flow` to some ulp (tests).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853, RK45

from ..scenarios import FloatArray
from .kernel import allocating, as_kernels_take, called, kernel
from .other_equations import OtherEquations
from .other_rates import (
    INERTIA,
    KEPT,
    RATE,
    Vector,
    all_numbers,
    by_tensor,
    dot,
    plus,
    put,
    rates_of,
    rotation_of,
    turning,
    vector,
)

#: Largest turn in a step of `EXACT` and of `APPROXIMATE`, rad. The error of a step of `EXACT` is
#: then an ulp.
TURN = 0.2
#: Number of columns of a Runge-Kutta stage, which are q', ω' and the angular velocity at which the
#: attitude turns; and the first column of this angular velocity.
STAGE, TURNS = 10, 7


class Integrator(NamedTuple):
    """A one-step method for q and ω, rad/s, along body axes.

    Whether an engine normalises its quaternions makes no difference to the attitudes that they
    represent: q' is linear in q.

    Attributes
    ----------
    name : name of the integrator
    a, b : coefficients of an explicit Runge-Kutta method, (stages, stages) and (stages,)
    turned_by : whether the attitude is advanced with ω of all stages, `STAGES`, or only with ω at
        the step's start, `START`, or at its end, `END`
    is_exponential : whether the attitude is turned by the rotation vector ω h, with h the step, and
        not advanced by adding h q'
    keeps_length : whether ω is scaled after a step so that I ω keeps its length
    """

    name: str
    a: FloatArray
    b: FloatArray
    turned_by: int = 0
    is_exponential: bool = False
    keeps_length: bool = False


STAGES, START, END = 0, 1, 2
_EULER = np.zeros((1, 1)), np.ones(1)
_HALF = np.diag([0.5], -1), np.array([0.0, 1.0])
_RK4 = np.diag([0.5, 0.5, 1.0], -1), np.array([1, 2, 2, 1]) / 6
EXACT = Integrator("", np.array(DOP853.A), np.array(DOP853.B))
#: Twice as fast as `EXACT`, with half as many stages. Its error is `ERROR` a radian or less, unless
#: the motion is unstable (tests).
APPROXIMATE, ERROR = Integrator("", np.array(RK45.A), np.array(RK45.B)), 1e-7
#: The integrators that are recognised in recordings.
KNOWN = (
    Integrator("explicit Euler", *_EULER),
    Integrator("explicit Euler with the rotation vector ω h", *_EULER, is_exponential=True),
    Integrator("semi-implicit Euler", *_EULER, END),
    Integrator("semi-implicit Euler with the rotation vector ω h", *_EULER, END, True),
    Integrator("semi-implicit Euler with ‖L‖ kept", *_EULER, END, True, True),
    Integrator("the midpoint rule", *_HALF),
    Integrator("RK4", *_RK4),
    Integrator("RK4 for ω, and explicit Euler for the attitude,", *_RK4, START),
    Integrator("RK4 for ω, and a turn by the old ω h,", *_RK4, START, True),
    Integrator("RK4 for ω, and a turn by the new ω h,", *_RK4, END, True),
)


def follow(
    equations: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    integrator: Integrator = EXACT,
    timestep: float = 0.0,
    fastest: float = math.inf,
) -> FloatArray:
    """Return the states that the equations take S states to, after each of L successive spans.

    Parameters
    ----------
    equations : one set of equations
    states : q, scalar first, body to world, and ω, rad/s, body axes, (S, 7)
    spans : s, (S, L)
    integrator : the method of integration
    timestep : s, of which each span is a multiple; 0 with `EXACT` and `APPROXIMATE`, which choose
        their own
    fastest : largest ‖ω‖ that is followed, rad/s

    Returns
    -------
    (S, L, 7); nan for a given state from the span on in which a number leaves the range of doubles,
    or ‖ω‖ exceeds `fastest`
    """
    of_method = integrator, np.full(1, timestep), fastest
    return np.asarray(follow_each(equations, states[None], spans[None], *of_method)[0])


def follow_each(
    equations: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    integrator: Integrator = EXACT,
    timesteps: FloatArray | None = None,
    fastest: float = math.inf,
) -> FloatArray:
    """Return the states that each of E sets of equations takes S states to, after each of L spans.

    Each span begins in the state in which the span before it ends. One call for all sets takes far
    less time than a call for each, since Python's overhead exceeds the time that most motions take.

    Parameters
    ----------
    equations : E sets of equations
    states : q, scalar first, body to world, and ω, rad/s, body axes, (E, S, 7)
    spans : s, (E, S, L)
    integrator : the method of integration
    timesteps : s, (E,); each span is a multiple of its timestep; None with `EXACT` and
        `APPROXIMATE`, which choose their own
    fastest : largest ‖ω‖ that is followed, rad/s, because computing time is proportional to ‖ω‖

    Returns
    -------
    (E, S, L, 7); nan for a given state from the span on in which a number leaves the range of
    doubles, or ‖ω‖ exceeds `fastest`

    Raises
    ------
    ValueError
        If `spans` is for another number of sets than `equations`.
    """
    numbers = all_numbers(equations)
    if len(numbers) != len(spans):
        raise ValueError(f"{len(numbers)} sets of equations for {len(spans)} of states")
    timesteps = np.zeros(len(numbers)) if timesteps is None else timesteps
    ends = np.empty((*spans.shape, 7))
    states, spans = as_kernels_take(states), as_kernels_take(spans)
    _follow(numbers, states, spans, *integrator[1:], timesteps, fastest, ends)
    return ends


def rates(equations: OtherEquations, states: FloatArray, kept: FloatArray) -> FloatArray:
    """Return the rates of change of S states by one set of equations of motion.

    Parameters
    ----------
    states : q, scalar first, body to world, and ω, rad/s, body axes, (S, 7)
    kept : angular momentum of rotors in each state, kg m²/s, in place of `equations.kept`, (S, 3)

    Returns
    -------
    (S, 6), along body axes: the angular velocity at which the attitude turns, rad/s, and ω', rad/s²
    """
    made = np.empty((len(states), 6))
    states, kept = as_kernels_take(states), as_kernels_take(kept)
    _fill_rates(all_numbers(equations)[0], states, kept, made)
    return made


@called
def _fill_rates(e: FloatArray, states: FloatArray, kept: FloatArray, made: FloatArray) -> None:
    """Write the rates of change of S states into `made`, (S, 6), as `rates` returns them.

    `e` has the equations' numbers, from `all_numbers`; the rotors' momentum in it is overwritten by
    that of each state in `kept`, (S, 3).
    """
    for s in range(states.shape[0]):
        put(vector(kept[s], 0), e, KEPT)
        turned, accelerated = rates_of(e, states[s])
        put(turned, made[s], 0)
        put(accelerated, made[s], 3)


@kernel
def _product(q: FloatArray, h: float, v: Vector) -> tuple[float, float, float, float]:
    """Return h/2 times the product of the quaternion q and (0, v); v is along body axes."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return (
        -h / 2 * (x * v[0] + y * v[1] + z * v[2]),
        h / 2 * (w * v[0] + y * v[2] - z * v[1]),
        h / 2 * (w * v[1] + z * v[0] - x * v[2]),
        h / 2 * (w * v[2] + x * v[1] - y * v[0]),
    )


@kernel
def _size(e: FloatArray, y: FloatArray) -> float:
    """Return the length of I ω, kg m²/s, at the state y: q, scalar first, and ω, rad/s, (7,).

    `e` has the equations' numbers, from `all_numbers`.
    """
    L = by_tensor(e, INERTIA, rotation_of(y), vector(y, 4))
    return math.sqrt(dot(L, L))


@kernel
def _fill_stage(e: FloatArray, y: FloatArray, stage: FloatArray) -> None:
    """Write q', ω' and the angular velocity at the state y, (7,), into `stage`, (10,).

    They are a stage of a Runge-Kutta step; `e` has the equations' numbers, from `all_numbers`.
    """
    turned, accelerated = rates_of(e, y)
    stage[0], stage[1], stage[2], stage[3] = _product(y, 1.0, turned)
    put(accelerated, stage, 4)
    put(turned, stage, TURNS)


@called
def _step(
    e: FloatArray,
    y: FloatArray,
    h: float,
    a: FloatArray,
    b: FloatArray,
    turned_by: int,
    is_exponential: bool,
    keeps_length: bool,
    k: FloatArray,
    at: FloatArray,
) -> None:
    """Replace the state y, q and ω, (7,), by the state after a step of h seconds.

    Parameters
    ----------
    e : the equations' numbers, from `all_numbers`
    a, b : coefficients of an explicit Runge-Kutta method, (stages, stages) and (stages,)
    turned_by : which ω advances the attitude: `STAGES` for that of all stages, `START` or `END` for
        that at the start or the end of the step
    is_exponential : whether the attitude is turned by the rotation vector ω h, not by adding h q'
    keeps_length : whether ω is scaled so that I ω keeps its length
    k, at : workspace for the stages, (stages, STAGE), and for a state, (7,)
    """
    for n in range(b.size):
        for i in range(7):
            at[i] = y[i]
        for m in range(n):
            if a[n, m] != 0.0:
                factor = h * a[n, m]
                for i in range(7):
                    at[i] += factor * k[m, i]
        _fill_stage(e, at, k[n])
    before = _size(e, y) if keeps_length else 0.0
    for i in range(4, 7):
        for n in range(b.size):
            y[i] += h * b[n] * k[n, i]
    if keeps_length:
        after = _size(e, y)
        kept = before / after if after > 0.0 else 1.0
        for i in range(4, 7):
            y[i] *= kept
    for i in range(4):
        at[i] = y[i]
    if turned_by == END:
        turned = turning(e, rotation_of(y), vector(y, 4))
        put(turned, k[0], TURNS)
        k[0, 0], k[0, 1], k[0, 2], k[0, 3] = _product(at, 1.0, turned)
    if turned_by != STAGES:
        # One stage makes all of the turn.
        for n in range(1, b.size):
            for i in range(STAGE):
                k[n, i] = k[0, i]
    if is_exponential:
        turn = 0.0, 0.0, 0.0
        for n in range(b.size):
            turn = plus(turn, vector(k[n], TURNS), h * b[n])
        angle = math.sqrt(dot(turn, turn))
        added = _product(at, 2 * math.sin(angle / 2) / angle if angle > 0.0 else 1.0, turn)
        for i in range(4):
            y[i] = math.cos(angle / 2) * at[i] + added[i]
    else:
        for i in range(4):
            for n in range(b.size):
                y[i] += h * b[n] * k[n, i]
    length = math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
    for i in range(4):
        y[i] /= length


@kernel
def _kept_speed(y: FloatArray, fastest: float) -> float:
    """Return ‖ω‖ of the state y, rad/s.

    If it is inf or above `fastest`, y is set to nan and nan is returned.
    """
    omega = vector(y, 4)
    speed = math.sqrt(dot(omega, omega))
    if speed > fastest or speed == math.inf:
        y[:] = speed = math.nan
    return speed


@allocating
def _follow(
    equations: FloatArray,
    states: FloatArray,
    spans: FloatArray,
    a: FloatArray,
    b: FloatArray,
    turned_by: int,
    is_exponential: bool,
    keeps_length: bool,
    timesteps: FloatArray,
    fastest: float,
    ends: FloatArray,
) -> None:
    k, y, at = np.empty((b.size, STAGE)), np.empty(7), np.empty(7)
    for n in range(spans.shape[0]):
        e, timestep = equations[n], timesteps[n]
        for s in range(spans.shape[1]):
            y[:] = states[n, s]
            speed = _kept_speed(y, fastest)
            for j in range(spans.shape[2]):
                span = spans[n, s, j]
                if timestep > 0.0:
                    steps = max(1, round(span / timestep))
                else:
                    turn = speed + e[RATE]
                    # For a state that is not finite, one step is enough.
                    steps = 1 + int(min(turn * abs(span) / TURN, 1e5)) if turn < 1e300 else 1
                h = span / steps
                for _ in range(steps):
                    _step(e, y, h, a, b, turned_by, is_exponential, keeps_length, k, at)
                speed = _kept_speed(y, fastest)
                ends[n, s, j] = y
