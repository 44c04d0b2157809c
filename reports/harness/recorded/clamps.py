"""Clamps of ω: what they bound, what they leave of it, and which of them made a motion."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....reference.following import follow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import matrices, norms, turned, turned_back
from ..explaining.hypothesis import as_it_is
from ..explaining.search import LEFT
from .intervals import states_of

#: Relative tolerance of the fit of a clamp, and least number of samples; and number of intervals
#: that clamps are tried on, at most.
CLAMPED, FEWEST, FEW = 1e-2, 3, 12
#: Relative error of a bound by rounding, and how far beyond it equations lead that must be bound.
ROUNDING, BEYOND = 1e-9, 1e-3
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


class Clamp(NamedTuple):
    """A clamp of ω in words, and the first sample at its bound."""

    words: str
    first: int


def clamps(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, of_method: float, of_noise: float
) -> Iterator[Clamp]:
    """Yield clamps of ω that lead from the exact start, and each sample, to the next.

    Or ω stays at the bound, to rounding, where the scene's equations lead beyond it, whatever else
    is wrong.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the same times
    of_method, of_noise : bounds of a method's error of ω in an interval, and of noise, rad/s
    """
    states = states_of(motion)
    start = states_of(exact.until(1))[0]
    changes = float(np.abs(states[:, 4:] - start[4:]).max())
    # An ω that stays what it was at first is no clamp's: so it is without a gyroscopic torque.
    if len(states) <= FEWEST or changes <= ROUNDING * np.abs(states[:, 4:]).max():
        return
    kept = np.unique(np.linspace(0, len(states) - 2, FEW).astype(int))
    spans, starts, ends = np.diff(motion.t)[kept, None], states[kept], states[kept + 1]
    # The first sample may be recorded before or after it was clamped.
    starts[0] = start
    equations = as_it_is(scenario).equations
    wanted = follow(equations, starts, spans)[:, 0]
    every = follow(equations, states[:-1], np.diff(motion.t)[:, None])[:, 0]
    for words, size_of, limited in CLAMPS:
        bound = float(size_of(states).max())
        is_there = size_of(states) > (1 - ROUNDING) * bound
        first = int(np.argmax(is_there.reshape(len(states), -1).any(axis=1)))
        # What stays the same throughout may be the motion's own.
        is_there &= ~is_there.all(axis=0)
        is_beyond = size_of(every) > bound + max(BEYOND * bound, of_noise)
        stays = is_there[:-1] & is_there[1:] & is_beyond
        if np.count_nonzero(stays) >= FEWEST:
            yield Clamp(f"{words} is clamped to {bound:.4g} rad/s", first)
            continue
        bound = float(size_of(ends).max())
        clamped = limited(follow(equations, limited(starts, bound), spans)[:, 0], bound)
        is_reached = bool(size_of(states).min() < (1 - CLAMPED) * bound)
        least = of_method / LEFT if is_reached else np.inf
        if _fits(ends[:, 4:], clamped[:, 4:], wanted[:, 4:], least):
            yield Clamp(f"{words} is clamped to {bound:.4g} rad/s", first)


def _fits(omega: FloatArray, clamped: FloatArray, wanted: FloatArray, least: float) -> bool:
    """Whether ω is what a clamp makes of the correct ω, and differs from the correct one.

    Parameters
    ----------
    least : change of ω, rad/s, by which it differs; a part of ω is enough, too
    """
    size = float(norms(wanted).max())
    off, changed = (float(norms(one - clamped).max()) for one in (omega, wanted))
    is_changed = changed > min(least, CLAMPED * size)
    return bool(clamped.any()) and off <= min(CLAMPED * size, LEFT * changed) and is_changed
