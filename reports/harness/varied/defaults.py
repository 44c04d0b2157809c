"""Runs one scene at one timestep with varied engines, and makes a row of each run."""

from dataclasses import replace

from ....engines import Engine, Run
from ....engines.varied_engine import VariedEngine
from ....reference import Solution
from ....scenarios import Scenario
from ...results.records import Key, Row, variation
from ..comparison.rows import row_of
from ..measuring.examine import examine
from ..measuring.places import Places
from ..timesteps.ladder import Rung


def varied_row(scenario: Scenario, engine: Engine, run: Run, rung: Rung, solution: Solution) -> Row:
    """Return the row of a run by a varied engine, without its motion."""
    key = Key(scenario.name, engine.name, run.method)
    row = row_of(scenario, key, run.engine_version, rung, run, solution)
    return replace(row, variation=variation(engine.varied), motion=None)


def runs_with_defaults(
    scenario: Scenario,
    engine: Engine,
    method_name: str,
    rung: Rung,
    solution: Solution,
    at: Places | None = None,
) -> list[Row]:
    """Run a method as shipped with no default, with each default alone, and with all but each.

    Parameters
    ----------
    rung, solution : the timestep and samples of all runs, and the exact motion at the samples
    at : exact states from which single steps are taken, to find out which defaults change the limit
        of vanishing timesteps (`Row.acts`); None if that is not wanted

    Returns
    -------
    One row for each set of defaults
    """
    method = engine.method(method_name)
    names = engine.defaults(scenario, method)
    at_most_one = [(), *((name,) for name in names)]
    others = [tuple(other for other in names if other != name) for name in names]
    rows = []
    for some in dict.fromkeys([*at_most_one, *others]):
        varied = VariedEngine(engine, "defaults", some)
        run = varied.run(scenario, method, rung.timestep, rung.sample_steps)
        row = varied_row(scenario, varied, run, rung, solution)
        if at and some in at_most_one:
            found = examine(varied, scenario, method_name, at, explains=False)
            row = replace(row, acts=None if found is None else found.fault is not None)
        rows.append(row)
    return rows
