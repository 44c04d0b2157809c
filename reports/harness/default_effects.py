"""What each default of an engine does to a motion: as shipped, one default at a time."""

from collections.abc import Collection

import numpy as np

from ...engines import Engine, EngineError, Method
from ...engines.faults import Bounds
from ...engines.read_back import READ_BACK_SLACK
from ...engines.sampling import sample
from ...reference import Solution
from ...scenarios import Errors, Scenario, Trajectory, errors_between
from ..results.default_records import DefaultEffect, DefaultEffects
from ..results.records import Key
from .ladder import Rung


def default_effects(
    scenario: Scenario, engine: Engine, method: Method, rung: Rung, solution: Solution
) -> DefaultEffects | None:
    """Run a method as shipped with every default alone, and without each; None if it has none.

    Parameters
    ----------
    rung : the timestep, usually the engine's stock timestep, and the steps of the samples
    solution : the exact motion at these samples
    """
    names = engine.defaults(scenario, method)
    if not names or engine.unsupported(scenario, method):
        return None

    def errors(defaults: Collection[str]) -> Errors | None:
        return _errors(scenario, engine, method, rung, solution, defaults)

    return DefaultEffects(
        Key(scenario.name, engine.name, method.name),
        rung.timestep,
        errors(()),
        errors(names),
        tuple(
            DefaultEffect(name, errors([name]), errors([other for other in names if other != name]))
            for name in names
        ),
    )


def _errors(
    scenario: Scenario,
    engine: Engine,
    method: Method,
    rung: Rung,
    solution: Solution,
    defaults: Collection[str],
) -> Errors | None:
    """Of a run with these defaults; None where it did not come to its end."""
    bounds = Bounds(rung.timestep, method.max_rotation_per_step, READ_BACK_SLACK, np.inf)
    try:
        with engine.open_with_defaults(scenario, method, rung.timestep, defaults) as session:
            sampled = sample(session, rung.sample_steps, bounds)
    except EngineError:
        return None
    if sampled.outcome != "ok":
        return None
    times = np.asarray(rung.sample_steps * rung.timestep, dtype=float)
    motion = Trajectory(t=times, **vars(sampled.states))
    return errors_between(scenario, motion, solution.trajectory)
