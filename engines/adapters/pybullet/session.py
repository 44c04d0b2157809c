"""A scene running in PyBullet: its steps, and the torques that no model element gives."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import cache, cached_property
from math import isnan
from struct import Struct
from typing import final

import numpy as np
import pybullet as p

from ....scenarios import Scenario
from ...checks.equations import Equations
from ...checks.read_back import BodyReading, EngineError, State
from ...fault import Fault
from ...native_output import native_output
from ...session import Session
from .as_shipped import DEFAULT_CLAMP, UNREACHED_VELOCITY
from .audit import what_acts
from .load import CLAMP, BodyRepresentation, load
from .model import BASE, HUNG, Model, Placed
from .pivot_limit import check_borne
from .torques import torques
from .worlds import give_back, take_world

#: Largest number of steps in a native call, some 20 ms, as a call cannot be interrupted.
MOST_STEPS_A_CALL = 2**14
#: s, of a step in which a body at rest goes nowhere.
IDLE = 2.0**-60
#: A clamped velocity is read back through a rotation, with a few rounding errors.
ROTATED = 8 * float(np.finfo(float).eps)
#: Three numbers of the com, four of the attitude, three of its velocity, three of ω.
MOTION = Struct("13d")
NOT_FINITE, NOT_COMPLETED = "the state is no longer finite", "PyBullet did not complete a step"
#: How PyBullet marks what it warns of.
WARNING = "b3Warning"


@final
class PyBulletSession(Session):
    """One scene in a world of its own.

    Raises
    ------
    EngineError
        If PyBullet cannot load the scene, or warns while it does; with what it printed.
    """

    def __init__(
        self,
        scenario: Scenario,
        representation: BodyRepresentation,
        timestep: float,
        left_in: Collection[str] = (),
    ) -> None:
        self._scenario, self._is_maximal = scenario, representation.maximal
        self._rests = representation.by_contact
        self.client, self.model = _open(scenario, representation, left_in)
        self._clamp = DEFAULT_CLAMP if CLAMP in representation.defaults else UNREACHED_VELOCITY
        self._torques, self.at_once = torques(self.model, scenario)
        self._placed: dict[bytes, Placed] = {}
        self._is_sound = True
        self.set_timestep(timestep)

    def read_body(self) -> BodyReading:
        """Mass, com and tensor as PyBullet holds them."""
        return self.model.read_body()

    def read_state(self) -> State:
        """The state now."""
        return self.model.read_state()

    def set_timestep(self, timestep: float) -> None:
        """Length of the steps from now on, s."""
        self._timestep = timestep
        self._substeps = 0

    @property
    def can_restart(self) -> bool:
        """Unless it lies on a contact, whose impulses Bullet keeps from step to step."""
        return not self._rests

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Whether the body is on a joint; any other pose is composed as it is loaded."""
        return self.model.link == HUNG

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set pose and velocities; a body held by a constraint is set off its pivot, too."""
        timestep = self._timestep if timestep is None else timestep
        if self._is_maximal and self._scenario.constraint.is_pivot:
            check_borne(self._equations, state, timestep)
        # The same few states are set at many timesteps.
        turned = state.q_world_body_wxyz.tobytes() + state.omega_body.tobytes()
        if turned not in self._placed:
            self._placed[turned] = self.model.placed(state)
        placed = self._placed[turned]
        if self._is_maximal:
            self._renew_inertia(placed)
        self.model.place(placed, state.com_world, state.velocity_world)
        if self.model.hinges:
            self.model.hinges.set(state.spins)
        self.set_timestep(timestep)

    def _renew_inertia(self, placed: Placed) -> None:
        """Have PyBullet turn a rigid body's inertia, which it does at the end of a step only."""
        rest = np.zeros(3)
        com_world = placed.arm_world if self._scenario.constraint.is_pivot else rest
        self.model.place(replace(placed, omega=rest), com_world, rest)
        self.set_timestep(IDLE)
        self.advance(1)

    @cached_property
    def _equations(self) -> Equations:
        return Equations(self._scenario)

    def advance(self, steps: int) -> None:
        """Take `steps` whole steps, many a call where no torque has to be renewed in between."""
        if steps == self._substeps and self.at_once:
            self._step(steps)
        elif self.at_once:
            for substeps in calls(steps, self._timestep):
                self._step(substeps)
        else:
            for _ in range(steps):
                self._step(1)

    def _step(self, substeps: int) -> None:
        if substeps != self._substeps:
            p.setPhysicsEngineParameter(
                fixedTimeStep=self._timestep * substeps,
                numSubSteps=substeps,
                physicsClientId=self.client,
            )
            self._substeps = substeps
        for apply in self._torques:
            apply()
        if p.stepSimulation(self.client) is None:
            raise self._not_completed()

    def _not_completed(self) -> EngineError:
        """The error of a step that was given up; its world is not used again."""
        self._is_sound = False
        return EngineError(NOT_COMPLETED, "warning")

    def record(self, strides: Sequence[int], keep: Callable[[bytes], object]) -> None:
        """As in `Session`, without other calls between PyBullet's: each takes a tenth of a step."""
        step, client, read = p.stepSimulation, self.client, self._reader()
        # Steps without torques to renew; PyBullet has been told their number.
        is_plain = self.at_once and not self._torques
        for steps in strides:
            if steps and is_plain and steps == self._substeps:
                if step(client) is None:
                    raise self._not_completed()
            elif steps:
                self.advance(steps)
            keep(read())

    def check(self) -> None:
        """Raise if the clock is not what was set, a velocity is clamped, or the pivot gave way."""
        world = p.getPhysicsEngineParameters(self.client)
        wanted = (self._timestep * self._substeps, self._substeps)
        got = (world["fixedTimeStep"], world["numSubSteps"])
        if self._substeps and got != wanted:
            raise EngineError(
                f"PyBullet's time and steps a call must be {wanted}, got {got}", "clock"
            )
        snapshots = [self.snapshot()]
        if fault := self.first_fault(snapshots, self.states(snapshots)):
            raise EngineError(fault.reason, fault.cause)

    def snapshot(self) -> bytes:
        """The numbers of the motion as PyBullet returns them, in one array of bytes."""
        return self._reader()()

    def _reader(self) -> Callable[[], bytes]:
        """A function that makes snapshots: `Model.motion`, packed, with all that is constant bound.

        A state that is not finite ends the run: the solvers might not return from it.
        """
        body, link, client, pack = self.model.body, self.model.link, self.client, MOTION.pack
        pose, velocity, link_state = (
            p.getBasePositionAndOrientation,
            p.getBaseVelocity,
            p.getLinkState,
        )

        def of_base() -> bytes:
            com_world, q_xyzw = pose(body, client)
            velocity_world, omega_world = velocity(body, client)
            if isnan(omega_world[0]):
                raise EngineError(NOT_FINITE, "not-finite")
            return pack(*com_world, *q_xyzw, *velocity_world, *omega_world)

        def of_link() -> bytes:
            com_world, q_xyzw, _, _, _, _, velocity_world, omega_world = link_state(
                body, link, 1, 1, client
            )
            if isnan(omega_world[0]):
                raise EngineError(NOT_FINITE, "not-finite")
            return pack(*com_world, *q_xyzw, *velocity_world, *omega_world)

        of_body = of_base if link == BASE else of_link
        hinges = self.model.hinges
        if hinges is None:
            return of_body
        # Not with `pack`, whose numbers are those of one body.
        return lambda: of_body() + np.array(hinges.read()).tobytes()

    def states(self, snapshots: Sequence[bytes]) -> State:
        """The states of n snapshots, in spincheck's frames."""
        rows = np.frombuffer(bytearray().join(snapshots)).reshape(len(snapshots), -1)
        return self.model.states(rows)

    def first_fault(
        self,
        snapshots: Sequence[bytes],  # noqa: ARG002
        states: State,
    ) -> Fault | None:
        """The first snapshot in which a velocity is clamped."""
        clamped = np.abs(self.model.coordinates(states)) >= self._clamp * (1 - ROTATED)
        if not clamped.any():
            return None
        reason = f"PyBullet clamps velocities at {self._clamp:g}"
        return Fault(int(np.argmax(clamped.any(axis=1))), "clamp", reason)

    def active(self) -> frozenset[str]:
        """What acts, read back and felt: see `audit`."""
        return what_acts(self, self.model, self._scenario, rests=self._rests)

    def close(self) -> None:
        """Return the world for reuse; if something went wrong in it, disconnect it."""
        try:
            is_finite = bool(np.isfinite(self.read_state().omega_body).all())
        except p.error:
            is_finite = False
        if self._is_sound and is_finite:
            give_back(self.client)
        elif p.isConnected(self.client):
            p.disconnect(self.client)


def _open(
    scenario: Scenario, representation: BodyRepresentation, left_in: Collection[str]
) -> tuple[int, Model]:
    """A world with the scene's body and gravity in it."""
    client = -1
    try:
        with native_output() as printed:
            client = take_world()
            model = load(client, scenario, representation, left_in)
            p.setGravity(*scenario.gravity_world, physicsClientId=client)
        if WARNING in printed.text:
            raise EngineError("PyBullet warns")
    except EngineError as error:
        if client >= 0:
            p.disconnect(client)
        warning = f"; PyBullet printed: {printed.text.strip()}" if printed.text.strip() else ""
        raise type(error)(f"{error}{warning}", error.cause) from None
    return client, model


@cache
def calls(steps: int, timestep: float) -> tuple[int, ...]:
    """Steps a call that add up to `steps`: one call where PyBullet takes exactly that many.

    PyBullet gets k dt and k, divides the one by the other, and takes as many steps as fit. With k a
    power of two that is exact; with another it may be a step less, or of another length.
    """
    span = steps * timestep
    each = span / steps
    if steps <= MOST_STEPS_A_CALL and each == timestep and int(span / each) == steps:
        return (steps,)
    chunk = min(1 << (steps.bit_length() - 1), MOST_STEPS_A_CALL)
    rest = steps - chunk
    return (chunk, *calls(rest, timestep)) if rest else (chunk,)
