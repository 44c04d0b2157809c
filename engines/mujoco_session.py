"""A compiled MuJoCo model, stepped and read: shared by the MJCF and the URDF adapter."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, final

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray, Scenario
from .mujoco_audit import acting
from .read_back import BodyReading, EngineError, State
from .rotation import rotated
from .session import Session

#: Of a free joint's qpos and qvel, the leading numbers that are the origin's position and velocity.
TRANSLATION = 3
#: Steps taken, the clock, and the bytes of qpos and qvel.
Snapshot = tuple[int, float, bytes, bytes]


@final
class MuJoCoSession(Session):
    """One body on a ball joint at its origin, or free; the last body of the model.

    Parameters
    ----------
    scenario : what is simulated, for the audit alone
    model : compiled, options and effects set
    qpos, qvel : the start, as `mjcf.start_coordinates` gives it
    """

    def __init__(
        self, scenario: Scenario, model: Any, qpos: Sequence[float], qvel: Sequence[float]
    ) -> None:
        self._scenario = scenario
        self._model = model
        self._data = data = mujoco.MjData(model)
        data.qpos[:] = qpos
        data.qvel[:] = qvel
        # Views of what MuJoCo updates in place: fetching them anew takes longer than a copy.
        self._qpos, self._qvel, self._counts = data.qpos, data.qvel, data.warning.number
        self._no_counts = bytes(self._counts.nbytes)
        self._body = model.nbody - 1
        self._com_body = model.body_ipos[self._body].copy()
        self._steps = 0
        self._warnings: list[str] = []

    def read_body(self) -> BodyReading:
        """From the compiled model, its principal moments turned back into body axes."""
        model, body = self._model, self._body
        R_body_axes = _rotation(model.body_iquat[body]).as_matrix()
        return BodyReading(
            mass=float(model.body_mass[body]),
            com=model.body_ipos[body].copy(),
            inertia_com=R_body_axes @ np.diag(model.body_inertia[body]) @ R_body_axes.T,
        )

    def read_state(self) -> State:
        """As `states` has it."""
        return State(*(column[0] for column in vars(self.states([self._reading()])).values()))

    def advance(self, steps: int) -> None:
        """One native loop."""
        previous = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(self._warnings.append)
        try:
            mujoco.mj_step(self._model, self._data, nstep=steps)
        except mujoco.FatalError as error:
            raise EngineError(f"MuJoCo stopped: {error}") from None
        finally:
            mujoco.set_mju_user_warning(previous)
        self._steps += steps

    def check(self) -> None:
        """Any warning, or a clock that is not at the steps taken, is an error."""
        snapshots = [self.snapshot()]
        if fault := self.first_fault(snapshots, self.states(snapshots)):
            raise EngineError(fault[1])

    def snapshot(self) -> Snapshot:
        """The state as MuJoCo holds it; what MuJoCo warned of ends the run."""
        if self._warnings:
            again = "; it was reset" if self._is_reset(self._steps, self._data.time) else ""
            raise EngineError(f"MuJoCo warned: {self._warnings[0]}{again}")
        if self._counts.tobytes() != self._no_counts:
            raise EngineError(f"MuJoCo counted {np.count_nonzero(self._counts)} kinds of warning")
        return self._reading()

    def states(self, snapshots: Sequence[Snapshot]) -> State:
        """From qpos and qvel alone: derived data (xipos, cvel) is one step old after a step.

        The com is the body's origin plus the compiled arm, its velocity that of the origin plus
        ω × arm; a ball joint's origin stands still.
        """
        _, _, positions, velocities = zip(*snapshots, strict=True)
        qpos, qvel = (
            np.frombuffer(bytearray().join(rows)).reshape(len(snapshots), -1)
            for rows in (positions, velocities)
        )
        q_world_body_wxyz, omega_body = qpos[:, -4:], qvel[:, -3:]
        com_world = rotated(q_world_body_wxyz, self._com_body[None])
        swing_body = np.cross(omega_body, self._com_body)
        velocity_world = rotated(q_world_body_wxyz, swing_body)
        if qvel.shape[1] > TRANSLATION:
            com_world = com_world + qpos[:, :TRANSLATION]
            velocity_world = velocity_world + qvel[:, :TRANSLATION]
        return State(q_world_body_wxyz, omega_body, com_world, velocity_world)

    def first_fault(
        self,
        snapshots: Sequence[Snapshot],
        states: State,  # noqa: ARG002
    ) -> tuple[int, str] | None:
        """The first snapshot whose clock is not at the steps taken."""
        steps, times = (np.array(column) for column in tuple(zip(*snapshots, strict=True))[:2])
        late = self._is_reset(steps, times)
        if not late.any():
            return None
        first = int(np.argmax(late))
        expected = float(steps[first] * self._model.opt.timestep)
        got = float(times[first])
        return first, f"MuJoCo's clock must be at {expected!r} s, got {got!r} s: it was reset"

    def active(self) -> frozenset[str]:
        """What acts, from the compiled model, the data and the process."""
        return acting(self._model, self._data, self._scenario)

    def close(self) -> None:
        """Drop model and data; MuJoCo frees them with the last reference."""
        del self._model, self._data, self._qpos, self._qvel, self._counts

    def _reading(self) -> Snapshot:
        return self._steps, self._data.time, self._qpos.tobytes(), self._qvel.tobytes()

    def _is_reset(self, steps: Any, times: Any) -> Any:
        """Whether a clock, which is a running sum, is off by half a step or more."""
        timestep = self._model.opt.timestep
        return ~(np.abs(times - steps * timestep) < timestep / 2)


def compiled(build: Callable[[], Any]) -> Any:
    """The model that `build` compiles.

    Raises
    ------
    EngineError
        With the compiler's message, where it refuses or warns.
    """
    heard: list[str] = []
    # An editable model's warnings come as Python's own.
    with _hearing(heard), warnings.catch_warnings(record=True) as recorded:
        warnings.simplefilter("always")
        try:
            model = build()
        except ValueError as error:
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
