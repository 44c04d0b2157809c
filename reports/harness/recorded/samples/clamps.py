"""Clamps, by which an engine limits ω: their effect on states, and those that explain a motion."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .....reference.following import follow
from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import matrices, norms, rotation_vectors, turned, turned_back
from ...explaining.search import LEFT
from .intervals import states_of

#: Largest relative error of ω with a clamp that explains a motion; least number of samples at its
#: bound; the most intervals in which clamps are tried.
CLAMPED, FEWEST, FEW = 1e-2, 3, 12
#: Relative error of a bound by rounding. How far equations must lead beyond a bound, relatively.
ROUNDING, BEYOND = 1e-9, 1e-3
#: Largest median error of attitudes beside a clamp, relative to their turn from sample to sample.
FOLLOWED = 0.2
#: Smallest rate, rad/s, and smallest sum of squares, that is used as a divisor.
TINY = 1e-300


def _in_world(states: FloatArray) -> FloatArray:
    """Return ω of S states, q and ω in body axes, (S, 7), along world axes, rad/s, (S, 3)."""
    return turned(matrices(states[:, :4]), states[:, 4:])


def _with_omega(states: FloatArray, omega_body: FloatArray) -> FloatArray:
    """Return S states, (S, 7), with their ω replaced by `omega_body`, rad/s, (S, 3)."""
    return np.hstack([states[:, :4], omega_body])


def _by_component(states: FloatArray, bound: float) -> FloatArray:
    """Return S states, (S, 7), with each body-axis component of ω clamped to ± a bound, rad/s."""
    return _with_omega(states, np.clip(states[:, 4:], -bound, bound))


def _by_component_in_world(states: FloatArray, bound: float) -> FloatArray:
    """Return S states, (S, 7), with each world-axis component of ω clamped to ± a bound, rad/s.

    As in all states, the ω that is returned is along body axes.
    """
    clamped = np.clip(_in_world(states), -bound, bound)
    return _with_omega(states, turned_back(matrices(states[:, :4]), clamped))


def _by_norm(states: FloatArray, bound: float) -> FloatArray:
    """Return S states, (S, 7), with the norm of ω clamped to a bound, rad/s."""
    speeds = np.maximum(norms(states[:, 4:]), TINY)[:, None]
    return _with_omega(states, states[:, 4:] * np.minimum(1.0, bound / speeds))


#: Clamps. Each has words for the quantity that it bounds, a function that returns this quantity for
#: states, (S, 7), and one that returns states in which it is clamped to a bound, rad/s.
CLAMPS = (
    ("each component of ω in world axes", lambda s: np.abs(_in_world(s)), _by_component_in_world),
    ("each component of ω in body axes", lambda s: np.abs(s[:, 4:]), _by_component),
    ("‖ω‖", lambda s: norms(s[:, 4:]), _by_norm),
)


class Clamp(NamedTuple):
    """A clamp of ω: a sentence on it, and the index of the first sample at its bound."""

    words: str
    first: int


def clamps(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, of_method: float, of_noise: float
) -> Iterator[Clamp]:
    """Yield clamps of ω with which the scene's equations lead from sample to sample.

    The first sample is replaced by the exact one. Whatever else is wrong with the motion, a clamp
    is also found if ω stays at a bound, up to rounding, while the scene's equations lead beyond it.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the same times
    of_method : bound on a method's error of ω in an interval, rad/s
    of_noise : bound on the noise of ω, rad/s
    """
    states = states_of(motion)
    start = states_of(exact.until(1))[0]
    changes = float(np.abs(states[:, 4:] - start[4:]).max())
    # A constant ω is no sign of a clamp: without a gyroscopic torque it is constant, too.
    if len(states) <= FEWEST or changes <= ROUNDING * np.abs(states[:, 4:]).max():
        return
    kept = np.unique(np.linspace(0, len(states) - 2, FEW).astype(int))
    spans, starts, ends = np.diff(motion.t)[kept, None], states[kept], states[kept + 1]
    # The first sample may be recorded before or after it was clamped.
    starts[0] = start
    equations = equations_of(scenario)
    unclamped = follow(equations, starts, spans)[:, 0]
    turns = norms(rotation_vectors(starts[:, :4], ends[:, :4]))
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
        # An ω that was recorded too small is no clamp: attitudes turn faster.
        off = norms(rotation_vectors(clamped[:, :4], ends[:, :4]))
        is_followed = np.median(off) <= FOLLOWED * np.median(turns)
        if is_followed and _fits(ends[:, 4:], clamped[:, 4:], unclamped[:, 4:], least):
            yield Clamp(f"{words} is clamped to {bound:.4g} rad/s", first)


def _fits(omega: FloatArray, clamped: FloatArray, unclamped: FloatArray, least: float) -> bool:
    """Return whether the recorded ω equals that with a clamp, and differs from that without it.

    Parameters
    ----------
    omega : recorded ω at the ends of S intervals, rad/s, (S, 3)
    clamped, unclamped : ω computed with and without the clamp, rad/s, (S, 3)
    least : how far clamped and unclamped ω must differ, rad/s; a difference of more than `CLAMPED`
        times the largest ‖ω‖ is enough in any case
    """
    size = float(norms(unclamped).max())
    deviation, changed = (float(norms(one - clamped).max()) for one in (omega, unclamped))
    is_changed = changed > min(least, CLAMPED * size)
    return bool(clamped.any()) and deviation <= min(CLAMPED * size, LEFT * changed) and is_changed
