"""Clamps of ω: what they bound, and what they leave of it."""

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.rotation import matrices, norms, turned, turned_back

#: Slowest turn of a body, rad/s.
TINY = 1e-300


def _in_world(states: FloatArray) -> FloatArray:
    """Return ω along world axes, rad/s, (S, 3)."""
    return turned(matrices(states[:, :4]), states[:, 4:])


def _with_omega(states: FloatArray, omega_body: FloatArray) -> FloatArray:
    return np.hstack([states[:, :4], omega_body])


def _by_component(states: FloatArray, bound: float) -> FloatArray:
    return _with_omega(states, np.clip(states[:, 4:], -bound, bound))


def _by_component_in_world(states: FloatArray, bound: float) -> FloatArray:
    clamped = np.clip(_in_world(states), -bound, bound)
    return _with_omega(states, turned_back(matrices(states[:, :4]), clamped))


def _by_norm(states: FloatArray, bound: float) -> FloatArray:
    speeds = np.maximum(norms(states[:, 4:]), TINY)[:, None]
    return _with_omega(states, states[:, 4:] * np.minimum(1.0, bound / speeds))


#: Clamps: in words, the size of states (S, 7) that is bounded, and the states with it clamped.
CLAMPS = (
    ("each component of ω in world axes", lambda s: np.abs(_in_world(s)), _by_component_in_world),
    ("each component of ω in body axes", lambda s: np.abs(s[:, 4:]), _by_component),
    ("‖ω‖", lambda s: norms(s[:, 4:]), _by_norm),
)
