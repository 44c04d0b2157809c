"""Measures what each default of an engine does to a motion, one default at a time."""

from collections.abc import Collection
from functools import cache

from ...engines import Engine, EngineError, Method
from ...engines.checks.faults import Bounds
from ...engines.engine import clamped_start
from ...engines.sampling import sample
from ...reference import Solution
from ...scenarios import Errors, Scenario, Trajectory, errors_between
from ..results.default_records import DefaultEffect, DefaultEffects
from ..results.records import Key
from ..results.store import Store
from .convergence_study import ConvergenceStudy
from .executors import Executor
from .ladder import Rung
from .measuring.examine import examined
from .measuring.places import Places


def take_defaults_away(study: ConvergenceStudy, executor: Executor, store: Store) -> None:
    """Store what each default does to the motion, at the coarsest stock timestep that can be run.

    Only an engine's first method as shipped is run: it has all of its defaults.
    """
    scenario, engine, method = study.scenario, study.engine, study.method
    first = next(other for other in engine.methods if other.as_shipped)
    made = [(run.rung, run.solution) for run in study.stock if run.rung and run.solution]
    if not made or method != first or not engine.defaults(scenario, method):
        return
    rung, solution = max(made, key=lambda run: run[0].timestep)
    if clamped_start(scenario, method, rung.timestep):
        return
    # The report's first screen, which counts what acts, is of plain scenes.
    at = None if scenario.hard else study.places
    arguments = (scenario, engine, method, rung, solution, at)
    effects = executor.call_at(engine.site, default_effects, *arguments).value
    if isinstance(effects, DefaultEffects):
        store.put(effects)


def default_effects(
    scenario: Scenario,
    engine: Engine,
    method: Method,
    rung: Rung,
    solution: Solution,
    at: Places | None = None,
) -> DefaultEffects | None:
    """Run a method as shipped with each default alone, and with all but one; None if it has none.

    Parameters
    ----------
    rung : the timestep, usually the engine's stock timestep, and the steps of the samples
    solution : the exact motion at these samples
    at : exact states to step from, to tell which defaults act at any timestep
    """
    names = engine.defaults(scenario, method)
    if not names or engine.unsupported(scenario, method):
        return None

    @cache
    def errors(*defaults: str) -> Errors | None:
        return _errors(scenario, engine, method, rung, solution, defaults)

    return DefaultEffects(
        Key(scenario.name, engine.name, method.name),
        rung.timestep,
        errors(),
        errors(*names),
        tuple(
            DefaultEffect(
                name,
                errors(name),
                errors(*(other for other in names if other != name)),
                _acts(scenario, engine, method, name, at) if at else None,
            )
            for name in names
        ),
    )


def _acts(scenario: Scenario, engine: Engine, method: Method, name: str, at: Places) -> bool | None:
    """Whether a default alone alters the equations of motion; None if it cannot be stepped."""
    try:
        found = examined(
            lambda scene, timestep: engine.open_with(scene, method, timestep, defaults=[name]),
            engine,
            scenario,
            at,
            method,
        )
    except EngineError:
        return None
    return found.fault is not None


def _errors(
    scenario: Scenario,
    engine: Engine,
    method: Method,
    rung: Rung,
    solution: Solution,
    defaults: Collection[str],
) -> Errors | None:
    """Errors of a run with these defaults; None if it did not finish."""
    bounds = Bounds(rung.timestep, method.max_rotation_per_step)
    try:
        with engine.open_with(scenario, method, rung.timestep, defaults=defaults) as session:
            sampled = sample(session, rung.sample_steps, bounds)
    except EngineError:
        return None
    if sampled.outcome != "ok":
        return None
    motion = Trajectory(t=rung.times, **vars(sampled.states))
    return errors_between(scenario, motion, solution.trajectory)
