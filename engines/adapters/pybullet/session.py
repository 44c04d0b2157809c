"""A session of a scene in a PyBullet world."""

from collections.abc import Sequence
from math import isnan
from struct import pack
from typing import Any, final

import numpy as np
import pybullet as p
from spincheck.engine import (
    BodyReading,
    EngineError,
    Fault,
    FloatArray,
    Scenario,
    Session,
    State,
)

from ....scenarios.rotation import matrix
from ...native_output import native_output
from .audit import what_acts
from .load import BodyRepresentation, load
from .model import Model
from .pivot_limit import check_borne
from .world import BASE, CLAMP, UNREACHED
from .worlds import give_back, take_world

#: Value, rad/s and m/s, at which PyBullet clamps every velocity coordinate of a body in joint
#: coordinates, by default: `m_maxCoordinateVelocity` of btMultiBody, confirmed by measurement.
DEFAULT_CLAMP = 100.0
#: Timestep, s, so short that a body at rest does not move in it.
IDLE = 2.0**-60
#: How far a body is lifted off its contact, in units of its lever and radius of gyration together.
ABOVE = 100.0
#: Relative tolerance of a clamped velocity, which is read back through a rotation and so rounded.
ROTATED = 8 * float(np.finfo(float).eps)
#: Word with which PyBullet's warnings begin.
WARNING = "b3Warning"


@final
class PyBulletSession(Session):
    """A session of one scene in a PyBullet world of its own.

    Parameters
    ----------
    representation : how the body is represented and held, and which defaults are kept
    timestep : length of the steps, s

    Raises
    ------
    EngineError
        If PyBullet cannot load the scene, or warns while loading it. The message has the text that
        PyBullet printed.
    """

    def __init__(
        self, scenario: Scenario, representation: BodyRepresentation, timestep: float
    ) -> None:
        self._scenario, self._is_maximal = scenario, representation.maximal
        self.model = _open(scenario, representation, timestep)
        self.world, self.client = self.model.world, self.model.world.client
        self._clamp = DEFAULT_CLAMP if CLAMP in representation.defaults else UNREACHED
        self._motions: dict[bytes, dict[str, Any]] = {}
        self._is_sound = True

    def read_body(self) -> BodyReading:
        """Return the body, with its rotors, as PyBullet held it after loading."""
        return self.model.body

    def read_state(self) -> State:
        """Return the state after the last step."""
        return self.model.read_state()

    @property
    def can_restart(self) -> bool:
        """True: `restart` makes Bullet forget all that it keeps from earlier steps."""
        return True

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Whether a spherical joint holds the body; PyBullet rounds the pose of any other body."""
        return bool(self.world.link != BASE)

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and the timestep, s, if one is given (`Session.restart`).

        A body that a constraint holds may be set to a state in which it is off its pivot.
        `UnsupportedError` is raised if the pivot of a body in maximal coordinates cannot bear the
        load in that state, `EngineError` if PyBullet is interrupted.
        """
        timestep = self.world.timestep if timestep is None else timestep
        if self._is_maximal and self._scenario.constraint.is_pivot:
            check_borne(self._scenario, state, timestep)
        # Motions are cached, because the same few states are set at many timesteps.
        key = b"".join(column.tobytes() for column in state.columns)
        if key not in self._motions:
            self._motions[key] = self.model.motion(state)
        if self._is_maximal:
            # PyBullet rotates a rigid body's inertia to its attitude only at the end of a step.
            on_pivot = matrix(state.q_world_body_wxyz) @ self.model.body.com
            self._step_at_rest(self._motions[key], on_pivot)
        if self.world.scene["plane"] is not None:
            # PyBullet keeps the impulses of a contact until a step in which nothing touches.
            body, lever = self._scenario.body, self._scenario.constraint.lever
            size = np.linalg.norm(lever) + np.sqrt(body.principal_moments[-1] / body.mass)
            up = np.array([0.0, 0.0, ABOVE * size])
            self._step_at_rest(self._motions[key], state.com_world + up)
        self.world.restart(self._motions[key], timestep)

    def _step_at_rest(self, motion: dict[str, Any], place: FloatArray) -> None:
        """Take a step so short that nothing moves, with the body at rest.

        Parameters
        ----------
        motion : a motion as `World.restart` takes it; only its attitude, `turn`, and its `spins`
            are used
        place : position of the com, m, world axes, (3,)
        """
        rest = np.zeros(3)
        self.world.restart({**motion, "place": place, "omega": rest, "velocity": rest}, IDLE)
        self.advance(1)

    def advance(self, steps: int) -> None:
        """Let the world take steps; raise `EngineError` if PyBullet is interrupted in a step.

        After such an error the world is not used again.
        """
        try:
            self.world.advance(steps)
        except RuntimeError as error:
            self._is_sound = False
            raise EngineError(str(error), "warning") from None

    def check(self) -> None:
        """Raise `EngineError` if the timestep was changed, a velocity is clamped, or ω is NaN."""
        engine, world = p.getPhysicsEngineParameters(self.client), self.world
        wanted = (world.timestep * world.substeps, world.substeps)
        got = (engine["fixedTimeStep"], engine["numSubSteps"])
        if world.substeps and got != wanted:
            raise EngineError(
                f"PyBullet's time and steps a call must be {wanted}, got {got}", "clock"
            )
        snapshots = [self.snapshot()]
        if fault := self.first_fault(snapshots, self.states(snapshots)):
            raise EngineError(fault.reason, fault.cause)

    def snapshot(self) -> bytes:
        """Return com, attitude, velocity, ω and spins as PyBullet returns them, packed as bytes.

        `EngineError` is raised if ω is NaN: in such a state PyBullet's solvers might not return.
        """
        com_world, q_xyzw, velocity_world, omega_world = self.world.motion()
        if isnan(omega_world[0]):
            raise EngineError("the state is no longer finite", "not-finite")
        spins = self.world.spins()
        numbers = (*com_world, *q_xyzw, *velocity_world, *omega_world, *spins)
        return pack(f"{len(numbers)}d", *numbers)

    def states(self, snapshots: Sequence[bytes]) -> State:
        """Return the states of n snapshots, in the scene's body axes."""
        rows = np.frombuffer(bytearray().join(snapshots)).reshape(len(snapshots), -1)
        return self.model.states(rows)

    def first_fault(
        self,
        snapshots: Sequence[bytes],  # noqa: ARG002
        states: State,
    ) -> Fault | None:
        """Return a fault for the first of n states with a clamped velocity; None if there is none.

        `states` has the n states; `snapshots`, from which they were converted, is ignored.
        """
        clamped = np.abs(self.model.coordinates(states)) >= self._clamp * (1 - ROTATED)
        if not clamped.any():
            return None
        reason = f"PyBullet clamps velocities at {self._clamp:g}"
        return Fault(int(np.argmax(clamped.any(axis=1))), "clamp", reason)

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from PyBullet or measured. The measurements (`what_acts`) change the body's
        state and PyBullet's settings.
        """
        return what_acts(self.advance, self.model, self._scenario)

    def close(self) -> None:
        """Give the world back for reuse, or disconnect it after an interruption or a blow-up."""
        if not p.isConnected(self.client):
            return
        if self._is_sound and np.isfinite(self.read_state().omega_body).all():
            give_back(self.client)
        else:
            p.disconnect(self.client)


def _open(scenario: Scenario, representation: BodyRepresentation, timestep: float) -> Model:
    """Return the scene's body in a world of its own, at the start.

    `representation` says how the body is represented and held.

    Raises
    ------
    EngineError
        If PyBullet cannot load the scene, or warns. The message has the text that it printed.
    """
    client = -1
    try:
        with native_output() as printed:
            client = take_world()
            model = load(client, scenario, representation, timestep)
        if WARNING in printed.text:
            raise EngineError("PyBullet warns")
    except EngineError as error:
        if client >= 0:
            p.disconnect(client)
        warning = f"; PyBullet printed: {printed.text.strip()}" if printed.text.strip() else ""
        raise type(error)(f"{error}{warning}", error.cause) from None
    return model
