"""A compiled MuJoCo model, stepped and read: shared by the MJCF and the URDF adapter."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, final

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import across, matrices, turned
from ...fault import Fault
from ...models.mjcf import switched_off
from ...read_back import BodyReading, EngineError, State, UnsupportedError
from ...session import Session
from . import clock
from .audit import acting

#: Of a free joint's qpos and qvel, the leading numbers that are the origin's position and velocity.
TRANSLATION = 3
#: What is read at a sample, by MuJoCo's names of it: the clock, qpos and qvel.
READ = int(
    mujoco.mjtState.mjSTATE_TIME | mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL
)
#: How it begins to say that a coordinate is beyond 1e10 (mjMAXVAL), if it is a number at all.
BLOWN_UP = "Nan, Inf or huge value"
#: What it says where the system gives it no memory.
NO_MEMORY = "Could not allocate memory"
#: These, and the steps taken, as the bytes of an array.
Snapshot = bytes


@final
class MuJoCoSession(Session):
    """One body on a ball joint at its origin, or free; the last body of the model.

    Parameters
    ----------
    scenario : what is simulated, for the audit alone
    model : compiled, options and effects set
    qpos, qvel : the start, as `mjcf.start_coordinates` gives it
    has_clock : whether MuJoCo reads the clock that its Python package hangs into it
    """

    def __init__(
        self,
        scenario: Scenario,
        model: Any,
        qpos: Sequence[float],
        qvel: Sequence[float],
        has_clock: bool = False,
    ) -> None:
        self._scenario = scenario
        self.model = model
        self.data = mujoco.MjData(model)
        self.data.qpos[:] = qpos
        self.data.qvel[:] = qvel
        # Filled anew for each snapshot: fetching MuJoCo's own arrays takes as long again.
        self._reading = np.empty(1 + mujoco.mj_stateSize(model, READ))
        self._read = self._reading[1:]
        self._body = model.nbody - 1
        self._com_body = model.body_ipos[self._body].copy()
        self._steps = 0
        self._warnings: list[str] = []
        self._clock = clock.SHIPPED if has_clock else None

    def read_body(self) -> BodyReading:
        """From the compiled model, its principal moments turned back into body axes."""
        model, body = self.model, self._body
        R_body_axes = _rotation(model.body_iquat[body]).as_matrix()
        return BodyReading(
            mass=float(model.body_mass[body]),
            com=model.body_ipos[body].copy(),
            inertia_com=R_body_axes @ np.diag(model.body_inertia[body]) @ R_body_axes.T,
        )

    def read_state(self) -> State:
        """As `states` has it."""
        return State(*(column[0] for column in vars(self.states([self._bytes()])).values()))

    def advance(self, steps: int) -> None:
        """One native loop."""
        with self._stepping():
            # By name, the number of steps would take a fifth of a step longer to pass.
            mujoco.mj_step(self.model, self.data, steps)
        self._steps += steps

    def record(self, strides: Sequence[int], keep: Callable[[Snapshot], object]) -> None:
        """As of any session, listening once and not anew for every sample."""
        step, model, data = mujoco.mj_step, self.model, self.data
        with self._stepping():
            for steps in strides:
                if steps:
                    step(model, data, steps)
                    self._steps += steps
                keep(self.snapshot())

    @contextmanager
    def _stepping(self) -> Iterator[None]:
        """With its clock or none, and with MuJoCo's warnings taken."""
        clock.hang(self._clock)
        with _hearing(self._warnings):
            try:
                yield
            except mujoco.FatalError as error:
                raise EngineError(f"MuJoCo stopped: {error}", "warning") from None

    def check(self) -> None:
        """Any warning, or a clock that is not at the steps taken, is an error."""
        snapshots = [self.snapshot()]
        if fault := self.first_fault(snapshots, self.states(snapshots)):
            raise EngineError(fault.reason, fault.cause)
        if counted := np.count_nonzero(self.data.warning.number):
            raise EngineError(f"MuJoCo counted {counted} kinds of warning", "warning")

    def snapshot(self) -> Snapshot:
        """The state as MuJoCo holds it; what MuJoCo warned of ends the run."""
        if self._warnings:
            warned = f"MuJoCo warned: {self._warnings[0]}"
            fault = self.first_fault([self._bytes()], self.read_state())
            if fault:
                raise EngineError(f"{warned}; {fault.reason}", fault.cause)
            raise EngineError(warned, "not-finite" if BLOWN_UP in warned else "warning")
        return self._bytes()

    def states(self, snapshots: Sequence[Snapshot]) -> State:
        """From qpos and qvel alone: derived data (xipos, cvel) is one step old after a step.

        The com is the body's origin plus the compiled arm, its velocity that of the origin plus
        ω × arm; a ball joint's origin stands still.
        """
        nq = self.model.nq
        rows = _rows(snapshots)
        qpos, qvel = rows[:, 2 : 2 + nq], rows[:, 2 + nq :]
        q_world_body_wxyz, omega_body = qpos[:, -4:], qvel[:, -3:]
        R_world_body = matrices(q_world_body_wxyz)
        com_world = R_world_body @ self._com_body
        velocity_world = turned(R_world_body, omega_body @ across(self._com_body))
        if qvel.shape[1] > TRANSLATION:
            com_world += qpos[:, :TRANSLATION]
            velocity_world += qvel[:, :TRANSLATION]
        return State(q_world_body_wxyz, omega_body, com_world, velocity_world)

    def first_fault(
        self,
        snapshots: Sequence[Snapshot],
        states: State,  # noqa: ARG002
    ) -> Fault | None:
        """The first snapshot whose clock is not at the steps taken."""
        timestep = self.model.opt.timestep
        steps, times = _rows(snapshots)[:, :2].T
        expected = steps * timestep
        # The clock is a running sum: right to far less than half a step.
        is_off = ~(np.abs(times - expected) < timestep / 2)
        if not is_off.any():
            return None
        first = int(np.argmax(is_off))
        wanted, got = float(expected[first]), float(times[first])
        reason = f"MuJoCo's clock must be at {wanted!r} s, got {got!r} s"
        if got < wanted:
            return Fault(first, "reset", f"{reason}: it was reset")
        return Fault(first, "clock", reason)

    def active(self) -> frozenset[str]:
        """What acts, from the compiled model, the data and the process."""
        clock.hang(self._clock)
        names_acting = acting(self.model, self.data, self._scenario)
        return names_acting | {clock.CLOCK} if clock.is_hung() else names_acting

    def close(self) -> None:
        """Drop model and data, which MuJoCo frees with the last reference; hang its clock back."""
        clock.hang(clock.SHIPPED)
        del self.model, self.data

    def _bytes(self) -> Snapshot:
        mujoco.mj_getState(self.model, self.data, self._read, READ)
        self._reading[0] = self._steps
        return self._reading.tobytes()


def _rows(snapshots: Sequence[Snapshot]) -> FloatArray:
    return np.frombuffer(bytearray().join(snapshots)).reshape(len(snapshots), -1)


def left_out(scenario: Scenario) -> tuple[str, ...]:
    """What a scene has no use for: passes by MuJoCo's names, and the clock where there is one."""
    return (*switched_off(scenario), *([clock.CLOCK] if clock.SHIPPED else []))


def check_not_too_small(scenario: Scenario) -> None:
    """Raise `UnsupportedError` for a body that MuJoCo takes none of, whatever the unit."""
    least = min(scenario.body.mass, *scenario.body.principal_moments)
    if least <= mujoco.mjMINVAL:
        raise UnsupportedError(
            f"MuJoCo takes no mass or moment unless it exceeds {mujoco.mjMINVAL:g} (kg, kg m²), "
            f"got {least:.2g}; scale the scene up"
        )


def compiled(build: Callable[[], Any]) -> Any:
    """The model that `build` compiles.

    Raises
    ------
    EngineError
        With the compiler's message, where it refuses or warns.
    MemoryError
        If there is none for it.
    """
    heard: list[str] = []
    # An editable model's warnings come as Python's own.
    with _hearing(heard), warnings.catch_warnings(record=True) as recorded:
        warnings.simplefilter("always")
        try:
            model = build()
        except ValueError as error:
            if NO_MEMORY in str(error):
                raise MemoryError(str(error)) from None
            raise EngineError(f"MuJoCo's compiler: {' '.join(str(error).split())}") from None
    heard += [str(warning.message) for warning in recorded]
    if heard:
        raise EngineError(f"MuJoCo's compiler warned: {heard[0]}")
    return model


@contextmanager
def _hearing(heard: list[str]) -> Iterator[None]:
    """Collect MuJoCo's warnings, which else go to the terminal and to MUJOCO_LOG.TXT."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def _rotation(q_wxyz: FloatArray) -> Rotation:
    return Rotation.from_quat(q_wxyz, scalar_first=True)
