"""Runs at the timesteps people use: the one an engine's users get unasked, and one for all engines.

They are made and stored besides a method's ladder, and take no part in its verdict.
"""

import math
from dataclasses import dataclass

import numpy as np

from ...engines import Engine
from ...reference import Solution, solve
from ...scenarios import Scenario
from .ladder import LARGEST_TURN, LEAST_STEPS, Rung, single

#: s; every engine is run at it besides its own, so that they can be compared at one timestep.
COMMON_TIMESTEP = 1e-3
#: A run of more steps is not made: a second of MuJoCo's, a few of PyBullet's.
STEP_BUDGET = 1 << 17


@dataclass(frozen=True, eq=False)
class StockRun:
    """A scene at one such timestep.

    Attributes
    ----------
    rung, solution : None where a run makes no sense
    refusal : why it does not, with the numbers; else empty
    """

    timestep: float
    rung: Rung | None = None
    solution: Solution | None = None
    refusal: str = ""


def stock_timesteps(engine: Engine) -> tuple[float, ...]:
    """The timesteps in s at which an engine is run whatever the scene, the coarsest first."""
    own = engine.stock_timestep
    return tuple(sorted({own or COMMON_TIMESTEP, COMMON_TIMESTEP}, reverse=True))


def stock_run(scenario: Scenario, timestep: float, rate: float, horizon: float) -> StockRun:
    """The exact motion at the samples of a run with such a timestep, where it makes sense.

    Parameters
    ----------
    rate : the fastest of the motion, rad/s
    horizon : s, up to which the motion is known
    """
    if refusal := _refusal(timestep, rate, horizon):
        return StockRun(timestep, refusal=refusal)
    rung = single(timestep, scenario.times[scenario.times <= horizon])
    times = np.asarray(rung.sample_steps * timestep, dtype=float)
    solution = solve(scenario, times)
    rung = rung.until(len(solution.trajectory.t))
    if rung.steps < LEAST_STEPS:
        return StockRun(timestep, refusal=_too_few(timestep, rung.steps * timestep))
    return StockRun(timestep, rung, solution)


def _refusal(timestep: float, rate: float, horizon: float) -> str:
    """Why a run with such a timestep is not made; empty if it is."""
    turn, steps = timestep * rate, horizon / timestep
    if turn > LARGEST_TURN:
        return (
            f"at {timestep:.4g} s the motion turns {turn:.3g} rad a step; more than half a turn "
            "cannot be told from its opposite"
        )
    if steps < LEAST_STEPS:
        return _too_few(timestep, horizon)
    if steps > STEP_BUDGET:
        return (
            f"at {timestep:.4g} s the motion takes {math.ceil(steps):.3g} steps; at stock "
            f"timesteps at most {STEP_BUDGET} are made"
        )
    return ""


def _too_few(timestep: float, duration: float) -> str:
    steps = math.floor(duration / timestep)
    return f"at {timestep:.4g} s the {duration:.3g} s of motion are {steps} steps, too few to judge"
