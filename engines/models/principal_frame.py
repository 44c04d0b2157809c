"""Computes the principal frame of a body, independently of any engine's eigensolver."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from mpmath import mp, mpf

from ...scenarios import Body, FloatArray
from ...scenarios.exact import DIGITS, Quaternion, Tensor, Vector, product, rotate
from ...scenarios.float_array import read_only
from ...scenarios.principal import IDENTITY, principal_axes

#: Number of bodies whose frame is kept, as every run of a scene needs it.
KEPT = 64
#: Cosine of the pitch below which roll and yaw turn about the same axis, so that only their sum or
#: difference is defined. Its exponent is half the number of working digits.
GIMBAL_LOCK = mpf(10) ** (-DIGITS // 2)


@dataclass(frozen=True, eq=False)
class PrincipalFrame:
    """Principal moments about the centre of mass, and the right-handed axes that they belong to.

    Attributes
    ----------
    moments : principal moments about x, y and z of the principal frame, kg m², (3,)
    q_body_axes_wxyz : quaternion that takes components along the principal axes to those along body
        axes, (4,)
    rpy_body_axes : the same rotation as roll, pitch and yaw of URDF, rad, (3,):
        R = Rz(yaw) Ry(pitch) Rx(roll)
    """

    moments: FloatArray
    q_body_axes_wxyz: FloatArray
    rpy_body_axes: FloatArray


@lru_cache(maxsize=KEPT)
def principal_frame(body: Body, thickness: float = 0.0) -> PrincipalFrame:
    """Return the principal frame of a body about its com, with moments that engines accept.

    Engines refuse a flat body if rounding makes its largest moment exceed the sum of the others. So
    the largest moment is reduced if it exceeds (1 − `thickness`) times the sum of the others.

    Parameters
    ----------
    thickness : relative margin of the triangle inequality, 0 or more
    """
    moments, R_body_axes = principal_axes(body.inertia_com_exact)
    with mp.workdps(DIGITS):
        rpy = _roll_pitch_yaw(R_body_axes)
        return PrincipalFrame(
            read_only(_within_triangle(moments, thickness)),
            read_only(_quaternion(rpy)),
            read_only(rpy),
        )


def roll_pitch_yaw_of(q: Quaternion) -> FloatArray:
    """Return roll, pitch and yaw of a rotation, rad, (3,), as URDF defines them."""
    with mp.workdps(DIGITS):
        columns = [rotate(q, axis) for axis in IDENTITY]
        first, second, third = zip(*columns, strict=True)
        return read_only(_roll_pitch_yaw((first, second, third)))


def _within_triangle(moments: Iterable[mpf], thickness: float) -> list[float]:
    """Return three moments as doubles; the largest is reduced to obey the triangle inequality.

    Parameters
    ----------
    moments : three principal moments, kg m²
    thickness : relative margin (`principal_frame`)
    """
    rounded = [float(moment) for moment in moments]
    largest = rounded.index(max(rounded))
    others = rounded[:largest] + rounded[largest + 1 :]
    rounded[largest] = min(rounded[largest], sum(others) * (1 - thickness))
    return rounded


def _roll_pitch_yaw(R: Tensor) -> Vector:
    """Return roll, pitch and yaw, rad, of a rotation R = Rz(yaw) Ry(pitch) Rx(roll).

    The formulas are those of Diebel 2006, Representing Attitude, §5.6.12.
    """
    cos_pitch = mp.hypot(R[0][0], R[1][0])
    pitch = mp.atan2(-R[2][0], cos_pitch)
    if cos_pitch < GIMBAL_LOCK:
        return (mpf(0), pitch, mp.atan2(-R[0][1], R[1][1]))
    return (mp.atan2(R[2][1], R[2][2]), pitch, mp.atan2(R[1][0], R[0][0]))


def _quaternion(rpy: Vector) -> Quaternion:
    """Return the quaternion, w x y z, of the rotation with given roll, pitch and yaw, rad."""
    (cr, cp, cy), (sr, sp, sy) = ([f(angle / 2) for angle in rpy] for f in (mp.cos, mp.sin))
    zero = mpf(0)
    return product(product((cy, zero, zero, sy), (cp, zero, sp, zero)), (cr, sr, zero, zero))
