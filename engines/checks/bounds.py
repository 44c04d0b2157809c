"""Bounds that the states of a run must keep."""

from dataclasses import dataclass

from ...scenarios import FloatArray


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds that every state must keep.

    Attributes
    ----------
    timestep : s
    most_turn : rad a step, beyond which the engine clamps the rotation
    round_off : relative, of a state that is read; of an attitude, rad
    decay : 1/s, the fastest rate at which effects and the engine's own damping slow the body, and
        its parts turn ω
    arm : m, body axes, from the pivot to the com, (3,); None where nothing holds the body
    by_angles : whether the attitude is stepped as roll, pitch and yaw
    """

    timestep: float
    most_turn: float
    round_off: float
    decay: float = 0.0
    arm: FloatArray | None = None
    by_angles: bool = False
