"""The ladder of halved timesteps at which a method is run, chosen from the motion alone."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray, Window

#: Largest angle that a step with a ladder's coarsest timestep turns the body by, rad: even this
#: timestep resolves the motion.
COARSEST_TURN = 0.2
#: Largest angle that a step turns the body by above the ladder, rad: half a turn, beyond which a
#: rotation cannot be told from one in the opposite direction.
LARGEST_TURN = math.pi
#: Fewest steps of a run above the ladder: in fewer steps, an instability has no time to grow.
LEAST_STEPS = 10
#: A ladder ends before a run would take more steps than this.
MAX_STEPS = 1 << 20
#: A quick study's ladders end before a run would take more steps than this.
QUICK_STEPS = 1 << 14
#: Largest number of steps of a run beyond the first `LEAST_RUNGS` rungs: by then a ladder shows how
#: errors decrease, and the errors at finer timesteps follow from the order.
DECIDED_STEPS = 1 << 12
#: Least number of rungs before a ladder may end because of the size of its errors.
MIN_RUNGS = 6
#: Number of the first rungs, which are needed to show an order, and the factor by which their runs
#: may exceed a limit on the number of steps.
LEAST_RUNGS = 3
EXCESS = 4
#: Largest number of steps of a run: a larger integer may not be exact as a double.
MOST_STEPS = 2.0**53


@dataclass(frozen=True, eq=False)
class Rung:
    """A timestep of a run, with the steps at which the run is sampled.

    Attributes
    ----------
    timestep : s
    sample_steps : number of steps before each sample, the first of them 0, (n,)
    every : m, if this rung is sampled only at every m-th sample time of its ladder; else 1
    """

    timestep: float
    sample_steps: NDArray[np.int64]
    every: int = 1

    @property
    def steps(self) -> int:
        """Number of steps to the last sample."""
        return int(self.sample_steps[-1])

    @property
    def times(self) -> FloatArray:
        """The times of the n samples, s, (n,)."""
        return np.asarray(self.sample_steps * self.timestep, dtype=float)

    def until(self, samples: int) -> "Rung":
        """Return a copy that is sampled only at the first `samples` sample times of its ladder."""
        return replace(self, sample_steps=self.sample_steps[: math.ceil(samples / self.every)])


@dataclass(frozen=True, eq=False)
class Ladder:
    """The timesteps that fit a scene's motion; their ratios are powers of two.

    Attributes
    ----------
    rungs : coarse to fine, all sampled at the same times; empty if even the coarsest would take too
        many steps, or if there are fewer than two sample times
    above : timesteps coarser than all rungs, each twice the one before; the first is twice the
        coarsest rung's. They show the largest stable timestep, and take no part in a verdict
    times : the times at which all rungs are sampled, s, (n,)
    least_steps : number of steps of a run at the coarsest rung, even if that has too many to be run
    """

    rungs: tuple[Rung, ...]
    above: tuple[Rung, ...]
    times: FloatArray
    least_steps: float

    def until(self, samples: int) -> "Ladder":
        """Return a copy that is sampled only at the first `samples` sample times.

        If these are fewer than two, the copy has no rungs. Timesteps above the ladder that would
        have no step are left out.
        """
        if samples < 2:
            return Ladder((), (), self.times[:samples], least_steps=0.0)
        parts = (self.rungs, self.above)
        rungs, above = (tuple(rung.until(samples) for rung in part) for part in parts)
        above = tuple(rung for rung in above if rung.steps)
        return Ladder(rungs, above, self.times[:samples], self.least_steps)


def ladder(window: Window, fastest_rate: float, samples: int, max_steps: int = MAX_STEPS) -> Ladder:
    """Return a ladder of timesteps for a motion, each half of the one before.

    A step with the coarsest timestep turns the body by at most `COARSEST_TURN` where it is fastest,
    and a whole number of these steps fits between two samples. Halving is exact in binary, so that
    all rungs share their sample times to the last bit. If the samples are so many that a ladder
    with at least one step between samples would have fewer than `MIN_RUNGS` rungs, only every
    second, fourth, … sample is used.

    Parameters
    ----------
    window : the scene's duration and number of samples
    fastest_rate : the fastest rate of the motion, rad/s
    samples : number of samples of the window at which the exact motion is known
    max_steps : largest number of steps of a run; the first `LEAST_RUNGS` rungs may take up to
        `EXCESS` times as many
    """
    interval = window.duration / (window.samples - 1)
    per_interval = max(1.0, float(np.ceil(interval * fastest_rate / COARSEST_TURN)))
    thinned = _thinned(samples - 1, interval * fastest_rate)
    intervals, interval = (samples - 1) // thinned, interval * thinned
    least_steps = intervals * per_interval
    if not 0 < least_steps < MAX_STEPS * LARGEST_TURN / COARSEST_TURN:
        return Ladder((), (), interval * np.arange(intervals + 1.0), least_steps)
    counts = np.arange(intervals + 1, dtype=np.int64) * int(per_interval)
    coarsest = interval / per_interval
    rungs = []
    for k in count():
        limit = min(EXCESS * max_steps, MAX_STEPS) if k < LEAST_RUNGS else max_steps
        if least_steps * 2**k > limit:
            break
        rungs.append(Rung(coarsest / 2**k, counts * 2**k))
    above = tuple(_above(coarsest, counts, fastest_rate))
    times = np.asarray(counts * coarsest, dtype=float)
    return Ladder(tuple(rungs), above, times, least_steps)


def _thinned(intervals: int, turn: float) -> int:
    """Return the power of two m for which a ladder is sampled at every m-th sample of the window.

    It is the smallest m for which a ladder that begins with one step between used samples has
    `MIN_RUNGS` rungs of at most `MAX_STEPS` steps. If with this m the body would turn by more than
    `COARSEST_TURN` between two used samples, the largest smaller m with which it does not is
    returned, but at least 1.

    Parameters
    ----------
    intervals : number of intervals between samples
    turn : largest turn between two neighbouring samples, rad
    """
    every = 1
    while (
        intervals // every * 2 ** (MIN_RUNGS - 1) > MAX_STEPS and 2 * every * turn <= COARSEST_TURN
    ):
        every *= 2
    return every


def _above(coarsest: float, counts: NDArray[np.int64], fastest_rate: float) -> Iterator[Rung]:
    """Yield rungs with 2, 4, 8, … times the coarsest timestep of a ladder.

    The last is the longest whose steps turn the body by at most `LARGEST_TURN` and whose run has at
    least `LEAST_STEPS` steps. Runs of more than `MAX_STEPS` steps are left out. Each rung is
    sampled at every m-th sample of the ladder, with the least m for which a whole number of steps
    fits between these samples.

    Parameters
    ----------
    coarsest : the ladder's coarsest timestep, s
    counts : number of steps of that timestep before each of n samples, (n,)
    fastest_rate : the fastest rate of the motion, rad/s
    """
    per_interval = int(counts[1])
    for k in count(1):
        timestep = coarsest * 2**k
        every = 2**k // math.gcd(per_interval, 2**k)
        if timestep * fastest_rate > LARGEST_TURN or every >= len(counts):
            return
        rung = Rung(timestep, counts[::every] >> k, every)
        if rung.steps < LEAST_STEPS:
            return
        if rung.steps <= MAX_STEPS:
            yield rung


def single(timestep: float, times: NDArray[np.float64]) -> Rung:
    """Return a rung with a given timestep.

    Parameters
    ----------
    timestep : s
    times : n times at which samples are wanted, s, (n,); the rung is sampled at the nearest whole
        numbers of steps, each only once

    Raises
    ------
    ValueError
        If the last time is at most half a step, or `MOST_STEPS` steps or more.
    """
    if not times[-1] / timestep < MOST_STEPS:
        raise ValueError(
            f"'timestep' must be longer, got {timestep:g} s: {times[-1]:g} s take more steps than "
            f"the {MOST_STEPS:.1e} that can be counted."
        )
    steps = np.unique(np.rint(times / timestep).astype(np.int64))
    if len(steps) < 2:
        raise ValueError(
            f"'timestep' must be shorter than the window, got {timestep:g} s and {times[-1]:g} s."
        )
    return Rung(timestep, steps)
