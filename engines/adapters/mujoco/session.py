"""A session of a compiled MuJoCo model, which may come from MJCF or URDF."""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, final

import mujoco
import numpy as np
from spincheck.engine import (
    Derivative,
    EngineError,
    Fault,
    FloatArray,
    Scenario,
    State,
    UnsupportedError,
)

from . import clock
from .audit import acting
from .coordinates import CoordinateSession
from .world import at_start, set_timestep

#: MuJoCo's flag for what is read at a sample: time, qpos and qvel.
READ = int(
    mujoco.mjtState.mjSTATE_TIME | mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL
)
#: Words in MuJoCo's warnings that a coordinate is not a number or beyond 1e10 (mjMAXVAL).
BLOWN_UP = "Nan, Inf or huge value"
#: Words in MuJoCo's message that there is not enough memory.
NO_MEMORY = "Could not allocate memory"
#: Change of a coordinate in finite differences, rad or rad/s; the value of MuJoCo's tutorials.
EPSILON = 1e-6
#: A snapshot: time, qpos, qvel and the number of steps taken, as the bytes of an array.
Snapshot = bytes


@final
class MuJoCoSession(CoordinateSession):
    """A session of a compiled MuJoCo model of one body and its rotors.

    It starts at the model's first keyframe. Other bodies may be welded to the body.

    Parameters
    ----------
    scenario : the scene that is simulated
    model : the compiled model, with options and effects set
    has_clock : whether MuJoCo reads the clock that its Python package installs
    tied : time constant of contacts, in timesteps; 0 to keep the model's own
    """

    def __init__(
        self, scenario: Scenario, model: Any, has_clock: bool = False, tied: float = 0.0
    ) -> None:
        super().__init__(scenario, model)
        self.model, self.data, self._tied = model, at_start(model), tied
        # One array that each snapshot is read into: fetching MuJoCo's own arrays takes twice as
        # long.
        self._reading = np.empty(1 + mujoco.mj_stateSize(model, READ))
        self._read = self._reading[1:]
        self._steps = 0
        self._warnings: list[str] = []
        self._clock = clock.SHIPPED if has_clock else None

    def read_state(self) -> State:
        """Return the state after the last step, even if MuJoCo has warned."""
        return self.states([self._bytes()]).rows(0)

    def set_timestep(self, timestep: float) -> None:
        """Set the length of the steps from now on, s."""
        set_timestep(self.model, timestep, self._tied)

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and the timestep, s, if one is given (`Session.restart`).

        Before this, the data are reset by `mj_resetData`; warnings are forgotten.
        """
        if timestep is not None:
            self.set_timestep(timestep)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = self.coordinates(state)
        self._steps = 0
        self._warnings.clear()

    def advance(self, steps: int) -> None:
        """Take `steps` steps in one native loop; store warnings, for which `check` then raises."""
        with self._stepping():
            # Passing `steps` by keyword would take a fifth of the time of a step longer.
            mujoco.mj_step(self.model, self.data, steps)
        self._steps += steps

    def record(self, strides: Sequence[int], keep: Callable[[Snapshot], object]) -> None:
        """Take strides of given numbers of steps, and pass a snapshot after each stride to `keep`.

        MuJoCo's warnings are redirected once for all strides, and not again for each.
        """
        step, model, data = mujoco.mj_step, self.model, self.data
        with self._stepping():
            for steps in strides:
                if steps:
                    step(model, data, steps)
                    self._steps += steps
                keep(self.snapshot())

    @contextmanager
    def _stepping(self) -> Iterator[None]:
        """Collect MuJoCo's warnings inside the block, in which MuJoCo may take steps.

        At the start of the block, MuJoCo's clock is set to the one in `_clock`, or to none. A
        fatal error of MuJoCo is raised as `EngineError`.
        """
        clock.hang(self._clock)
        try:
            with _hearing(self._warnings):
                yield
        except mujoco.FatalError as error:
            raise EngineError(f"MuJoCo stopped: {error}", "warning") from None

    def check(self) -> None:
        """Raise `EngineError` if MuJoCo warned, or if its clock does not match the steps taken."""
        snapshots = [self.snapshot()]
        if fault := self.first_fault(snapshots, self.states(snapshots)):
            raise EngineError(fault.reason, fault.cause)
        if counted := np.count_nonzero(self.data.warning.number):
            raise EngineError(f"MuJoCo counted {counted} kinds of warning", "warning")

    def snapshot(self) -> Snapshot:
        """Return the present snapshot; raise `EngineError` if MuJoCo has warned."""
        if self._warnings:
            warned = f"MuJoCo warned: {self._warnings[0]}"
            fault = self.first_fault([self._bytes()], self.read_state())
            if fault:
                raise EngineError(f"{warned}; {fault.reason}", fault.cause)
            raise EngineError(warned, "not-finite" if BLOWN_UP in warned else "warning")
        return self._bytes()

    def states(self, snapshots: Sequence[Snapshot]) -> State:
        """Return the states of n snapshots, computed from qpos and qvel alone.

        MuJoCo's derived data (xipos, cvel) are not read: they are those of the step before.
        """
        _, qpos, qvel = np.split(_rows(snapshots), [2, 2 + self.model.nq], axis=1)
        return self.states_at(qpos, qvel)

    def first_fault(
        self,
        snapshots: Sequence[Snapshot],
        states: State,  # noqa: ARG002
    ) -> Fault | None:
        """Return a fault for the first snapshot whose time does not match the steps taken.

        It is None if all times match. `states` is ignored.
        """
        timestep = self.model.opt.timestep
        steps, times = _rows(snapshots)[:, :2].T
        expected = steps * timestep
        # MuJoCo's time is a running sum, whose rounding error is far less than half a step.
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
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from MuJoCo. "clock" is included if MuJoCo reads a clock while it steps.
        """
        clock.hang(self._clock)
        names_acting = acting(self.model, self.data, self._scenario)
        return names_acting | {clock.CLOCK} if clock.is_hung() else names_acting

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the Jacobians of a step by `mjd_transitionFD`, with two kinds of differences.

        These are forward and centred; the mapping's keys name them.
        """
        return {
            f"mjd_transitionFD, {way}": Derivative(partial(self._transition, centred), EPSILON)
            for way, centred in {"forward": False, "centred": True}.items()
        }

    def _transition(self, centred: bool) -> FloatArray:
        """Return the Jacobian of the next step, in the chart, (6, 6).

        It consists of rows and columns of MuJoCo's matrix A, in which the attitude's derivatives
        are by a turn in body axes, as in the chart. `centred` says whether differences are centred;
        else they are forward. `UnsupportedError` is raised if MuJoCo refuses, or if the body is on
        hinges.
        """
        nv = self.model.nv
        A = np.zeros((2 * nv, 2 * nv))
        try:
            mujoco.mjd_transitionFD(self.model, self.data, EPSILON, centred, A, None, None, None)
        except mujoco.FatalError as error:
            raise UnsupportedError(f"MuJoCo: {error}") from None
        kept = self.turning
        kept = np.concatenate([kept, kept + nv])
        return A[np.ix_(kept, kept)]

    def close(self) -> None:
        """Drop model and data, and restore the clock of MuJoCo's package."""
        clock.hang(clock.SHIPPED)
        del self.model, self.data

    def _bytes(self) -> Snapshot:
        """Return the present snapshot, even if MuJoCo has warned."""
        mujoco.mj_getState(self.model, self.data, self._read, READ)
        self._reading[0] = self._steps
        return self._reading.tobytes()


def _rows(snapshots: Sequence[Snapshot]) -> FloatArray:
    """Return n snapshots as the rows of an array, (n, 2 + nq + nv).

    A row has the number of steps, the time, s, qpos and qvel.
    """
    return np.frombuffer(bytearray().join(snapshots)).reshape(len(snapshots), -1)


def check_not_too_small(scenario: Scenario) -> None:
    """Raise `UnsupportedError` if a mass or moment of body or rotors is too small for MuJoCo."""
    parts = scenario.carrier, *(rotor.body for rotor in scenario.rotors.each)
    least = min(min(part.mass, *part.principal_moments) for part in parts)
    if least <= mujoco.mjMINVAL:
        raise UnsupportedError(
            f"MuJoCo takes no mass or moment unless it exceeds {mujoco.mjMINVAL:g} (kg, kg m²), "
            f"got {least:.2g}; scale the scene up"
        )


def compiled(build: Callable[[], Any]) -> Any:
    """Return the model that `build` compiles; a warning of the compiler is raised as an error.

    Raises
    ------
    EngineError
        If the compiler refuses the model or warns; the message is the compiler's.
    MemoryError
        If there is not enough memory.
    """
    messages: list[str] = []
    # Warnings of an editable model (MjSpec) are Python warnings.
    with _hearing(messages), warnings.catch_warnings(record=True) as recorded:
        warnings.simplefilter("always")
        try:
            model = build()
        except ValueError as error:
            if NO_MEMORY in str(error):
                raise MemoryError(str(error)) from None
            raise EngineError(f"MuJoCo's compiler: {' '.join(str(error).split())}") from None
    messages += [str(warning.message) for warning in recorded]
    if messages:
        raise EngineError(f"MuJoCo's compiler warned: {messages[0]}")
    return model


@contextmanager
def _hearing(messages: list[str]) -> Iterator[None]:
    """Append to `messages` the warnings that MuJoCo gives inside the block.

    Without this, MuJoCo would write them to the terminal and to MUJOCO_LOG.TXT.
    """
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(messages.append)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)
