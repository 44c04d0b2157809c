"""What a script of `spincheck reproduce` prints, and what the harness finds of the same run."""

import re
from functools import cache

import numpy as np
from spincheck.engines import Engine, Method
from spincheck.reference import Solution, solve
from spincheck.reports.harness.timesteps.ladder import single
from spincheck.scenarios import FloatArray, Scenario, Trajectory, errors_between

#: A script prints four digits.
PRINTED = 1e-3

Errors = tuple[float, float]


def printed_errors(output: str, timestep: float) -> tuple[list[int], Errors]:
    """The steps of the table's rows, and the largest errors of ω and attitude, its last line."""
    # Engines print things of their own before and after.
    table = re.findall(r"^ *([\d.e+-]+|largest) +([\d.e+-]+) +([\d.e+-]+)$", output, re.M)
    *rows, (last, omega, attitude) = table
    assert last == "largest"
    return [round(float(time) / timestep) for time, _, _ in rows], (float(omega), float(attitude))


def harness_errors(
    scenario: Scenario, engine: Engine, method: Method, timestep: float, steps: list[int]
) -> Errors:
    """The largest errors of a run at these steps, of ω by the largest ω of the scene, and rad."""
    run = engine.run(scenario, method, timestep, np.array(steps))
    assert run.trajectory is not None, run.reason
    motion = solved(scenario, run.trajectory.t).trajectory
    every = solved(scenario, single(timestep, scenario.times).sample_steps * timestep).trajectory
    errors = errors_between(scenario, run.trajectory, motion)
    return errors.omega * _fastest(motion) / _fastest(every), errors.attitude


def solved(scenario: Scenario, times: FloatArray) -> Solution:
    """As `solve`, once for all engines and methods."""
    return _solved(scenario, tuple(times))


@cache
def _solved(scenario: Scenario, times: tuple[float, ...]) -> Solution:
    return solve(scenario, np.array(times))


def _fastest(motion: Trajectory) -> float:
    return float(np.linalg.norm(motion.omega_body, axis=1).max())
