"""What integrators make of equations of motion that need not be a scene's.

Plain doubles. Where the equations are a scene's, `EXACT` leads where `flow` does, to some ulp
(tests).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from ..scenarios import FloatArray
from .kernel import called
from .other_equations import FIRST_ANGLES, WORLD, OtherEquations

#: rad of a step of `EXACT`, whose error is then an ulp.
TURN = 0.2
#: Columns of a stage: q', ω' and the angular velocity at which the attitude turns.
STAGE = 10


class Integrator(NamedTuple):
    """A one-step method for q and ω, rad/s, along body axes.

    Whether a code normalises its quaternions makes no difference to the attitudes that they stand
    for: q' is linear in q.

    Attributes
    ----------
    name : as it is called
    a, b : Butcher's table, explicit, (stages, stages) and (stages,)
    is_omega_first : whether the attitude follows the ω after the step
    is_exponential : whether the attitude is turned by the rotation vector of ω over the step,
        instead of q' being added
    keeps_length : whether I ω is scaled to its length before the step
    """

    name: str
    a: FloatArray
    b: FloatArray
    is_omega_first: bool = False
    is_exponential: bool = False
    keeps_length: bool = False


_EULER = np.zeros((1, 1)), np.ones(1)
_HALF = np.diag([0.5], -1), np.array([0.0, 1.0])
_RK4 = np.diag([0.5, 0.5, 1.0], -1), np.array([1, 2, 2, 1]) / 6
EXACT = Integrator("", np.array(DOP853.A), np.array(DOP853.B))
#: The integrators that are recognised.
KNOWN = (
    Integrator("explicit Euler", *_EULER),
    Integrator("explicit Euler with the rotation vector ω h", *_EULER, is_exponential=True),
    Integrator("semi-implicit Euler", *_EULER, is_omega_first=True),
    Integrator("semi-implicit Euler with the rotation vector ω h", *_EULER, True, True),
    Integrator("semi-implicit Euler with ‖L‖ kept", *_EULER, True, True, True),
    Integrator("the midpoint rule", *_HALF),
    Integrator("RK4", *_RK4),
)


def follow(
    equations: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    integrator: Integrator = EXACT,
    timestep: float = 0.0,
) -> FloatArray:
    """Return where states go: from each of them through L spans, one after the other.

    Parameters
    ----------
    states : q, scalar first, body to world, and ω, rad/s, body axes, (S, 7)
    spans : s, (S, L)
    timestep : s, of which a span is a multiple; 0 with `EXACT`, which chooses its own

    Returns
    -------
    (S, L, 7); nan from where numbers leave the range of doubles
    """
    ends = np.empty((*spans.shape, 7))
    _follow(equations, states, spans, *integrator[1:], timestep, ends)
    return ends


def rates(equations: OtherEquations, states: FloatArray) -> FloatArray:
    """Return how fast states change.

    Parameters
    ----------
    states : q, scalar first, body to world, and ω, rad/s, body axes, (S, 7)

    Returns
    -------
    (S, 6), along body axes: the angular velocity at which the attitude turns, rad/s, and ω', rad/s²
    """
    stages, R_world_body = np.empty((len(states), STAGE)), np.empty((3, 3))
    for state, stage in zip(states, stages, strict=True):
        _rates(equations, state, R_world_body, stage)
    return stages[:, [7, 8, 9, 4, 5, 6]]


@called
def _times(M: FloatArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (
        M[0, 0] * x + M[0, 1] * y + M[0, 2] * z,
        M[1, 0] * x + M[1, 1] * y + M[1, 2] * z,
        M[2, 0] * x + M[2, 1] * y + M[2, 2] * z,
    )


@called
def _turned(
    R: FloatArray, x: float, y: float, z: float, is_back: bool
) -> tuple[float, float, float]:
    if is_back:
        return (
            R[0, 0] * x + R[1, 0] * y + R[2, 0] * z,
            R[0, 1] * x + R[1, 1] * y + R[2, 1] * z,
            R[0, 2] * x + R[1, 2] * y + R[2, 2] * z,
        )
    return _times(R, x, y, z)


@called
def _cross(
    a: float, b: float, c: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    return b * z - c * y, c * x - a * z, a * y - b * x


@called
def _matrix(state: FloatArray, R: FloatArray) -> None:
    w, x, y, z = state[0], state[1], state[2], state[3]
    n = w * w + x * x + y * y + z * z
    s = 2.0 / n if n > 0.0 else 0.0
    R[0, 0], R[1, 1], R[2, 2] = (
        1 - s * (y * y + z * z),
        1 - s * (x * x + z * z),
        1 - s * (x * x + y * y),
    )
    R[0, 1], R[1, 0] = s * (x * y - w * z), s * (x * y + w * z)
    R[0, 2], R[2, 0] = s * (x * z + w * y), s * (x * z - w * y)
    R[1, 2], R[2, 1] = s * (y * z - w * x), s * (y * z + w * x)


@called
def _by_tensor(
    e: OtherEquations, M: FloatArray, R: FloatArray, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """A tensor times a vector in body axes, wherever the tensor keeps its axes."""
    if not e.in_world:
        return _times(M, x, y, z)
    a, b, c = _times(R, x, y, z)
    a, b, c = _times(M, a, b, c)
    return _turned(R, a, b, c, True)


@called
def _torque(
    e: OtherEquations, R: FloatArray, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """I ω', N m, body axes, at ω."""
    u, v, w = _by_tensor(e, e.gyroscopic, R, x, y, z)
    u, v, w = _cross(x, y, z, u + e.kept[0], v + e.kept[1], w + e.kept[2])
    g = e.gravity_world
    a, b, c = _turned(R, g[0], g[1], g[2], True)
    a, b, c = _cross(e.pull[0], e.pull[1], e.pull[2], a, b, c)
    t = e.torque_world
    k, l, m = _turned(R, t[0], t[1], t[2], True)  # noqa: E741
    slower = e.slowing[1] + e.slowing[2] * math.sqrt(x * x + y * y + z * z)
    p, q, r = _by_tensor(e, e.inertia, R, x, y, z)
    a += k + e.torque[0] - u - e.slowing[0] * x - slower * (p + e.kept[0])
    b += l + e.torque[1] - v - e.slowing[0] * y - slower * (q + e.kept[1])
    c += m + e.torque[2] - w - e.slowing[0] * z - slower * (r + e.kept[2])
    if e.mobility > 0.0:
        f, h, i = R[2, 0], R[2, 1], R[2, 2]
        k, l, m = _cross(x, y, z, e.lever[0], e.lever[1], e.lever[2])  # noqa: E741
        k, l, m = _cross(x, y, z, k, l, m)  # noqa: E741
        u, v, w = _cross(f, h, i, e.lever[0], e.lever[1], e.lever[2])
        p, q, r = _by_tensor(e, e.inverse, R, u, v, w)
        lift = f * k + h * l + i * m - g[2] - (p * a + q * b + r * c)
        force = lift / (e.mobility + u * p + v * q + w * r)
        a, b, c = a + force * u, b + force * v, c + force * w
    return a, b, c


@called
def _turning(
    e: OtherEquations, R: FloatArray, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """The angular velocity, body axes, at which the attitude turns, at ω."""
    x, y, z = _times(e.turning, x, y, z)
    if e.kinematics < WORLD:
        return x, y, z
    if e.kinematics == WORLD:
        return _turned(R, x, y, z, True)
    which = e.kinematics - FIRST_ANGLES
    i, j, k = which // 9, which // 3 % 3, which % 3
    of_axis = np.array([x, y, z])
    # Where an axis comes twice the components are the rates of the angles in order.
    a, b, c = (x, y, z) if i == k else (of_axis[i], of_axis[j], of_axis[k])
    # The node line, along the second axis where the first angle has turned it to.
    first = np.zeros(3)
    first[i] = 1.0
    u, v, w = _cross(first[0], first[1], first[2], R[0, k], R[1, k], R[2, k])
    sign = -1.0 if i != k and (i + 1) % 3 == j else 1.0
    length = sign * math.sqrt(u * u + v * v + w * w)
    if length == 0.0:
        return math.nan, math.nan, math.nan
    u, v, w = _turned(R, u / length, v / length, w / length, True)
    of_axis = np.array([a * R[i, 0] + b * u, a * R[i, 1] + b * v, a * R[i, 2] + b * w])
    of_axis[k] += c
    return of_axis[0], of_axis[1], of_axis[2]


@called
def _add_product(q: FloatArray, h: float, a: float, b: float, c: float, to: FloatArray) -> None:
    """Add h/2 times the product of q and a vector along body axes to a quaternion."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    to[0] -= h / 2 * (x * a + y * b + z * c)
    to[1] += h / 2 * (w * a + y * c - z * b)
    to[2] += h / 2 * (w * b + z * a - x * c)
    to[3] += h / 2 * (w * c + x * b - y * a)


@called
def _rates(e: OtherEquations, y: FloatArray, R: FloatArray, stage: FloatArray) -> None:
    """Fill in the columns of a stage at the state y; R is room for a matrix."""
    _matrix(y, R)
    a, b, c = _turning(e, R, y[4], y[5], y[6])
    stage[:4] = 0.0
    _add_product(y, 1.0, a, b, c, stage)
    k, l, m = _torque(e, R, y[4], y[5], y[6])  # noqa: E741
    stage[4], stage[5], stage[6] = _by_tensor(e, e.inverse, R, k, l, m)
    stage[7], stage[8], stage[9] = a, b, c


@called
def _turned_by(y: FloatArray, a: float, b: float, c: float, q: FloatArray) -> None:
    """Turn the attitude of y by a rotation vector along body axes; q is room for a quaternion."""
    angle = math.sqrt(a * a + b * b + c * c)
    # Added is q sin(φ/2) n, twice half of it.
    s = 2 * math.sin(angle / 2) / angle if angle > 0.0 else 1.0
    for i in range(4):
        q[i] = y[i]
        y[i] *= math.cos(angle / 2)
    _add_product(q, s, a, b, c, y)


@called
def _size(e: OtherEquations, R: FloatArray, y: FloatArray) -> float:
    """The length of I ω, kg m²/s."""
    a, b, c = _by_tensor(e, e.inertia, R, y[4], y[5], y[6])
    return math.sqrt(a * a + b * b + c * c)


@called
def _step(
    e: OtherEquations,
    y: FloatArray,
    h: float,
    a: FloatArray,
    b: FloatArray,
    is_omega_first: bool,
    is_exponential: bool,
    keeps_length: bool,
    R: FloatArray,
    k: FloatArray,
    at: FloatArray,
) -> None:
    """Take a step from the state y; R, k and at are room for a matrix, stages and a state."""
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
        if after > 0.0:
            for i in range(4, 7):
                y[i] *= before / after
    if is_omega_first:
        for i in range(4):
            at[i] = y[i]
        u, v, w = _turning(e, R, y[4], y[5], y[6])
        k[0, 7], k[0, 8], k[0, 9] = u, v, w
        k[0, :4] = 0.0
        _add_product(at, 1.0, u, v, w, k[0])
    if is_exponential:
        u, v, w = 0.0, 0.0, 0.0
        for n in range(b.size):
            u, v, w = u + b[n] * k[n, 7], v + b[n] * k[n, 8], w + b[n] * k[n, 9]
        _turned_by(y, h * u, h * v, h * w, at)
    else:
        for i in range(4):
            for n in range(b.size):
                y[i] += h * b[n] * k[n, i]
    norm = math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
    for i in range(4):
        y[i] /= norm


@called
def _follow(
    e: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    a: FloatArray,
    b: FloatArray,
    is_omega_first: bool,
    is_exponential: bool,
    keeps_length: bool,
    timestep: float,
    ends: FloatArray,
) -> None:
    k, R, y, at = np.empty((b.size, STAGE)), np.empty((3, 3)), np.empty(7), np.empty(7)
    for s in range(spans.shape[0]):
        y[:] = states[s]
        for j in range(spans.shape[1]):
            span = spans[s, j]
            if timestep > 0.0:
                steps = max(1, round(span / timestep))
            else:
                turn = math.sqrt(y[4] * y[4] + y[5] * y[5] + y[6] * y[6]) + e.rate
                # What is no motion any more is not followed.
                steps = 1 + int(min(turn * abs(span) / TURN, 1e5)) if turn < 1e300 else 1
            h = span / steps
            for _ in range(steps):
                _step(e, y, h, a, b, is_omega_first, is_exponential, keeps_length, R, k, at)
            ends[s, j] = y
