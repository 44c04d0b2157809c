"""Clamps of ω: which quantity each bounds, how it changes ω, and which of them explain a motion."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .....reference.following import follow
from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import matrices, norms, turned, turned_back
from ...explaining.search import LEFT
from .intervals import states_of

#: Relative tolerance of the fit of a clamp, and least number of samples; and the most intervals
#: that clamps are tried in.
CLAMPED, FEWEST, FEW = 1e-2, 3, 12
#: Relative error of a bound by rounding, and how far beyond a bound, relative, equations must lead.
ROUNDING, BEYOND = 1e-9, 1e-3
#: Smallest rate, rad/s, and smallest sum of squares, that is used as a divisor.
TINY = 1e-300


def _in_world(states: FloatArray) -> FloatArray:
    """Return ω of states q and ω, (S, 7), along world axes, rad/s, (S, 3)."""
    return turned(matrices(states[:, :4]), states[:, 4:])


def _with_omega(states: FloatArray, omega_body: FloatArray) -> FloatArray:
    """Return states with another ω, rad/s, body axes, (S, 7)."""
    return np.hstack([states[:, :4], omega_body])


def _by_component(states: FloatArray, bound: float) -> FloatArray:
    """Return states with each component of ω in body axes clamped to ± a bound, rad/s, (S, 7)."""
    return _with_omega(states, np.clip(states[:, 4:], -bound, bound))


def _by_component_in_world(states: FloatArray, bound: float) -> FloatArray:
    """Return states with each component of ω in world axes clamped to ± a bound, rad/s, (S, 7).

    As in all states, the ω that is returned is in body axes.
    """
    clamped = np.clip(_in_world(states), -bound, bound)
    return _with_omega(states, turned_back(matrices(states[:, :4]), clamped))


def _by_norm(states: FloatArray, bound: float) -> FloatArray:
    """Return states with the norm of ω clamped to a bound, rad/s, (S, 7)."""
    speeds = np.maximum(norms(states[:, 4:]), TINY)[:, None]
    return _with_omega(states, states[:, 4:] * np.minimum(1.0, bound / speeds))


#: Clamps: the words, the bounded quantity of states, (S, 7), and the states with it clamped.
CLAMPS = (
    ("each component of ω in world axes", lambda s: np.abs(_in_world(s)), _by_component_in_world),
    ("each component of ω in body axes", lambda s: np.abs(s[:, 4:]), _by_component),
    ("‖ω‖", lambda s: norms(s[:, 4:]), _by_norm),
)


class Clamp(NamedTuple):
    """A clamp of ω in words, and the index of the first sample at its bound."""

    words: str
    first: int


def clamps(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, of_method: float, of_noise: float
) -> Iterator[Clamp]:
    """Yield clamps of ω with which the scene's equations lead from sample to sample.

    The first sample is replaced by the exact start. A clamp is also found, whatever else is wrong,
    if ω stays at a bound up to rounding where the scene's equations lead beyond this bound.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the same times
    of_method, of_noise : bounds of a method's error of ω in an interval, and of noise, rad/s
    """
    states = states_of(motion)
    start = states_of(exact.until(1))[0]
    changes = float(np.abs(states[:, 4:] - start[4:]).max())
    # An ω that stays constant is no sign of a clamp: without a gyroscopic torque it does so, too.
    if len(states) <= FEWEST or changes <= ROUNDING * np.abs(states[:, 4:]).max():
        return
    kept = np.unique(np.linspace(0, len(states) - 2, FEW).astype(int))
    spans, starts, ends = np.diff(motion.t)[kept, None], states[kept], states[kept + 1]
    # The first sample may be recorded before or after it was clamped.
    starts[0] = start
    equations = equations_of(scenario)
    unclamped = follow(equations, starts, spans)[:, 0]
    every = follow(equations, states[:-1], np.diff(motion.t)[:, None])[:, 0]
    for words, size_of, apply in CLAMPS:
        bound = float(size_of(states).max())
        is_at_bound = size_of(states) > (1 - ROUNDING) * bound
        first = int(np.argmax(is_at_bound.reshape(len(states), -1).any(axis=1)))
        # A component that is constant throughout may be the motion's own.
        is_at_bound &= ~is_at_bound.all(axis=0)
        is_beyond = size_of(every) > bound + max(BEYOND * bound, of_noise)
        stays = is_at_bound[:-1] & is_at_bound[1:] & is_beyond
        if np.count_nonzero(stays) >= FEWEST:
            yield Clamp(f"{words} is clamped to {bound:.4g} rad/s", first)
            continue
        bound = float(size_of(ends).max())
        clamped = apply(follow(equations, apply(starts, bound), spans)[:, 0], bound)
        is_reached = bool(size_of(states).min() < (1 - CLAMPED) * bound)
        least = of_method / LEFT if is_reached else np.inf
        if _fits(ends[:, 4:], clamped[:, 4:], unclamped[:, 4:], least):
            yield Clamp(f"{words} is clamped to {bound:.4g} rad/s", first)


def _fits(omega: FloatArray, clamped: FloatArray, unclamped: FloatArray, least: float) -> bool:
    """Whether the recorded ω is the clamped one, which differs from the unclamped one.

    Parameters
    ----------
    omega, clamped, unclamped : recorded and computed ω at the ends of intervals, rad/s, (S, 3)
    least : how far clamped and unclamped ω must differ, rad/s, but at most `CLAMPED` of the
        largest ‖ω‖
    """
    size = float(norms(unclamped).max())
    deviation, changed = (float(norms(one - clamped).max()) for one in (omega, unclamped))
    is_changed = changed > min(least, CLAMPED * size)
    return bool(clamped.any()) and deviation <= min(CLAMPED * size, LEFT * changed) and is_changed
