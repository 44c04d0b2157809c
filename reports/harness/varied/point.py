"""Runs methods at one point of an ensemble, which is a member at a timestep, and compares them."""

from collections.abc import Sequence
from dataclasses import replace

from ....engines import Cause, Engine, Outcome
from ....reference import Solution, solve_cheaply
from ....scenarios import Scenario, ScenarioError
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.scatter import member
from ...results.ensemble_records import EnsemblePoint
from ...results.records import Key, Row, variation
from ..choice import EngineMethod
from ..comparison.defects import with_defects
from ..comparison.rows import row_of
from ..executors import cause_of, is_environmental
from ..timesteps.ladder import Rung, single
from ..timesteps.stock import STEP_BUDGET, stock_rung, stock_timestep

Solved = dict[float, Solution] | str


def run_point(base: Scenario, point: EnsemblePoint, pairs: Sequence[EngineMethod]) -> list[Row]:
    """Run methods on a member of an ensemble, and return one row for each method.

    All rows are `unsupported` if the member is not a valid scene, or if the timestep that `point`
    states is too long or too short for the window. The rows of one engine are `unsupported` if its
    stock timestep is refused, or if a run would take more than `STEP_BUDGET` steps. If the exact
    motion cannot be found, the other rows are `failed`; but if the machine is to blame, the error
    is raised. Without methods the exact motion is still solved, to find out whether that succeeds.

    Parameters
    ----------
    base : the scene whose start and body are scattered
    point : the member, and the timestep of its runs
    pairs : the methods, with their engines

    Raises
    ------
    IntegrationError
        If there are no methods, and the exact motion cannot be found.
    """
    try:
        scenario = scene_at(point, base)
        rungs = [_within_budget(rung_at(point, scenario, engine)) for engine, _ in pairs]
    except ValueError as error:
        reason = _no_scene(error)
        return [not_run(base, point, pair, "unsupported", "scene", reason) for pair in pairs]
    if not pairs:
        solve_cheaply(scenario, [scenario.times])
    solved = _solved(scenario, [rung for rung in rungs if isinstance(rung, Rung)])
    return [
        not_run(base, point, pair, "unsupported", "timestep", rung)
        if isinstance(rung, str)
        else _row(scenario, point, pair, rung, solved)
        for pair, rung in zip(pairs, rungs, strict=True)
    ]


def not_run(
    base: Scenario,
    point: EnsemblePoint,
    pair: EngineMethod,
    outcome: Outcome,
    cause: Cause,
    why: str,
) -> Row:
    """Return the row of a method that was not run on a member, or whose call has failed.

    Parameters
    ----------
    base : the scene whose start and body are scattered
    point : the member, and the timestep of its runs
    pair : the method, with its engine
    outcome, cause, why : outcome and cause, in one word each, and the reason in a sentence
    """
    engine, method = pair
    key, timestep = Key(base.name, engine.name, method.name), _timestep(base, point, engine)
    varied = variation(point.varied)
    return Row(key, "", timestep, outcome, why, cause, variation=varied)


def _timestep(base: Scenario, point: EnsemblePoint, engine: Engine) -> float:
    """Return the timestep of a run that was not made, s; 0 if the run has none.

    It has none if the member is no valid scene, or if the engine's stock timestep is refused.
    """
    if point.timestep is not None:
        return point.timestep
    try:
        rung = rung_at(point, scene_at(point, base), engine)
    except ValueError:
        return 0.0
    return rung.timestep if isinstance(rung, Rung) else 0.0


def _no_scene(error: ValueError) -> str:
    """Return in words why a member is no valid scene or has no rung, given the error."""
    if not isinstance(error, ScenarioError):
        return str(error)
    # The line number is left out: the varied file exists in memory only.
    return "; ".join(line.partition(": ")[2] for line in str(error).splitlines())


def _within_budget(rung: Rung | str) -> Rung | str:
    """Return the rung itself; or in words why it is not run, if it takes too many steps.

    If `rung` is a text, which says why the run is refused, it is returned unchanged.
    """
    if isinstance(rung, Rung) and rung.steps > STEP_BUDGET:
        return f"it takes {rung.steps} steps, and a point may take {STEP_BUDGET}"
    return rung


def _solved(scenario: Scenario, rungs: Sequence[Rung]) -> Solved:
    """Return the exact motion at the samples of each rung, by the rung's timestep, s.

    If it cannot be found, the reason is returned in words; but if the machine is to blame, the
    error is raised.
    """
    times = {rung.timestep: rung.times for rung in rungs}
    if not times:
        return {}
    try:
        solutions = solve_cheaply(scenario, list(times.values()))
    except Exception as error:
        if is_environmental(cause_of(error)):
            raise
        return f"the exact motion could not be found: {type(error).__name__}: {error}"
    return dict(zip(times, solutions, strict=True))


def _row(
    scenario: Scenario, point: EnsemblePoint, pair: EngineMethod, rung: Rung, solved: Solved
) -> Row:
    """Run a method on a member of an ensemble; return its row, without motion and defects.

    Parameters
    ----------
    scenario : the member
    point : the member's numbers, by which the row is stored
    pair : the method, with its engine
    rung : the timestep and samples of the run
    solved : the exact motion by timestep, s; or in words why it is not known
    """
    if isinstance(solved, str):
        return not_run(scenario, point, pair, "failed", "unsolved", solved)
    engine, method = pair
    solution = solved[rung.timestep]
    within = Rung(rung.timestep, rung.sample_steps[: len(solution.trajectory.t)])
    run = engine.run(scenario, method, within.timestep, within.sample_steps)
    key = Key(scenario.name, engine.name, method.name)
    row = row_of(scenario, key, engine.version, within, run, solution)
    exact, is_single = solution.trajectory, engine.single_precision
    row = with_defects(row, scenario, exact, is_single=is_single)
    # Motion and defects are not stored, as there are many points.
    return replace(row, variation=variation(point.varied), motion=None, defects=None)


def scene_at(point: EnsemblePoint, base: Scenario) -> Scenario:
    """Return the scene of a member: `base` with its start and body scattered.

    Parameters
    ----------
    point : the member
    base : the scene whose start and body are scattered

    Raises
    ------
    ScenarioError
        If the scattered scene is not valid.
    """
    return member(base, point.seed, point.number)


def rung_at(point: EnsemblePoint, scenario: Scenario, engine: Engine) -> Rung | str:
    """Return the rung of an engine's run on a member; if the run is refused, the reason in words.

    The timestep is that of `point`, or the engine's stock timestep if `point` states none.

    Parameters
    ----------
    point : the member, and the timestep of its runs
    scenario : the member's scene

    Raises
    ------
    ValueError
        If the point's timestep is at least twice the window, or so short that a run would take
        more than `MOST_STEPS` steps.
    """
    if point.timestep is not None:
        return single(point.timestep, scenario.times)
    rate = fastest_rate(scenario, scenario.start.omega_body)
    return stock_rung(scenario.times, stock_timestep(engine), rate)
