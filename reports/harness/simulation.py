"""Simulates a scene in an engine, and looks at what its first steps obey."""

from dataclasses import dataclass, field, replace
from functools import lru_cache

from ...engines import Engine, Run
from ...scenarios import Scenario
from .ladder import Rung

#: Models kept: more than the methods of the scenes that run at the same time.
MODELS = 64


def simulate(engine: Engine, scenario: Scenario, method: str, rung: Rung) -> Run:
    """One run, in a worker; if it is ok or lags, with the equation residuals of its first steps."""
    run = engine.run(scenario, engine.method(method), rung.timestep, rung.sample_steps)
    if not (run.outcome == "ok" or run.cause == "lag"):
        return run
    is_single = run.cause == "precision"
    model = _Model(engine.name, method, scenario.digest, is_single, engine, scenario)
    residuals = _equation_residuals(model)
    if not residuals:
        return run
    reason = "; ".join(filter(None, (run.reason, residuals)))
    if run.outcome == "ok":
        return replace(run, cause="law", reason=reason)
    # A lag at however small a step is not a clamp.
    return replace(run, outcome="failed", cause="clock", reason=reason)


@dataclass(frozen=True)
class _Model:
    """A scene in an engine, by one method; equal by names and digest."""

    engine_name: str
    method: str
    digest: str
    single_precision: bool
    engine: Engine = field(compare=False)
    scenario: Scenario = field(compare=False)


@lru_cache(maxsize=MODELS)
def _equation_residuals(model: _Model) -> str:
    """The residuals of its first steps, independent of the timestep: measured once a process."""
    method = model.engine.method(model.method)
    single = model.single_precision
    return model.engine.equation_residuals(model.scenario, method, single_precision=single)
