"""Rates of change of a state by equations of motion that need not be a scene's, compiled.

The equations are passed as one array of all their numbers, which `all_numbers` returns and which is
always named `e` here: passing some twenty arrays to each function would take several times as long
as what the function computes. R is the rotation matrix of the attitude, body to world.
"""

import math

import numpy as np

from ..scenarios import FloatArray
from .kernel import called, kernel
from .other_equations import (
    FIRST_ANGLES,
    KEPT_IN_WORLD,
    TORQUE_UNTURNED,
    TURNED_ON,
    UNTURNED,
    WORLD,
    OtherEquations,
)

Vector = tuple[float, float, float]
#: A 3 × 3 matrix, row by row.
Matrix = tuple[float, float, float, float, float, float, float, float, float]

#: Where each entry of `OtherEquations` begins in a row of all numbers.
INERTIA = OtherEquations.inertia.first
INVERSE = OtherEquations.inverse.first
GYROSCOPIC = OtherEquations.gyroscopic.first
TURNING = OtherEquations.turning.first
KEPT = OtherEquations.kept.first
GRAVITY_WORLD = OtherEquations.gravity_world.first
PULL = OtherEquations.pull.first
TORQUE = OtherEquations.torque.first
TORQUE_WORLD = OtherEquations.torque_world.first
SLOWING = OtherEquations.slowing.first
DAMPING = OtherEquations.damping.first
FRICTION = OtherEquations.friction.first
TURNED_DRAG = OtherEquations.turned_drag.first
ATTITUDE_TORQUE = OtherEquations.attitude_torque.first
SPRING = OtherEquations.spring.first
GRAVITY_GRADIENT = OtherEquations.gravity_gradient.first
BODY_TURNS = OtherEquations.body_turns.first
WORLD_TURNS = OtherEquations.world_turns.first
WORLD_VECTORS = OtherEquations.world_vectors.first
LEVER = OtherEquations.lever.first
MOBILITY = OtherEquations.mobility.first
TENSOR_TURNS = OtherEquations.tensor_turns.first
KINEMATICS = OtherEquations.kinematics.first
RATE = OtherEquations.rate.first
HAS_TORQUE_OF_ATTITUDE = OtherEquations.has_torque_of_attitude.first


def all_numbers(equations: OtherEquations) -> FloatArray:
    """Return all numbers of E sets of equations of motion, (E, n), as kernels take them.

    A single set gives one row, (1, n). The number `has_torque_of_attitude` is set in each row, as
    it would be costly to find out in each step.
    """
    numbers = np.array(np.atleast_2d(equations.numbers), order="C")
    # The numbers of attitude torque, spring and gravity gradient are adjacent.
    numbers[:, HAS_TORQUE_OF_ATTITUDE] = numbers[:, ATTITUDE_TORQUE:BODY_TURNS].any(axis=1)
    return numbers


@kernel
def vector(v: FloatArray, at: int) -> Vector:
    """Return the vector whose three numbers begin at the index `at` of an array v."""
    return v[at], v[at + 1], v[at + 2]


@kernel
def matrix(M: FloatArray, at: int) -> Matrix:
    """Return the 3 × 3 matrix whose numbers, row by row, begin at the index `at` of an array M."""
    return (
        *(M[at], M[at + 1], M[at + 2]),
        *(M[at + 3], M[at + 4], M[at + 5]),
        *(M[at + 6], M[at + 7], M[at + 8]),
    )


@kernel
def put(v: Vector, to: FloatArray, at: int) -> None:
    """Write the three numbers of a vector v into the array `to`, from the index `at` on."""
    to[at], to[at + 1], to[at + 2] = v


@kernel
def plus(u: Vector, v: Vector, factor: float) -> Vector:
    """Return u + factor · v."""
    return u[0] + factor * v[0], u[1] + factor * v[1], u[2] + factor * v[2]


@kernel
def dot(u: Vector, v: Vector) -> float:
    """Return u · v."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@kernel
def _cross(u: Vector, v: Vector) -> Vector:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@kernel
def _times(M: Matrix, v: Vector) -> Vector:
    return (
        M[0] * v[0] + M[1] * v[1] + M[2] * v[2],
        M[3] * v[0] + M[4] * v[1] + M[5] * v[2],
        M[6] * v[0] + M[7] * v[1] + M[8] * v[2],
    )


@kernel
def _to_body(R_world_body: Matrix, v: Vector) -> Vector:
    R = R_world_body
    return (
        R[0] * v[0] + R[3] * v[1] + R[6] * v[2],
        R[1] * v[0] + R[4] * v[1] + R[7] * v[2],
        R[2] * v[0] + R[5] * v[1] + R[8] * v[2],
    )


@kernel
def rotation_of(q: FloatArray) -> Matrix:
    """Return the rotation matrix, body to world, of a quaternion of any length, scalar first.

    It is the unit matrix for a quaternion of zeros.
    """
    w, x, y, z = q[0], q[1], q[2], q[3]
    n = w * w + x * x + y * y + z * z
    s = 2.0 / n if n > 0.0 else 0.0
    return (
        *(1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)),
        *(s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)),
        *(s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)),
    )


@kernel
def by_tensor(e: FloatArray, tensor: int, R: Matrix, v: Vector) -> Vector:
    """Return the product of a tensor and a vector v, both along body axes.

    The tensor is constant along body axes or, in wrong equations, along others: v is turned by R
    as often as `OtherEquations.tensor_turns` says, multiplied by the tensor's entries, and turned
    back by Rᵀ as often.

    Parameters
    ----------
    e : numbers of the equations
    tensor : index at which the tensor begins in `e`
    R : the attitude, body to world
    """
    turns = int(e[TENSOR_TURNS])
    for _ in range(turns):
        v = _times(R, v)
    v = _times(matrix(e, tensor), v)
    for _ in range(turns):
        v = _to_body(R, v)
    return v


@kernel
def _of_world(e: FloatArray, R: Matrix, v: Vector) -> Vector:
    """Return a vector v along world axes, turned to body axes as the equations turn it.

    They may do so wrongly: as `OtherEquations.world_vectors` says, v is turned by Rᵀ, which is
    correct, by R, or not at all. `e` has the numbers of the equations.
    """
    if e[WORLD_VECTORS] >= UNTURNED:
        return v
    return _times(R, v) if e[WORLD_VECTORS] == TURNED_ON else _to_body(R, v)


@kernel
def _resistance(e: FloatArray, R: Matrix, omega: Vector) -> Vector:
    """Return the torque of damping, friction and turned drag against ω, N m, body axes.

    Of the numbers in `slowing`, the coefficient c is included, and a and b are not. `e` has the
    numbers of the equations, and R is the attitude, body to world.
    """
    c, f = e[SLOWING], e[FRICTION]
    speed = math.sqrt(dot(omega, omega))
    if f != 0.0 and speed > 0.0:
        c += f * speed ** e[FRICTION + 1]
    D = vector(e, DAMPING)
    torque = (-(c + D[0]) * omega[0], -(c + D[1]) * omega[1], -(c + D[2]) * omega[2])
    if e[TURNED_DRAG] != 0.0:
        torque = plus(torque, _times(R, omega), -e[TURNED_DRAG])
    if e[TURNED_DRAG + 1] != 0.0:
        torque = plus(torque, _to_body(R, omega), -e[TURNED_DRAG + 1])
    return torque


@kernel
def _unit(axis: int) -> Vector:
    return 1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0


@called
def _of_attitude(e: FloatArray, R: Matrix) -> Vector:
    """Return the torques that depend on the attitude, without that of gravity, N m, body axes.

    They are those of dipoles and springs (`attitude_torque`, `spring`) and of the gravity gradient
    (`gravity_gradient` of `OtherEquations`). `e` has the numbers of the equations, and R is the
    attitude, body to world.
    """
    torque, P, S = (0.0, 0.0, 0.0), matrix(e, ATTITUDE_TORQUE), matrix(e, GRAVITY_GRADIENT)
    for i in range(3):
        column, row = (P[i], P[3 + i], P[6 + i]), (R[3 * i], R[3 * i + 1], R[3 * i + 2])
        torque = plus(torque, _cross(column, row), 1.0)
        unit = _unit(i)
        pulled = _to_body(R, _times(S, _times(R, unit)))
        torque = plus(torque, _cross(unit, by_tensor(e, INERTIA, R, pulled)), 1.0)
    return plus(torque, _turned_from(matrix(e, SPRING), R), -1.0)


@kernel
def _turned_from(spring: Matrix, R: Matrix) -> Vector:
    """Return k φ, N m, with φ the rotation vector from an attitude R₀ to R; `spring` is k R₀."""
    k = math.sqrt(spring[0] ** 2 + spring[3] ** 2 + spring[6] ** 2)
    first = _to_body(spring, (R[0], R[3], R[6]))
    second = _to_body(spring, (R[1], R[4], R[7]))
    third = _to_body(spring, (R[2], R[5], R[8]))
    # k sin ‖φ‖ times the axis, and k cos ‖φ‖.
    turned = ((second[2] - third[1]) / 2, (third[0] - first[2]) / 2, (first[1] - second[0]) / 2)
    sine, cosine = math.sqrt(dot(turned, turned)), (first[0] + second[1] + third[2] - k) / 2
    factor = k * math.atan2(sine, cosine) / sine if sine > 0.0 else 0.0
    return turned[0] * factor, turned[1] * factor, turned[2] * factor


@called
def _torque(e: FloatArray, R: Matrix, omega: Vector) -> Vector:
    """Return I ω', the sum of all torques and of −ω × (G ω + h), N m, body axes.

    `e` has the numbers of the equations, among them G and h; R is the attitude, body to world.
    """
    kept = vector(e, KEPT)
    turned = plus(by_tensor(e, GYROSCOPIC, R, omega), kept, 1.0)
    torque = plus(vector(e, TORQUE), _cross(omega, turned), -1.0)
    gravity = _of_world(e, R, vector(e, GRAVITY_WORLD))
    pull = vector(e, PULL)
    if e[WORLD_VECTORS] == TORQUE_UNTURNED:
        pull = _times(R, pull)
    torque = plus(torque, _cross(pull, gravity), 1.0)
    torque = plus(torque, _of_world(e, R, vector(e, TORQUE_WORLD)), 1.0)
    if e[HAS_TORQUE_OF_ATTITUDE] != 0.0:
        torque = plus(torque, _of_attitude(e, R), 1.0)
    torque = plus(torque, _resistance(e, R, omega), 1.0)
    if e[SLOWING + 1] != 0.0 or e[SLOWING + 2] != 0.0:
        L = plus(by_tensor(e, INERTIA, R, omega), kept, 1.0)
        slowed = e[SLOWING + 1] + e[SLOWING + 2] * math.sqrt(dot(omega, omega))
        torque = plus(torque, L, -slowed)
    if e[MOBILITY] > 0.0:
        up, lever = (R[6], R[7], R[8]), vector(e, LEVER)
        arm = _cross(up, lever)
        answer = by_tensor(e, INVERSE, R, arm)
        swing = dot(up, _cross(omega, _cross(omega, lever)))
        lift = swing - e[GRAVITY_WORLD + 2] - dot(answer, torque)
        torque = plus(torque, arm, lift / (e[MOBILITY] + dot(arm, answer)))
    return torque


@called
def _by_angles(e: FloatArray, R: Matrix, rates: Vector) -> Vector:
    """Return the angular velocity, rad/s, body axes, that given rates of Euler angles amount to.

    An engine that mistakes the components of ω for such rates turns its body so. The result is nan
    in gimbal lock.

    Parameters
    ----------
    e : numbers of the equations; the number at `KINEMATICS` is the angles' convention
    R : the attitude, body to world
    rates : rates of the angles, rad/s: those of the first, second and third angle if the convention
        repeats an axis, as ZYZ does, else those of the angles about x, y and z
    """
    which = int(e[KINEMATICS]) - FIRST_ANGLES
    i, j, k = which // 9, which // 3 % 3, which % 3
    # If the first and third axis are the same, the components are the angles' rates in order.
    a, b, c = rates if i == k else (rates[i], rates[j], rates[k])
    # The node line: the second axis, as the first angle has turned it.
    first, third = _unit(i), _unit(k)
    node = _cross(first, (R[k], R[3 + k], R[6 + k]))
    sign = -1.0 if i != k and (i + 1) % 3 == j else 1.0
    length = sign * math.sqrt(dot(node, node))
    if length == 0.0:
        return math.nan, math.nan, math.nan
    rates_world = plus((a * first[0], a * first[1], a * first[2]), node, b / length)
    return plus(_to_body(R, rates_world), third, c)


@kernel
def turning(e: FloatArray, R: Matrix, omega: Vector) -> Vector:
    """Return the angular velocity at which the attitude turns, rad/s, body axes.

    It is ω if the equations are right. The entries `turning`, `body_turns`, `world_turns` and
    `kinematics` of `OtherEquations` can make it another vector; nan if the attitude is in gimbal
    lock of the Euler angles that the equations integrate.

    Parameters
    ----------
    e : numbers of the equations
    R : the attitude, body to world
    omega : ω, rad/s, body axes
    """
    omega = _times(matrix(e, TURNING), omega)
    kinematics = e[KINEMATICS]
    if kinematics < WORLD:
        omega = plus(omega, vector(e, BODY_TURNS), 1.0)
        return plus(omega, _to_body(R, vector(e, WORLD_TURNS)), -1.0)
    if kinematics == WORLD:
        return _to_body(R, omega)
    return _times(R, omega) if kinematics == KEPT_IN_WORLD else _by_angles(e, R, omega)


@called
def _by_turned_tensor(e: FloatArray, R: Matrix, omega: Vector, torque: Vector) -> Vector:
    """Return ω', rad/s², body axes, of an engine that integrates L and turns the tensor wrongly.

    The engine computes ω = Rᵀ I⁻¹ R L along world axes, where R I⁻¹ Rᵀ L would be right. Its L,
    which only torques change, is therefore Rᵀ I R ω. `e` has the numbers of the equations, R is the
    attitude, body to world, and `torque` is the sum of all torques and of −ω × (G ω + h), N m, body
    axes.
    """
    inverse = matrix(e, INVERSE)
    turned = plus(by_tensor(e, GYROSCOPIC, R, omega), vector(e, KEPT), 1.0)
    outer = plus(torque, _cross(omega, turned), 1.0)
    in_world = _times(R, omega)
    twice = _times(R, in_world)
    rate = _times(inverse, _cross(in_world, _times(matrix(e, INERTIA), twice)))
    rate = plus(rate, _cross(in_world, twice), -1.0)
    rate = plus(rate, _times(inverse, _times(R, _times(R, outer))), 1.0)
    return _to_body(R, _to_body(R, rate))


@kernel
def rates_of(e: FloatArray, y: FloatArray) -> tuple[Vector, Vector]:
    """Return the angular velocity of the attitude, rad/s, and dω/dt, rad/s², both in body axes.

    The angular velocity differs from ω if the equations turn the attitude wrongly: see `turning`.

    Parameters
    ----------
    e : numbers of the equations, a row of what `all_numbers` returns, (n,)
    y : attitude, a quaternion of any norm, scalar first; and ω, rad/s, body axes; (7,)
    """
    R, omega = rotation_of(y), vector(y, 4)
    turned, torque = turning(e, R, omega), _torque(e, R, omega)
    if e[TENSOR_TURNS] == 2:
        accelerated = _by_turned_tensor(e, R, omega, torque)
    else:
        accelerated = by_tensor(e, INVERSE, R, torque)
    if e[KINEMATICS] == KEPT_IN_WORLD:
        # These equations are for components along world axes. Those along body axes also change
        # because the axes turn with the attitude.
        accelerated = plus(accelerated, _cross(omega, turned), 1.0)
    return turned, accelerated
