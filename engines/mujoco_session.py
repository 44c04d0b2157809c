"""A compiled MuJoCo model, stepped and read: shared by the MJCF and the URDF adapter."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, final

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray
from .engine import Session
from .mujoco_audit import acting
from .read_back import BodyReading, EngineError, State

#: Of a free joint's qpos and qvel, the leading numbers that are the origin's position and velocity.
TRANSLATION = 3


@final
class MuJoCoSession(Session):
    """One body on a ball joint at its origin, or free; the last body of the model.

    Parameters
    ----------
    model : compiled, options and effects set
    qpos, qvel : the start, as `mjcf.start_coordinates` gives it
    """

    def __init__(self, model: Any, qpos: Sequence[float], qvel: Sequence[float]) -> None:
        self._model = model
        self._data = mujoco.MjData(model)
        self._data.qpos[:] = qpos
        self._data.qvel[:] = qvel
        self._body = model.nbody - 1
        self._com_body = model.body_ipos[self._body].copy()
        self._counts = self._data.warning.number
        self._is_free = model.nv > TRANSLATION
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
        """From qpos and qvel alone: derived data (xipos, cvel) is one step old after a step.

        The com is the body's origin plus the compiled arm, its velocity that of the origin plus
        ω × arm; a ball joint's origin stands still.
        """
        qpos, qvel = self._data.qpos, self._data.qvel
        q_world_body_wxyz, omega_body = qpos[-4:].copy(), qvel[-3:].copy()
        com_world, velocity_world, velocity_body = np.empty(3), np.empty(3), np.empty(3)
        # A state is read hundreds of times a run: scipy's rotations take twenty times as long.
        mujoco.mju_cross(velocity_body, omega_body, self._com_body)
        mujoco.mju_rotVecQuat(com_world, self._com_body, q_world_body_wxyz)
        mujoco.mju_rotVecQuat(velocity_world, velocity_body, q_world_body_wxyz)
        if self._is_free:
            com_world += qpos[:TRANSLATION]
            velocity_world += qvel[:TRANSLATION]
        return State(q_world_body_wxyz, omega_body, com_world, velocity_world)

    def advance(self, steps: int) -> None:
        """One native loop."""
        with _hearing(self._warnings):
            try:
                mujoco.mj_step(self._model, self._data, nstep=steps)
            except mujoco.FatalError as error:
                raise EngineError(f"MuJoCo stopped: {error}") from None
        self._steps += steps

    def check(self) -> None:
        """Any warning, or a clock that is not at the steps taken, is an error."""
        if self._warnings:
            raise EngineError(f"MuJoCo warned: {self._warnings[0]}")
        if self._counts.any():
            raise EngineError(f"MuJoCo counted {np.count_nonzero(self._counts)} kinds of warning")
        timestep = self._model.opt.timestep
        expected = self._steps * timestep
        # MuJoCo's clock is a running sum: right to far less than half a step.
        if not abs(self._data.time - expected) < timestep / 2:
            raise EngineError(
                f"MuJoCo's clock must be at {expected!r} s, got {self._data.time!r} s: it was reset"
            )

    def active(self) -> frozenset[str]:
        """What acts, from the compiled model and a fresh evaluation of its forces."""
        return acting(self._model, self._data)

    def close(self) -> None:
        """Drop model and data; MuJoCo frees them with the last reference."""
        del self._model, self._data, self._counts


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
