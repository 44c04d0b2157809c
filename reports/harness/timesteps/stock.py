"""Runs at stock timesteps: the engine's default, and a timestep common to all engines.

They are made and stored in addition to a method's ladder. The run at the engine's own stock
timestep is replayed for the method's verdict (`measuring/replay.py`).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ....engines import Engine
from ....reference import Solution
from ....scenarios import FloatArray, Scenario
from .ladder import LARGEST_TURN, LEAST_STEPS, QUICK_STEPS, Rung, single

#: Timestep, s, at which every engine is run, so that engines can be compared at one timestep.
COMMON_TIMESTEP = 1e-3
#: Largest number of steps of a run at a stock timestep: such a run takes about 1 s in MuJoCo and a
#: few seconds in PyBullet. On hard scenes the limit is lower (`stock_runs_of`).
STEP_BUDGET = 1 << 17


@dataclass(frozen=True, eq=False)
class StockRun:
    """A run of a scene at a stock timestep.

    Attributes
    ----------
    timestep : s
    rung, solution : the timestep with its samples, and the exact motion at these; both None if the
        run is refused
    refusal : why the run is not made, in words; empty if it is made
    """

    timestep: float
    rung: Rung | None = None
    solution: Solution | None = None
    refusal: str = ""


def stock_timestep(engine: Engine) -> float:
    """Return the engine's stock timestep, s; `COMMON_TIMESTEP` if it has none."""
    return engine.stock_timestep or COMMON_TIMESTEP


def stock_timesteps(engine: Engine) -> tuple[float, ...]:
    """Return the timesteps, s, at which an engine is run on every scene, the coarsest first."""
    return tuple(sorted({stock_timestep(engine), COMMON_TIMESTEP}, reverse=True))


def stock_runs_of(
    engine: Engine, scenario: Scenario, at_stock: Iterable[StockRun]
) -> list[StockRun]:
    """Return an engine's runs at its own stock timestep and at `COMMON_TIMESTEP`.

    On a hard scene the run at `COMMON_TIMESTEP` is refused if it would take more than `QUICK_STEPS`
    steps, unless that is also the engine's own stock timestep.

    Parameters
    ----------
    at_stock : the runs at the stock timesteps of all engines
    """
    own, common = stock_timestep(engine), COMMON_TIMESTEP
    return [
        _refused_if_long(run) if scenario.hard and run.timestep != own else run
        for run in at_stock
        if run.timestep in (own, common)
    ]


def _refused_if_long(run: StockRun) -> StockRun:
    """Return a run, changed into a refused one if it would take more than `QUICK_STEPS` steps."""
    if run.rung is None or run.rung.steps <= QUICK_STEPS:
        return run
    return StockRun(
        run.timestep,
        refusal=f"at {run.timestep:.4g} s the motion takes {run.rung.steps} steps; on hard scenes "
        f"at most {QUICK_STEPS} are made at the timestep that all engines share ('--timestep' "
        "makes more)",
    )


def stock_rung(times: FloatArray, timestep: float, rate: float) -> Rung | str:
    """Return the rung of a run at a stock timestep; if the run is refused, the reason in words.

    Parameters
    ----------
    times : times of the n samples of the window at which the exact motion is known, s, (n,)
    timestep : s
    rate : fastest rate of the motion, rad/s
    """
    if refusal := _refusal(timestep, rate, float(times[-1])):
        return refusal
    rung = single(timestep, times)
    if rung.steps < LEAST_STEPS:
        return _too_few(timestep, rung.steps * timestep)
    return rung


def _refusal(timestep: float, rate: float, horizon: float) -> str:
    """Return in words why a run with this timestep is not made; empty if it is made.

    Parameters
    ----------
    timestep : s
    rate : fastest rate of the motion, rad/s
    horizon : time of the last sample, s
    """
    turn, steps = timestep * rate, horizon / timestep
    if turn > LARGEST_TURN:
        return (
            f"at {timestep:.4g} s the motion turns {math.degrees(turn):.3g}° a step; more than "
            "half a turn cannot be told from its opposite"
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
    """Return the message that a motion of some duration, s, has too few steps of a timestep, s."""
    steps = math.floor(duration / timestep)
    return f"at {timestep:.4g} s the {duration:.3g} s of motion are {steps} steps, too few to judge"
