"""Makes runs of one scene with varied engines, such as with only some of an engine's defaults."""

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
    """Return the row of a varied engine's run, compared with the exact motion.

    The row does not keep the motion itself (`Row.motion`).

    Parameters
    ----------
    engine : the engine that made the run, of which something is varied (`Engine.varied`)
    solution : the exact motion at the samples of the rung
    """
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
    """Run a method as shipped with several sets of its engine's defaults, and return the rows.

    Defaults are settings that change motions (`Engine.defaults`). The sets are: none of them, each
    of them alone, and all but one, for each. There is one run for each set.

    Parameters
    ----------
    rung : the timestep and samples of all runs
    solution : the exact motion at these samples
    at : exact states and timesteps of single steps, which show whether a default acts (`Row.acts`);
        they are examined with each default alone and with none. None if `Row.acts` is not wanted
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
