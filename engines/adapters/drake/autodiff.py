"""Derivatives of steps and of dω/dt, by Drake's automatic differentiation (`AutoDiffXd`)."""

from typing import Any

import numpy as np
import pydrake.all as drake
from spincheck.engine import FloatArray, UnsupportedError, numbers_by_chart

from ...world_parts import matrix


def differentiated(world: Any, steps: int) -> tuple[FloatArray, FloatArray]:
    """Return an attitude, w x y z, (4,), and derivatives by the present state in the chart.

    For a discrete plant the attitude is that after `steps` steps, and the derivatives are those of
    this quaternion and of ω at that time, (7, 6). For any other plant the attitude is the present
    one, and the derivatives are those of dω/dt, (3, 6). Axes are those of the scene's record.

    Parameters
    ----------
    world : a `World` of the adapter's `world.py`
    steps : number of steps; ignored unless the plant is discrete

    Raises
    ------
    UnsupportedError
        If the scene has torques that are applied from outside the plant.
    RuntimeError
        If Drake cannot differentiate the plant.
    """
    if world.plant.get_applied_spatial_force_input_port().HasValue(world.context):
        raise UnsupportedError("the torques are its caller's, which AutoDiff does not see")
    motion = world.motion()
    q, omega_world = motion[:4], motion[4:7]
    # Drake's type stubs accept only arrays without a shape.
    start: Any = np.concatenate([q, matrix(q).T @ omega_world])
    by_chart: Any = numbers_by_chart(q)
    numbers = drake.InitializeAutoDiff(start, gradient=by_chart).ravel()
    plant = world.plant.ToAutoDiffXd()
    context = plant.CreateDefaultContext()
    context.SetTimeStateAndParametersFrom(world.context)
    body = _set(world, plant, context, numbers)
    if world.is_discrete:
        after = context.Clone()
        for _ in range(steps):
            plant.CalcForcedUnrestrictedUpdate(context, after.get_mutable_state())
            context.SetTimeStateAndParametersFrom(after)
        found = _turning(body.EvalSpatialVelocityInWorld(after), body, after)
        attitude = body.EvalPoseInWorld(after).rotation().ToQuaternion().wxyz()
        found = np.concatenate([attitude, found])
        return drake.ExtractValue(attitude.reshape(-1, 1)).ravel(), _gradient(found)
    # d(R ω)/dt is R dω/dt, because ω × ω is zero.
    rate = _turning(body.EvalSpatialAccelerationInWorld(context), body, context)
    return q, _gradient(rate)


def _set(world: Any, plant: Any, context: Any, numbers: Any) -> Any:
    """Set attitude and ω in a context of a plant; return the plant's body.

    Parameters
    ----------
    world : the world
    plant : the world's plant, converted to numbers of type `AutoDiffXd`
    context : a context of `plant`
    numbers : the attitude, w x y z, and ω in body axes, with their gradients, (7,)
    """
    joint = plant.get_joint(world.joint.index())
    quaternion = drake.Quaternion_[drake.AutoDiffXd](wxyz=numbers[:4])
    R = drake.RotationMatrix_[drake.AutoDiffXd](quaternion)
    if world.is_free:
        joint.SetQuaternion(context, quaternion)
    else:
        own = drake.RotationMatrix(world.R_frame_own).cast[drake.AutoDiffXd]()
        angles = drake.RollPitchYaw_[drake.AutoDiffXd](R.multiply(own))
        joint.set_angles(context, angles.vector())
    joint.set_angular_velocity(context, R.matrix() @ numbers[4:])
    return plant.get_body(world.body.index())


def _turning(spatial: Any, body: Any, context: Any) -> Any:
    """Return the angular part, in body axes, (3,), of a body's spatial velocity or acceleration.

    `spatial` is this velocity or acceleration in world axes; `context` has the body's attitude.
    """
    R = body.EvalPoseInWorld(context).rotation().matrix()
    return R.T @ spatial.rotational()


def _gradient(numbers: Any) -> FloatArray:
    """Return the derivatives that n numbers of type `AutoDiffXd` hold, one number a row, (n, 6)."""
    return np.asarray(drake.ExtractGradient(numbers.reshape(-1, 1)))
