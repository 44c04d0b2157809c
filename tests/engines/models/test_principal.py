"""The principal frame is exact to a few ulp, right-handed, and the same in both notations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.engines.models.principal_frame import PrincipalFrame, principal_frame
from spincheck.scenarios.body import Body, body_about_com

EPS = np.finfo(float).eps
#: Three products and two sums of rotation entries, each entry good to a few ulp.
ROUNDOFF = 16 * EPS

MOMENTS = {
    "distinct": (1.0, 2.0, 2.5),
    "symmetric": (1.0, 1.0, 0.5),
    "nearly-symmetric": (1.0, 1.0 + 1e-12, 0.5),
    "plate": (1.0, 2.0, 3.0),
    "ball": (1.0, 1.0, 1.0),
    "needle": (1.0, 1.0, 1e-9),
}
ROTATIONS = Rotation.random(20, rng=1)


def turned(moments: tuple[float, float, float], R_body_axes: Rotation) -> Body:
    R = R_body_axes.as_matrix()
    tensor = R @ np.diag(moments) @ R.T
    tensor = (tensor + tensor.T) / 2
    return body_about_com(1.0, (0.0, 0.0, 0.0), tensor.tolist())


def relative_misfit(frame: PrincipalFrame, R_body_axes: Rotation, body: Body) -> float:
    R = R_body_axes.as_matrix()
    misfit = R @ np.diag(frame.moments) @ R.T - body.inertia_com
    return float(np.abs(misfit).max() / np.abs(body.inertia_com).max())


def from_quaternion(frame: PrincipalFrame) -> Rotation:
    return Rotation.from_quat(frame.q_body_axes_wxyz, scalar_first=True)


def from_angles(frame: PrincipalFrame, order: str = "xyz") -> Rotation:
    return Rotation.from_euler(order, frame.rpy_body_axes)


@pytest.mark.parametrize("kind", MOMENTS)
def test_moments_and_axes_give_the_tensor_back_in_either_notation(kind: str) -> None:
    for R_body_axes in ROTATIONS:
        body = turned(MOMENTS[kind], R_body_axes)
        frame = principal_frame(body)
        q = from_quaternion(frame)
        assert relative_misfit(frame, q, body) < ROUNDOFF
        assert (from_angles(frame).inv() * q).magnitude() < ROUNDOFF
        for wrong in (q.inv(), from_angles(frame, "XYZ")) if kind == "distinct" else ():
            assert relative_misfit(frame, wrong, body) > 1e9 * ROUNDOFF


def test_a_diagonal_tensor_keeps_the_body_axes_in_their_order() -> None:
    frame = principal_frame(body_about_com(1.0, (0, 0, 0), np.diag([2.5, 1.0, 2.0]).tolist()))
    assert frame.moments.tolist() == [2.5, 1.0, 2.0]
    assert frame.q_body_axes_wxyz.tolist() == [1, 0, 0, 0]
    assert frame.rpy_body_axes.tolist() == [0, 0, 0]


def excess(frame: PrincipalFrame) -> float:
    """By how much the largest moment exceeds the sum of the others, as doubles."""
    smallest, middle, largest = sorted(frame.moments)
    return float(largest - (smallest + middle))


def test_a_flat_body_obeys_the_triangle_inequality_and_is_kept_as_far_from_flat_as_asked() -> None:
    thickness = 64 * EPS
    for body in (turned(MOMENTS["plate"], R_body_axes) for R_body_axes in ROTATIONS):
        assert excess(principal_frame(body)) <= 0
        frame = principal_frame(body, thickness)
        assert excess(frame) <= -0.5 * thickness * frame.moments.max()
    solid = turned(MOMENTS["distinct"], ROTATIONS[0])
    assert (principal_frame(solid, thickness).moments == principal_frame(solid).moments).all()


def test_gimbal_lock_is_no_trap() -> None:
    # The smallest moment is along z, and the first principal axis belongs to it: pitch is ±90°.
    body = body_about_com(1.0, (0, 0, 0), [[2.0, 0.5, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 1.25]])
    frame = principal_frame(body)
    assert abs(frame.rpy_body_axes[1]) == pytest.approx(np.pi / 2, rel=ROUNDOFF)
    assert relative_misfit(frame, from_quaternion(frame), body) < ROUNDOFF
    assert relative_misfit(frame, from_angles(frame), body) < ROUNDOFF
