"""The ladder of halved timesteps at which a method is run, chosen from the motion alone."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray, Window

#: Angle turned in the coarsest step, rad: a timestep that resolves the motion at all.
COARSEST_TURN = 0.2
#: Above the ladder timesteps are doubled up to this angle, rad: half a turn, beyond which samples
#: cannot tell a rotation from its opposite.
LARGEST_TURN = math.pi
#: Fewest steps of a run above the ladder: in fewer steps, an instability has no time to grow.
LEAST_STEPS = 10
#: A ladder ends before a run would take more steps than this.
MAX_STEPS = 1 << 20
#: A quick study's ladders end before a run would take more steps than this.
QUICK_STEPS = 1 << 14
#: A ladder also ends before a run would take more steps than this, once it shows how errors
#: decrease: the errors at finer timesteps follow from the order.
DECIDED_STEPS = 1 << 12
#: A ladder is not ended early before it has this many rungs.
MIN_RUNGS = 6
#: Number of the first rungs, which show an order, and factor by which the number of their steps may
#: exceed the limit.
LEAST_RUNGS = 3
EXCESS = 4
#: Largest step count: beyond it a step's number is no longer exact as a double.
MOST_STEPS = 2.0**53


@dataclass(frozen=True, eq=False)
class Rung:
    """One timestep of a ladder.

    Attributes
    ----------
    timestep : s
    sample_steps : number of steps before each sample, the first of them 0, (n,)
    every : m, if this rung is sampled at every m-th sample of its ladder
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
        """The times of the samples, s, (n,)."""
        return np.asarray(self.sample_steps * self.timestep, dtype=float)

    def until(self, samples: int) -> "Rung":
        """Return the rung, sampled only at the first `samples` sample times of its ladder."""
        return replace(self, sample_steps=self.sample_steps[: math.ceil(samples / self.every)])


@dataclass(frozen=True, eq=False)
class Ladder:
    """The timesteps that fit a scene's motion; their ratios are powers of two.

    Attributes
    ----------
    rungs : coarse to fine, all sampled at the same times; empty if the first would take too many
        steps, or there are no sample times
    above : coarser timesteps, each twice the one before, from twice the first rung's on. They show
        the largest stable timestep, and take no part in a verdict
    times : the times at which all rungs are sampled, s, (n,)
    least_steps : number of steps of the first rung, even if the ladder is empty
    """

    rungs: tuple[Rung, ...]
    above: tuple[Rung, ...]
    times: FloatArray
    least_steps: float

    def until(self, samples: int) -> "Ladder":
        """Return the ladder with the first samples only, at which the exact motion is known.

        With fewer than two samples it has no rungs. Rungs above it that would have no step are left
        out.
        """
        if samples < 2:
            return Ladder((), (), self.times[:samples], least_steps=0.0)
        parts = (self.rungs, self.above)
        rungs, above = (tuple(rung.until(samples) for rung in part) for part in parts)
        above = tuple(rung for rung in above if rung.steps)
        return Ladder(rungs, above, self.times[:samples], self.least_steps)


def ladder(window: Window, fastest_rate: float, samples: int, max_steps: int = MAX_STEPS) -> Ladder:
    """Choose timesteps for a motion, each half of the one before.

    A step with the coarsest timestep turns the body by at most `COARSEST_TURN` where it is fastest,
    and a whole number of these steps fits between two samples. Halving is exact in binary, so that
    all rungs share their sample times to the last bit. If samples are so close that even a ladder
    that begins with one step between them has too few rungs, only every second, fourth, … sample is
    used.

    Parameters
    ----------
    fastest_rate : the fastest rate, rad/s
    samples : number of samples of the window at which the exact motion is known
    max_steps : a ladder of `LEAST_RUNGS` rungs or more ends before a run would take more steps, a
        shorter ladder before a run would take more than `EXCESS` times as many
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
    """Return m, the power of two such that every m-th sample is used; 1 if all are.

    It is the smallest m with which `MIN_RUNGS` rungs, the first with one step between used samples,
    stay within `MAX_STEPS`. Doubling stops earlier if the turn between two used samples would
    exceed `COARSEST_TURN`.

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

    They end before a step turns the body by more than `LARGEST_TURN`, or a run has fewer than
    `LEAST_STEPS` steps. Each is sampled at every m-th sample of the ladder, with the least m for
    which samples are whole steps apart.

    Parameters
    ----------
    coarsest : the ladder's coarsest timestep, s
    counts : number of steps of that timestep before each sample, (n,)
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
    """Return a rung with a given timestep, s, sampled at the whole steps nearest to `times`, s.

    Raises
    ------
    ValueError
        If the last time is at most half a step, or takes more steps than can be counted.
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
