"""The options `run --ensemble` and `show --member`: what they do, and what they print."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ....scenarios import Scenario, ScenarioError
from ....scenarios.scatter import member
from ...harness.choice import Choice
from ...harness.varied.ensemble import plan_ensemble, run_ensemble
from ...pages.analysis.measures import A_TURN, ATTITUDE, QUANTILES, TURNS, Members
from ...results.ensemble_records import (
    MAX_MEMBERS,
    MAX_SEED,
    Ensemble,
    EnsembleResult,
    points_of,
)
from ...results.records import Row
from ...results.result_file import ResultFileError
from ...results.store import open_store
from ..choosing import check_timesteps, choose, executor_for, say_if_compiling
from ..named_scenes import one_scene, scenes_to_run
from ..run.running import check_all_apply, gone_on_with
from ..run.summary import row_record
from ..stopping import saying
from ..terminal import (
    AGREES,
    DISAGREES,
    NOT_RUN,
    Complaint,
    as_complaint,
    command,
    progress,
    say,
    table,
    to_json,
)


def print_ensemble(swept: EnsembleResult) -> None:
    """Print a table with a line for each method that was run on the members of an ensemble.

    Below it is the number of members that are no valid scene, if there are any.
    """
    print(f"{swept.scenario.name}: {swept.ensemble}")
    table([_line(points) for points in _by_method(swept.points)])
    no_scene = {point.variation: point.reason for point in swept.points if point.cause == "scene"}
    if no_scene:
        first = next(iter(no_scene.values()))
        print(f"{len(no_scene)} members are no scene; the first of them: {first}")


def ensemble_as_json(swept: EnsembleResult) -> dict[str, Any]:
    """Return an ensemble as a JSON object; scripts rely on the names of the keys.

    It has the fields of `Ensemble`, and in `points` the runs of members, as `row_record` returns
    them.
    """
    return asdict(swept.ensemble) | {"points": [row_record(point) for point in swept.points]}


def _by_method(points: Iterable[Row]) -> list[list[Row]]:
    """Return runs in groups, one for each method; the groups are sorted by engine and method."""
    by_method: dict[tuple[str, str], list[Row]] = {}
    for point in points:
        by_method.setdefault(point.pair, []).append(point)
    return [by_method[pair] for pair in sorted(by_method)]


def _line(points: Sequence[Row]) -> dict[str, object]:
    """Return a row of a table that sums up the runs of one method on the members of an ensemble.

    By the headings of the columns, it has how the runs ended and why, quantiles of their errors,
    and the member with the largest attitude error.
    """
    outcomes = Counter(point.outcome for point in points)
    causes = Counter(point.cause for point in points if point.cause)
    run = Members(points[0].pair, tuple(point for point in points if point.simulated))
    worst = max(run.points, key=lambda point: ATTITUDE.of(point) or 0.0, default=None)
    none = (None,) * len(QUANTILES)
    off = zip(QUANTILES, run.quantiles(ATTITUDE) or none, strict=True)
    return {
        "method": " ".join(run.pair),
        "ended": ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common()),
        "why": ", ".join(f"{cause} {count}" for cause, count in causes.most_common()),
        **{f"off by, °: {name}": value for name, value in off},
        "1° off after, turns: p50": (run.quantiles(TURNS) or none)[0],
        "° a turn: p50": (run.quantiles(A_TURN) or none)[0],
        "worst at": f"member {worst.varied['member']}" if worst else "",
    }


#: Number of lines of progress that an ensemble prints if there is no terminal to draw a bar on.
PROGRESS_LINES = 50


def run_ensembles(
    scenes: Sequence[str], members: int, seed: int, choice: Choice, jobs: int, out: Path
) -> list[EnsembleResult]:
    """Run those members of each scene's ensemble that have no stored results; return all results.

    Parameters
    ----------
    scenes : files, folders or names of library scenes, at least one
    members : number of members
    seed : seed of the random numbers that scatter the members
    choice : the engines and methods that are run, with one timestep at most; without one, each
        engine runs at its stock timestep
    jobs : number of worker processes
    out : the result file, to which runs are added

    Raises
    ------
    Complaint
        If a name, a number or the result file cannot be used.
    """
    if not scenes:
        raise Complaint("'--ensemble' takes scenes to scatter, got none")
    bases = scenes_to_run(scenes, expectations=False)
    _check_members(members, seed)
    check_timesteps(bases, choice)
    timestep = choice.timesteps[0] if choice.timesteps else None
    ensembles = [(Ensemble(base.name, members, seed, timestep), base) for base in bases]
    return _carried_out(ensembles, choice, jobs, out)


def _check_members(members: int, seed: int) -> None:
    """Raise a `Complaint` if the number of members or the seed is too large."""
    if members > MAX_MEMBERS:
        raise Complaint(f"an ensemble has {MAX_MEMBERS} members at most, got {members}")
    if seed > MAX_SEED:
        raise Complaint(f"'--seed' must be less than 2^128, got {seed}")


def member_of(scene: str, number: int | None, seed: int | None) -> Scenario:
    """Return a member of a scene's ensemble, as a scene.

    Parameters
    ----------
    scene : a file, or the name of a library scene
    number : number of the member, from 0 on; None for the scene itself
    seed : seed of the ensemble; 0 if None

    Raises
    ------
    Complaint
        If the scene cannot be read, the member is no valid scene, the number or the seed is too
        large, or a seed is given without a number.
    """
    base = one_scene(scene)
    if number is None:
        if seed is not None:
            raise Complaint("'--seed' is for a member of an ensemble; add '--member'")
        return base
    _check_members(number + 1, seed or 0)
    with as_complaint(ScenarioError):
        return member(base, seed or 0, number)


def choose_for_ensemble(
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    time_limit: float | None = None,
    *,
    again: bool = False,
    python: str = "",
) -> Choice:
    """Return the engines, methods, timestep and time limit with which an ensemble is run.

    Parameters
    ----------
    engine_names, methods : names as typed; if empty, all engines but optional ones, and all methods
    timesteps : one timestep at most, s; if empty, the stock timestep of each engine
    time_limit : CPU time that a run may take, s; the default if None
    again : whether members are run whose results are stored already
    python : the command of the interpreter that other versions of engines run under; the
        interpreter of this process if empty

    Raises
    ------
    Complaint
        If there are several timesteps, if there is no engine or method of some name, if an engine
        cannot be used, or if a number is out of range.
    """
    if len(timesteps) > 1:
        raise Complaint(f"'--timestep' may be given once with '--ensemble', got {len(timesteps)}")
    choice = choose(engine_names, methods, timesteps, time_limit=time_limit, python=python)
    return replace(choice, again=again)


def print_ensembles(swept: Sequence[EnsembleResult], out: Path, as_json: bool) -> None:
    """Print ensembles as tables or as JSON; in JSON, several ensembles are a list.

    Parameters
    ----------
    out : the result file, which a message below the tables names
    """
    if as_json:
        records = [ensemble_as_json(one) for one in swept]
        print(to_json(records[0] if len(records) == 1 else records))
        return
    for one in swept:
        print_ensemble(one)
    say(
        f"Runs are in {out}; '{command('report', out)}' draws them. 'spincheck show SCENE --toml "
        "--member N' prints the scene of one."
    )


def exit_code_of(swept: Iterable[EnsembleResult]) -> int:
    """Return the exit code: 3 if all runs failed or there are no runs, 1 if some failed, else 0.

    A run that diverged does not count as failed.
    """
    outcomes = {point.outcome for one in swept for point in one.points}
    if outcomes <= {"failed"}:
        return NOT_RUN
    return DISAGREES if "failed" in outcomes else AGREES


def _carried_out(
    definitions: Sequence[tuple[Ensemble, Scenario]], choice: Choice, jobs: int, out: Path
) -> list[EnsembleResult]:
    """Run those members of ensembles that have no stored results; return the results of all.

    Parameters
    ----------
    definitions : each ensemble, with the scene that is scattered
    choice : the engines and methods that are run, and whose results are returned
    jobs : number of worker processes
    out : the result file, which is created if necessary, and to which new runs are added
    """
    check_all_apply(choice, [base for _, base in definitions])
    results = []
    with (
        as_complaint(ResultFileError),
        saying(gone_on_with(out)),
        open_store(out, create=True) as store,
    ):
        left = [
            (plan_ensemble(ensemble, base, choice, store), base) for ensemble, base in definitions
        ]
        complete, total = (sum(getattr(p, n) for p, _ in left) for n in ("complete", "total"))
        if complete:
            say(f"{out}: {complete} of {total} points are stored already")
        if complete < total:
            say_if_compiling()
            with (
                executor_for(jobs, choice) as executor,
                progress(total - complete, PROGRESS_LINES) as advance,
            ):
                for planned, base in left:
                    run_ensemble(planned, base, store, executor, advance)
        for ensemble, base in definitions:
            points = points_of(ensemble, store.varied(base.name))
            pairs = {key.pair for key in choice.methods_on(base)}
            chosen = tuple(row for row in points if row.pair in pairs)
            results.append(EnsembleResult(ensemble, base, chosen))
    return results
