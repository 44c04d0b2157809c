"""What PyBullet does to a body by default, and how to take each effect away."""

import pybullet as p

from .model import BASE, HUNG, Model

#: rad/s and m/s: every velocity coordinate of a multibody is clamped at this. (Source:
#: `m_maxCoordinateVelocity` of btMultiBody; measured.)
DEFAULT_CLAMP = 100.0
#: rad/s and m/s; out of reach.
UNREACHED_VELOCITY = 1e100


def take_away_motor(model: Model) -> None:
    """Remove the motor of a spherical joint, which holds the joint's velocity at zero."""
    # Gains as single numbers: only so does a force of zero take the motor out of the solver.
    _set_motor(model, 0)


def idle_motor(model: Model) -> None:
    """Leave the joint's motor in the solver, without a force."""
    _set_motor(model, (0, 0, 0))


def take_away_damping(model: Model) -> None:
    """Set linear and angular damping to 0; of a body with joints both are set at its base."""
    p.changeDynamics(
        model.body, BASE, linearDamping=0, angularDamping=0, physicsClientId=model.client
    )


def take_away_clamp(model: Model) -> None:
    """Raise the clamp of the velocity coordinates out of reach."""
    p.changeDynamics(
        model.body, BASE, maxJointVelocity=UNREACHED_VELOCITY, physicsClientId=model.client
    )


def _set_motor(model: Model, gain: float | tuple[float, float, float]) -> None:
    p.setJointMotorControlMultiDof(
        model.body,
        HUNG,
        p.POSITION_CONTROL,
        targetPosition=(0, 0, 0, 1),
        positionGain=gain,
        velocityGain=gain,
        force=[0, 0, 0],
        physicsClientId=model.client,
    )
