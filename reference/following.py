"""Integrates equations of motion that need not be a scene's, by integrators known to this module.

All numbers are plain doubles. If the equations are a scene's, the integrator `EXACT` agrees with
`flow` to some ulp (tests).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from ..scenarios import FloatArray
from .kernel import called, kernel
from .other_equations import (
    FIRST_ANGLES,
    KEPT_IN_WORLD,
    TURNED_ON,
    UNTURNED,
    WORLD,
    OtherEquations,
)

#: Largest turn in a step of `EXACT`, rad: its error is then an ulp.
TURN = 0.2
#: Columns of a stage: q', ω' and the angular velocity at which the attitude turns.
STAGE = 10


class Integrator(NamedTuple):
    """A one-step method for q and ω, rad/s, along body axes.

    Whether a code normalises its quaternions makes no difference to the attitudes that they
    represent: q' is linear in q.

    Attributes
    ----------
    name : name of the integrator
    a, b : explicit Butcher tableau, (stages, stages) and (stages,)
    turned_by : whether the attitude is advanced with ω of all stages, or that of the step's start
        or end alone: `STAGES`, `START` or `END`
    is_exponential : whether the attitude is turned by the rotation vector of ω over the step,
        instead of q' being added
    keeps_length : whether I ω is scaled to the length that it had before the step
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
#: The integrators that are recognised.
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
    """Return the states reached from each given state after each of L successive spans.

    Parameters
    ----------
    states : q, scalar first, body to world, and ω, rad/s, body axes, (S, 7)
    spans : s, (S, L)
    timestep : s; each span is a multiple of it; 0 with `EXACT`, which chooses its own timestep
    fastest : largest rate that is followed, rad/s: to follow one takes time in proportion

    Returns
    -------
    (S, L, 7); nan from the first number on that leaves the range of doubles, or of rates
    """
    ends = np.empty((*spans.shape, 7))
    _follow(equations, states, spans, *integrator[1:], timestep, fastest, ends)
    return ends


def rates(equations: OtherEquations, states: FloatArray, kept: FloatArray) -> FloatArray:
    """Return the rates of change of states.

    Parameters
    ----------
    states : q, scalar first, body to world, and ω, rad/s, body axes, (S, 7)
    kept : angular momentum of parts in each state, kg m²/s, in place of `equations.kept`, (S, 3)

    Returns
    -------
    (S, 6), along body axes: the angular velocity at which the attitude turns, rad/s, and ω', rad/s²
    """
    stages = np.empty((len(states), STAGE))
    _fill_stages(equations._replace(kept=np.empty(3)), states, kept, stages)
    return stages[:, [7, 8, 9, 4, 5, 6]]


Vector = tuple[float, float, float]


@kernel
def _vector(v: FloatArray, at: int = 0) -> Vector:
    return v[at], v[at + 1], v[at + 2]


@kernel
def _put(v: Vector, to: FloatArray, at: int) -> None:
    to[at], to[at + 1], to[at + 2] = v


@kernel
def _plus(u: Vector, v: Vector, factor: float) -> Vector:
    """Return u + factor · v."""
    return u[0] + factor * v[0], u[1] + factor * v[1], u[2] + factor * v[2]


@kernel
def _dot(u: Vector, v: Vector) -> float:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@kernel
def _cross(u: Vector, v: Vector) -> Vector:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@kernel
def _times(M: FloatArray, v: Vector) -> Vector:
    return (
        M[0, 0] * v[0] + M[0, 1] * v[1] + M[0, 2] * v[2],
        M[1, 0] * v[0] + M[1, 1] * v[1] + M[1, 2] * v[2],
        M[2, 0] * v[0] + M[2, 1] * v[1] + M[2, 2] * v[2],
    )


@kernel
def _to_body(R_world_body: FloatArray, v: Vector) -> Vector:
    R = R_world_body
    return (
        R[0, 0] * v[0] + R[1, 0] * v[1] + R[2, 0] * v[2],
        R[0, 1] * v[0] + R[1, 1] * v[1] + R[2, 1] * v[2],
        R[0, 2] * v[0] + R[1, 2] * v[1] + R[2, 2] * v[2],
    )


@called
def _matrix(q: FloatArray, R_world_body: FloatArray) -> None:
    """Fill in the rotation matrix of a quaternion of any length."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    n = w * w + x * x + y * y + z * z
    s = 2.0 / n if n > 0.0 else 0.0
    R = R_world_body
    R[0, 0], R[1, 1], R[2, 2] = (
        1 - s * (y * y + z * z),
        1 - s * (x * x + z * z),
        1 - s * (x * x + y * y),
    )
    R[0, 1], R[1, 0] = s * (x * y - w * z), s * (x * y + w * z)
    R[0, 2], R[2, 0] = s * (x * z + w * y), s * (x * z - w * y)
    R[1, 2], R[2, 1] = s * (y * z - w * x), s * (y * z + w * x)


@called
def _by_tensor(e: OtherEquations, M: FloatArray, R: FloatArray, v: Vector) -> Vector:
    """Return a tensor times a vector along body axes, whichever axes the tensor is constant in."""
    for _ in range(e.tensor_turns):
        v = _times(R, v)
    v = _times(M, v)
    for _ in range(e.tensor_turns):
        v = _to_body(R, v)
    return v


@called
def _of_world(e: OtherEquations, R: FloatArray, v: Vector) -> Vector:
    """Return what the equations take for a vector of world axes, along body axes."""
    if e.world_vectors == UNTURNED:
        return v
    return _times(R, v) if e.world_vectors == TURNED_ON else _to_body(R, v)


@called
def _resistance(e: OtherEquations, R: FloatArray, omega: Vector) -> Vector:
    """Return the torque that opposes ω, N m, body axes."""
    c, f = e.slowing[0], e.friction[0]
    speed = math.sqrt(_dot(omega, omega))
    if f != 0.0 and speed > 0.0:
        c += f * speed ** e.friction[1]
    D = e.damping
    torque = (-(c + D[0]) * omega[0], -(c + D[1]) * omega[1], -(c + D[2]) * omega[2])
    if e.turned_drag[0] != 0.0:
        torque = _plus(torque, _times(R, omega), -e.turned_drag[0])
    if e.turned_drag[1] != 0.0:
        torque = _plus(torque, _to_body(R, omega), -e.turned_drag[1])
    return torque


@kernel
def _is_any(M: FloatArray) -> bool:
    for i in range(3):
        for j in range(3):
            if M[i, j] != 0.0:
                return True
    return False


@called
def _of_attitude(e: OtherEquations, R: FloatArray) -> Vector:
    """Return the torque that depends on the attitude besides gravity's, N m, body axes."""
    torque = 0.0, 0.0, 0.0
    if _is_any(e.attitude_torque):
        for i in range(3):
            torque = _plus(torque, _cross(_vector(e.attitude_torque[:, i]), _vector(R[i])), 1.0)
    if _is_any(e.gravity_gradient):
        for i in range(3):
            unit = _vector(np.eye(3)[i])
            pulled = _to_body(R, _times(e.gravity_gradient, _times(R, unit)))
            torque = _plus(torque, _cross(unit, _by_tensor(e, e.inertia, R, pulled)), 1.0)
    return torque


@called
def _torque(e: OtherEquations, R: FloatArray, omega: Vector) -> Vector:
    """Return I ω', N m, body axes."""
    kept = _vector(e.kept)
    turned = _plus(_by_tensor(e, e.gyroscopic, R, omega), kept, 1.0)
    torque = _plus(_vector(e.torque), _cross(omega, turned), -1.0)
    gravity = _of_world(e, R, _vector(e.gravity_world))
    torque = _plus(torque, _cross(_vector(e.pull), gravity), 1.0)
    torque = _plus(torque, _of_world(e, R, _vector(e.torque_world)), 1.0)
    torque = _plus(torque, _of_attitude(e, R), 1.0)
    torque = _plus(torque, _resistance(e, R, omega), 1.0)
    L = _plus(_by_tensor(e, e.inertia, R, omega), kept, 1.0)
    slowed = e.slowing[1] + e.slowing[2] * math.sqrt(_dot(omega, omega))
    torque = _plus(torque, L, -slowed)
    if e.mobility > 0.0:
        up, lever = _vector(R[2]), _vector(e.lever)
        arm = _cross(up, lever)
        answer = _by_tensor(e, e.inverse, R, arm)
        swing = _dot(up, _cross(omega, _cross(omega, lever)))
        lift = swing - e.gravity_world[2] - _dot(answer, torque)
        torque = _plus(torque, arm, lift / (e.mobility + _dot(arm, answer)))
    return torque


@called
def _turning(e: OtherEquations, R: FloatArray, omega: Vector) -> Vector:
    """Return the angular velocity at which the attitude turns, body axes, rad/s."""
    omega = _times(e.turning, omega)
    if e.kinematics < WORLD:
        omega = _plus(omega, _vector(e.body_turns), 1.0)
        return _plus(omega, _to_body(R, _vector(e.world_turns)), -1.0)
    if e.kinematics == WORLD:
        return _to_body(R, omega)
    if e.kinematics == KEPT_IN_WORLD:
        return _times(R, omega)
    which = e.kinematics - FIRST_ANGLES
    i, j, k = which // 9, which // 3 % 3, which % 3
    # If the first and third axis are the same, the components are the angles' rates in order.
    a, b, c = omega if i == k else (omega[i], omega[j], omega[k])
    # The node line, along the second axis where the first angle has turned it to.
    first, third = _vector(np.eye(3)[i]), _vector(np.eye(3)[k])
    node = _cross(first, _vector(R[:, k]))
    sign = -1.0 if i != k and (i + 1) % 3 == j else 1.0
    length = sign * math.sqrt(_dot(node, node))
    if length == 0.0:
        return math.nan, math.nan, math.nan
    rates_world = _plus((a * first[0], a * first[1], a * first[2]), node, b / length)
    return _plus(_to_body(R, rates_world), third, c)


@called
def _add_product(q: FloatArray, h: float, v: Vector, to: FloatArray) -> None:
    """Add h/2 times the product of q and a vector along body axes to a quaternion."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    to[0] -= h / 2 * (x * v[0] + y * v[1] + z * v[2])
    to[1] += h / 2 * (w * v[0] + y * v[2] - z * v[1])
    to[2] += h / 2 * (w * v[1] + z * v[0] - x * v[2])
    to[3] += h / 2 * (w * v[2] + x * v[1] - y * v[0])


@called
def _by_turned_tensor(e: OtherEquations, R: FloatArray, omega: Vector, torque: Vector) -> Vector:
    """Return ω' of ω = Rᵀ I⁻¹ R L along world axes, where L is integrated; rad/s², body axes.

    L is taken for Rᵀ I R ω, and changes by torques alone.
    """
    turned = _plus(_by_tensor(e, e.gyroscopic, R, omega), _vector(e.kept), 1.0)
    outer = _plus(torque, _cross(omega, turned), 1.0)
    in_world = _times(R, omega)
    twice = _times(R, in_world)
    rate = _times(e.inverse, _cross(in_world, _times(e.inertia, twice)))
    rate = _plus(rate, _cross(in_world, twice), -1.0)
    rate = _plus(rate, _times(e.inverse, _times(R, _times(R, outer))), 1.0)
    return _to_body(R, _to_body(R, rate))


@called
def _rates(e: OtherEquations, y: FloatArray, R: FloatArray, stage: FloatArray) -> None:
    """Fill in the derivatives at the state y, a stage; R is workspace for a matrix."""
    _matrix(y, R)
    omega = _vector(y, 4)
    turning = _turning(e, R, omega)
    for i in range(4):
        stage[i] = 0.0
    _add_product(y, 1.0, turning, stage)
    torque = _torque(e, R, omega)
    if e.tensor_turns == 2:
        accelerated = _by_turned_tensor(e, R, omega, torque)
    else:
        accelerated = _by_tensor(e, e.inverse, R, torque)
    if e.kinematics == KEPT_IN_WORLD:
        # Body axes turn with the attitude, and no component along world axes does.
        accelerated = _plus(accelerated, _cross(omega, turning), 1.0)
    _put(accelerated, stage, 4)
    _put(turning, stage, 7)


@called
def _fill_stages(
    e: OtherEquations, states: FloatArray, kept: FloatArray, stages: FloatArray
) -> None:
    """Fill in the derivatives at all states, with the angular momentum of parts in each state."""
    R = np.empty((3, 3))
    for s in range(states.shape[0]):
        e.kept[:] = kept[s]
        _rates(e, states[s], R, stages[s])


@called
def _size(e: OtherEquations, R: FloatArray, y: FloatArray) -> float:
    """Return the length of I ω, kg m²/s."""
    L = _by_tensor(e, e.inertia, R, _vector(y, 4))
    return math.sqrt(_dot(L, L))


@called
def _step(
    e: OtherEquations,
    y: FloatArray,
    h: float,
    a: FloatArray,
    b: FloatArray,
    turned_by: int,
    is_exponential: bool,
    keeps_length: bool,
    R: FloatArray,
    k: FloatArray,
    at: FloatArray,
) -> None:
    """Take a step from the state y; R, k and at are workspace for a matrix, stages and a state."""
    for n in range(b.size):
        for i in range(7):
            at[i] = y[i]
            for m in range(n):
                at[i] += h * a[n, m] * k[m, i]
        _rates(e, at, R, k[n])
    before = _size(e, R, y) if keeps_length else 0.0
    for i in range(4, 7):
        for n in range(b.size):
            y[i] += h * b[n] * k[n, i]
    if keeps_length:
        after = _size(e, R, y)
        y[4:] *= before / after if after > 0.0 else 1.0
    at[:4] = y[:4]
    if turned_by == END:
        _matrix(y, R)
        _put(_turning(e, R, _vector(y, 4)), k[0], 7)
        k[0, :4] = 0.0
        _add_product(at, 1.0, _vector(k[0], 7), k[0])
    if turned_by != STAGES:
        # One stage makes all of the turn.
        for n in range(1, b.size):
            k[n] = k[0]
    if is_exponential:
        turn = 0.0, 0.0, 0.0
        for n in range(b.size):
            turn = _plus(turn, _vector(k[n], 7), h * b[n])
        angle = math.sqrt(_dot(turn, turn))
        y[:4] *= math.cos(angle / 2)
        _add_product(at, 2 * math.sin(angle / 2) / angle if angle > 0.0 else 1.0, turn, y)
    else:
        for i in range(4):
            for n in range(b.size):
                y[i] += h * b[n] * k[n, i]
    y[:4] /= math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])


@called
def _follow(
    e: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    a: FloatArray,
    b: FloatArray,
    turned_by: int,
    is_exponential: bool,
    keeps_length: bool,
    timestep: float,
    fastest: float,
    ends: FloatArray,
) -> None:
    k, R, y, at = np.empty((b.size, STAGE)), np.empty((3, 3)), np.empty(7), np.empty(7)
    for s in range(spans.shape[0]):
        y[:] = states[s]
        for j in range(spans.shape[1]):
            span = spans[s, j]
            omega = _vector(y, 4)
            speed = math.sqrt(_dot(omega, omega))
            if speed > fastest:
                y[:] = speed = math.nan
            if timestep > 0.0:
                steps = max(1, round(span / timestep))
            else:
                turn = speed + e.rate
                # A state that is not finite is not integrated further.
                steps = 1 + int(min(turn * abs(span) / TURN, 1e5)) if turn < 1e300 else 1
            h = span / steps
            for _ in range(steps):
                _step(e, y, h, a, b, turned_by, is_exponential, keeps_length, R, k, at)
            ends[s, j] = y
