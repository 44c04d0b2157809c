"""The scene and the run at one point of a sweep."""

import numpy as np

from ...engines import Engine
from ...scenarios import Scenario
from ...scenarios.fastest_rate import fastest_rate
from ...scenarios.scatter import member
from ...scenarios.vary import varied
from ..results.sweep_records import SweepPoint
from .ladder import Rung, single
from .stock import stock_rung, stock_timestep

#: Angle turned in a step of a map without a timestep, rad, at the fastest rate at the start.
STEP_TURN = 0.02


def scene_at(point: SweepPoint, base: Scenario) -> Scenario:
    """The scene at a point.

    Raises
    ------
    ScenarioError
        If the numbers make no valid scene.
    """
    return member(base, *point.member) if point.member else varied(base, dict(point.numbers))


def rung_at(point: SweepPoint, scenario: Scenario, engine: Engine) -> Rung | str:
    """Timestep and samples of a run of the scene at a point, or why the run is not made.

    Of a member of an ensemble without a timestep it is the engine's stock timestep.

    Raises
    ------
    ValueError
        If the window is shorter than one step.
    """
    if point.timestep is not None:
        return single(point.timestep, scenario.times)
    rate = fastest_rate(scenario, scenario.start.omega_body)
    if point.member:
        return stock_rung(scenario.times, stock_timestep(engine), rate)
    intervals = scenario.window.samples - 1
    interval = scenario.window.duration / intervals
    per_interval = max(1, int(np.ceil(interval * rate / STEP_TURN)))
    return Rung(interval / per_interval, np.arange(intervals + 1, dtype=np.int64) * per_interval)
