"""Equations of motion that need not be a scene's, and what integrators make of them.

What a recorded motion is compared with, to find what was computed instead of the exact motion: a
tensor that is another one, a gyroscopic torque ω × Gω with another tensor G than in I ω', an
attitude that follows ω otherwise. Plain doubles; where the equations are a scene's the result is
that of `flow` to some ulp (tests).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from ..scenarios import FloatArray, Scenario
from .kernel import called

#: rad of a step of `EXACT`, whose error is then an ulp.
TURN = 0.2
#: What Euler's product of ω and q is: as due, or with ω along body axes on the side of world axes.
BODY, WORLD = 0, 1
#: A kinematic number above is a convention of Euler angles, `FIRST_ANGLES` + 9 i + 3 j + k for
#: R = R_i(a) R_j(b) R_k(c), whose rates ω is taken for.
FIRST_ANGLES = 2


class OtherEquations(NamedTuple):
    """Numbers of equations of motion, SI; `torque` is in body axes unless its name says otherwise.

    I ω' = τ − ω × (G ω + h) and q' = ½ q (A ω), τ = l × Rᵀg + torque + Rᵀ torque_world
    − (c + (a + b ‖ω‖) I) ω − (a + b ‖ω‖) h, and what a table answers.

    Attributes
    ----------
    inertia, inverse, gyroscopic, turning : I, its inverse, G, A, (3, 3)
    kept : h, the momentum of parts, (3,)
    gravity_world, pull : g, and l, mass times the lever from a pivot, zero without one, (3,)
    torque, torque_world : (3,)
    slowing : c, a, b
    lever, mobility : from a table to the com, m, and 1/mass, which is 0 without a table
    in_world : whether I and G are along world axes
    kinematics : `BODY`, `WORLD`, or of Euler angles
    rate : rad/s besides ‖ω‖, at which the state may change
    """

    inertia: FloatArray
    inverse: FloatArray
    gyroscopic: FloatArray
    turning: FloatArray
    kept: FloatArray
    gravity_world: FloatArray
    pull: FloatArray
    torque: FloatArray
    torque_world: FloatArray
    slowing: FloatArray
    lever: FloatArray
    mobility: float
    in_world: bool
    kinematics: int
    rate: float

    def with_inertia(self, inertia: FloatArray) -> "OtherEquations":
        """The same of a body with another tensor, kg m², (3, 3)."""
        inverse = np.asarray(np.linalg.inv(inertia), dtype=float)
        return self._replace(inertia=inertia, inverse=inverse, gyroscopic=inertia.copy())


def equations_of(scenario: Scenario) -> OtherEquations:
    """Return the equations of a scene."""
    constraint, pushed = scenario.constraint, scenario.pushed
    inertia = np.array(scenario.inertia)
    is_on_table = scenario.answer is not None
    lever = np.array(constraint.lever)
    return OtherEquations(
        inertia,
        np.asarray(np.linalg.inv(inertia), dtype=float),
        inertia.copy(),
        np.eye(3),
        np.array(scenario.kept_body(scenario.kept_at_start)),
        np.array(scenario.gravity_world),
        scenario.body.mass * lever if constraint.is_pivot else np.zeros(3),
        np.array(pushed["torque_body"], dtype=float),
        np.array(pushed["torque_world"], dtype=float),
        np.array([pushed["drag"], 0.0, 0.0], dtype=float),
        lever,
        1 / scenario.body.mass if is_on_table else 0.0,
        in_world=False,
        kinematics=BODY,
        rate=float(max((one.rate(scenario) for one in scenario.acting), default=0.0)),
    )


class Integrator(NamedTuple):
    """A one-step method, and what it is a step of.

    Attributes
    ----------
    name : as it is called
    a, b : Butcher's table, explicit, (stages, stages) and (stages,)
    form : what is integrated beside q: `OMEGA_BODY`, `OMEGA_WORLD`, `MOMENTUM`
    scheme : `TABLE`, or one of Euler's that goes by turns
    """

    name: str
    a: FloatArray
    b: FloatArray
    form: int = 0
    scheme: int = 0


OMEGA_BODY, OMEGA_WORLD, MOMENTUM = 0, 1, 2
#: Euler's by turns: ω first, and the attitude by q + h q' or by the rotation vector h ω; attitude
#: first; ω first with the length of I ω kept, and the rotation vector; explicit with the vector.
TABLE, OMEGA_FIRST, OMEGA_FIRST_TURNED, ATTITUDE_FIRST, LENGTH_KEPT, TURNED = 0, 1, 2, 3, 4, 5


def _table(name: str, *rows: tuple[float, ...], form: int = 0) -> Integrator:
    *inner, b = rows
    a = np.zeros((len(b), len(b)))
    for k, row in enumerate(inner, 1):
        a[k, : len(row)] = row
    return Integrator(name, a, np.array(b), form)


EXACT = Integrator("", np.array(DOP853.A), np.array(DOP853.B))
_EULER = (1.0,)
_TABLES: dict[str, tuple[tuple[float, ...], ...]] = {
    "explicit Euler": (_EULER,),
    "the midpoint rule": ((0.5,), (0.0, 1.0)),
    "Heun's method": ((1.0,), (0.5, 0.5)),
    "RK4": ((0.5,), (0.0, 0.5), (0.0, 0.0, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
}
_FORMS = (("", OMEGA_BODY), (" of ω along world axes", OMEGA_WORLD), (" of L", MOMENTUM))
_BY_TURNS = (
    ("semi-implicit Euler", OMEGA_FIRST),
    ("semi-implicit Euler with the rotation vector ω h", OMEGA_FIRST_TURNED),
    ("semi-implicit Euler, the attitude first", ATTITUDE_FIRST),
    ("semi-implicit Euler with ‖L‖ kept", LENGTH_KEPT),
    ("explicit Euler with the rotation vector ω h", TURNED),
)
#: The integrators that are known by name.
KNOWN = (
    *(
        _table(name + words, *rows, form=form)
        for name, rows in _TABLES.items()
        for words, form in _FORMS
    ),
    *(Integrator(name, np.zeros((1, 1)), np.ones(1), scheme=k) for name, k in _BY_TURNS),
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
    form, scheme = integrator.form, integrator.scheme
    _follow(equations, states, spans, integrator.a, integrator.b, form, scheme, timestep, ends)
    return ends


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
    if e.kinematics == 0:
        return x, y, z
    if e.kinematics == 1:
        return _turned(R, x, y, z, True)
    which = e.kinematics - 2
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
def _omega(
    e: OtherEquations, R: FloatArray, y: FloatArray, form: int
) -> tuple[float, float, float]:
    """ω in body axes, of the form that is integrated."""
    if form == 0:
        return y[4], y[5], y[6]
    a, b, c = _turned(R, y[4], y[5], y[6], True)
    if form == 1:
        return a, b, c
    return _by_tensor(e, e.inverse, R, a - e.kept[0], b - e.kept[1], c - e.kept[2])


@called
def _rates(e: OtherEquations, y: FloatArray, R: FloatArray, form: int, rates: FloatArray) -> None:
    """The rates of q and of what is integrated beside it."""
    _matrix(y, R)
    x, v, z = _omega(e, R, y, form)
    a, b, c = _turning(e, R, x, v, z)
    q = y
    rates[0] = -(q[1] * a + q[2] * b + q[3] * c) / 2
    rates[1] = (q[0] * a + q[2] * c - q[3] * b) / 2
    rates[2] = (q[0] * b + q[3] * a - q[1] * c) / 2
    rates[3] = (q[0] * c + q[1] * b - q[2] * a) / 2
    k, l, m = _torque(e, R, x, v, z)  # noqa: E741
    if form == 2:
        # L' in world axes: I ω' + ω × L, which is −ω × Iω less another gyroscopic torque.
        p, r, s = _by_tensor(e, e.inertia, R, x, v, z)
        p, r, s = _cross(x, v, z, p + e.kept[0], r + e.kept[1], s + e.kept[2])
        k, l, m = k + p, l + r, m + s  # noqa: E741
    else:
        k, l, m = _by_tensor(e, e.inverse, R, k, l, m)  # noqa: E741
    if form > 0:
        k, l, m = _times(R, k, l, m)  # noqa: E741
    rates[4], rates[5], rates[6] = k, l, m


@called
def _rotated(y: FloatArray, a: float, b: float, c: float) -> None:
    """Turn q by a rotation vector along body axes."""
    angle = math.sqrt(a * a + b * b + c * c)
    s = math.sin(angle / 2) / angle if angle > 0.0 else 0.5
    w, a, b, c = math.cos(angle / 2), a * s, b * s, c * s
    p, q, r, t = y[0], y[1], y[2], y[3]
    y[0] = p * w - q * a - r * b - t * c
    y[1] = p * a + q * w + r * c - t * b
    y[2] = p * b + r * w + t * a - q * c
    y[3] = p * c + t * w + q * b - r * a


@called
def _euler_by_turns(
    e: OtherEquations, y: FloatArray, h: float, scheme: int, R: FloatArray, rates: FloatArray
) -> None:
    _rates(e, y, R, 0, rates)
    if scheme == 3 or scheme == 5:
        if scheme == 3:
            for i in range(4):
                y[i] += h * rates[i]
            _rates(e, y, R, 0, rates)
        else:
            a, b, c = _turning(e, R, y[4], y[5], y[6])
            _rotated(y, h * a, h * b, h * c)
        for i in range(4, 7):
            y[i] += h * rates[i]
        return
    p, q, r = _by_tensor(e, e.inertia, R, y[4], y[5], y[6])
    before = math.sqrt(p * p + q * q + r * r)
    for i in range(4, 7):
        y[i] += h * rates[i]
    if scheme == 4:
        p, q, r = _by_tensor(e, e.inertia, R, y[4], y[5], y[6])
        after = math.sqrt(p * p + q * q + r * r)
        if after > 0.0:
            for i in range(4, 7):
                y[i] *= before / after
    if scheme == 1:
        _rates(e, y, R, 0, rates)
        for i in range(4):
            y[i] += h * rates[i]
    else:
        a, b, c = _turning(e, R, y[4], y[5], y[6])
        _rotated(y, h * a, h * b, h * c)


@called
def _follow(
    e: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    a: FloatArray,
    b: FloatArray,
    form: int,
    scheme: int,
    timestep: float,
    ends: FloatArray,
) -> None:
    stages = b.size
    k, R = np.empty((stages, 7)), np.empty((3, 3))
    y, at = np.empty(7), np.empty(7)
    for s in range(spans.shape[0]):
        for i in range(7):
            y[i] = states[s, i]
        _matrix(y, R)
        if form == 2:
            p, q, r = _by_tensor(e, e.inertia, R, y[4], y[5], y[6])
            y[4], y[5], y[6] = _times(R, p + e.kept[0], q + e.kept[1], r + e.kept[2])
        elif form == 1:
            y[4], y[5], y[6] = _times(R, y[4], y[5], y[6])
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
                if scheme > 0:
                    _euler_by_turns(e, y, h, scheme, R, k[0])
                else:
                    for n in range(stages):
                        for i in range(7):
                            at[i] = y[i]
                            for m in range(n):
                                at[i] += h * a[n, m] * k[m, i]
                        _rates(e, at, R, form, k[n])
                    for i in range(7):
                        for n in range(stages):
                            y[i] += h * b[n] * k[n, i]
                norm = math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
                for i in range(4):
                    y[i] /= norm
            _matrix(y, R)
            x, v, z = _omega(e, R, y, form)
            for i in range(4):
                ends[s, j, i] = y[i]
            ends[s, j, 4], ends[s, j, 5], ends[s, j, 6] = x, v, z
