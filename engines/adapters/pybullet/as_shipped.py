"""What PyBullet does to a body by default, and how to take each effect away."""

import pybullet as p

from .model import BASE, HUNG, Model

#: rad/s and m/s: every velocity coordinate of a multibody is clamped at this. (Source:
#: `m_maxCoordinateVelocity` of btMultiBody; measured.)
DEFAULT_CLAMP = 100.0
#: 1/s, linear and angular. (Source: Bullet's user manual; measured.)
DEFAULT_DAMPING = 0.04
#: rad/s and m/s; larger than any velocity of a run.
UNREACHED_VELOCITY = 1e100


def take_away_motor(model: Model) -> None:
    """Remove the motor of a spherical joint, which holds the joint's velocity at zero."""
    # Gains as single numbers: otherwise a force of zero does not remove the motor from the solver.
    _set_motor(model, 0)


def idle_motor(model: Model) -> None:
    """Leave the joint's motor in the solver, without a force."""
    _set_motor(model, (0, 0, 0))


def take_away_damping(model: Model) -> None:
    """Set linear and angular damping to 0; for a body with joints, at its base."""
    p.changeDynamics(
        model.body, BASE, linearDamping=0, angularDamping=0, physicsClientId=model.client
    )


def take_away_clamp(model: Model) -> None:
    """Raise the clamp of the velocity coordinates beyond any velocity of a run."""
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
