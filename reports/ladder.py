"""The ladder of halved timesteps a method is run down, chosen from the motion alone."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..scenarios import Trajectory

#: Angle turned in the coarsest step, rad. A user who thinks of the motion would not step further.
COARSEST_TURN = 0.2
#: A ladder ends before a run would take more steps than this.
MAX_STEPS = 1 << 20
#: Fewer rungs than this show no trend.
MIN_RUNGS = 6


@dataclass(frozen=True, eq=False)
class Rung:
    """One timestep of a ladder.

    Attributes
    ----------
    timestep : s
    sample_steps : (n,) step counts of the samples, the first of them 0
    """

    timestep: float
    sample_steps: NDArray[np.int64]

    @property
    def steps(self) -> int:
        """Steps to the last sample."""
        return int(self.sample_steps[-1])


def ladder(truth: Trajectory, max_steps: int = MAX_STEPS) -> list[Rung]:
    """Rungs from coarse to fine, every one sampled at the times of the first.

    The coarsest step turns the body by at most `COARSEST_TURN` where it spins fastest, and fits a
    whole number of times between two samples. Halving is exact in binary, so that all rungs share
    their sample times to the last bit.

    Parameters
    ----------
    truth : the motion at the window's evenly spaced times
    """
    interval = float(truth.t[-1]) / (len(truth.t) - 1)
    fastest = float(np.linalg.norm(truth.omega_body, axis=1).max())
    per_interval = max(1, math.ceil(interval * fastest / COARSEST_TURN))
    coarsest = interval / per_interval
    counts = np.arange(len(truth.t), dtype=np.int64) * per_interval
    rungs = [Rung(coarsest / 2**k, counts * 2**k) for k in range(MIN_RUNGS)]
    while 2 * rungs[-1].steps <= max_steps:
        rungs.append(Rung(rungs[-1].timestep / 2, rungs[-1].sample_steps * 2))
    return rungs


def single(timestep: float, times: NDArray[np.float64]) -> Rung:
    """A rung with a timestep somebody asked for: samples at the whole steps nearest to `times`.

    Raises
    ------
    ValueError
        If the window is shorter than one step.
    """
    steps = np.unique(np.rint(times / timestep).astype(np.int64))
    if len(steps) < 2:
        raise ValueError(
            f"'timestep' must be shorter than the window, got {timestep:g} s and {times[-1]:g} s."
        )
    return Rung(timestep, steps)
