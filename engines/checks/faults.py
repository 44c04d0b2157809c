"""Checks of the states of a run that apply to any engine and scene."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...scenarios import FloatArray, Trajectory
from ...scenarios.rotation import matrices, norms
from ..fault import Fault
from .read_back import State


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds that every state of a run must keep.

    Attributes
    ----------
    timestep : length of a step, s
    most_turn : the largest rotation in a step, rad, that the engine does not clamp
    arm : vector from the pivot to the com, m, body axes, (3,); None if there is no pivot, or if the
        com is at the pivot
    """

    timestep: float
    most_turn: float
    arm: FloatArray | None = None


def faults(states: State, bounds: Bounds) -> Iterator[Fault]:
    """Yield the first fault of each kind in n states, with the index of the state.

    The kinds are the causes "not-finite", "not-unit", "clamp" and "pivot". `bounds` has the numbers
    of the scene and method that the last two are judged by.
    """
    timestep = bounds.timestep
    # A quick test first: the sum is not finite if any component is not.
    if not np.isfinite(sum(float(column.sum()) for column in states.columns)):
        finite = np.hstack([np.isfinite(column) for column in states.columns])
        if not finite.all():
            yield Fault(_first(~finite.all(axis=1)), "not-finite", "the state is no longer finite")
    sizes = norms(states.q_world_body_wxyz)
    not_unit = np.abs(sizes - 1) > Trajectory.UNIT_NORM_SLACK
    if not_unit.any():
        norm = sizes[_first(not_unit)]
        yield Fault(
            _first(not_unit), "not-unit", f"the attitude's quaternion is of norm {norm:.3g}"
        )
    speeds = norms(states.omega_body)
    clamped = speeds * timestep > bounds.most_turn
    if clamped.any():
        speed = float(speeds[_first(clamped)])
        yield Fault(_first(clamped), "clamp", clamped_turn(speed, timestep, bounds.most_turn))
    if bounds.arm is not None:
        yield from _pivot_faults(states, bounds.arm)


def clamped_turn(speed: float, timestep: float, most: float) -> str:
    """Return a message if a body turns further in a step than the engine allows; else empty.

    Parameters
    ----------
    speed : the body's angular speed, rad/s
    timestep : length of a step, s
    most : the largest rotation in a step, rad, that the engine does not clamp
    """
    if speed * timestep <= most:
        return ""
    return (
        f"the rotation a step, {np.degrees(speed * timestep):.3g}°, is beyond "
        f"{np.degrees(most):.3g}°, where the engine clamps it"
    )


def _pivot_faults(states: State, arm_body: FloatArray) -> Iterator[Fault]:
    """Yield a fault for the first state in which the body's pivot has left the world's origin.

    The pivot has left if it is further from the origin than from the com. `arm_body`
    is the vector from the pivot to the com, m, body axes, (3,).
    """
    drift = norms(states.com_world - matrices(states.q_world_body_wxyz) @ arm_body)
    has_given_way = drift > np.linalg.norm(arm_body)
    if arm_body.any() and has_given_way.any():
        first = _first(has_given_way)
        yield Fault(first, "pivot", f"the pivot gave way by {drift[first]:.3g} m")


def _first(bad: Any) -> int:
    """Return the index of the first true entry of a boolean array, which must have one."""
    return int(np.argmax(bad))
