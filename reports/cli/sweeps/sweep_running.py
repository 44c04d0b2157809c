"""What `run --vary`, `run --ensemble` and `show --vary` do, and print."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ....scenarios import Scenario, ScenarioError
from ....scenarios.scatter import member
from ....scenarios.vary import TIMESTEP, VaryError, check_path, parse_axis, varied
from ...harness.choice import Choice
from ...harness.varied.sweep import plan_sweep, run_sweep
from ...pages.analysis.measures import A_TURN, ATTITUDE, QUANTILES, TURNS, Members
from ...results.records import Row
from ...results.result_file import ResultFileError
from ...results.store import open_store
from ...results.sweep_records import (
    MAX_MEMBERS,
    MAX_SEED,
    Ensemble,
    Map,
    SweepResult,
    points_of,
)
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
    progress,
    say,
    table,
    to_json,
)


def print_sweep(swept: SweepResult) -> None:
    """Print one line for each method, and its worst point."""
    names = swept.sweep.names
    print(f"{swept.scenario.name}: {swept.sweep}")
    table([_line(points, names) for points in _by_method(swept.points)])
    no_scene = {point.variation: point.reason for point in swept.points if point.cause == "scene"}
    if no_scene:
        first = next(iter(no_scene.values()))
        print(f"{len(no_scene)} points are no scene; the first of them: {first}")


def sweep_as_json(swept: SweepResult) -> dict[str, Any]:
    """What was asked for, and its points, with the names that scripts rely on."""
    return asdict(swept.sweep) | {"points": [row_record(point) for point in swept.points]}


def _by_method(points: Iterable[Row]) -> list[list[Row]]:
    by_method: dict[tuple[str, str], list[Row]] = {}
    for point in points:
        by_method.setdefault(point.pair, []).append(point)
    return [by_method[pair] for pair in sorted(by_method)]


def _line(points: Sequence[Row], names: Sequence[str]) -> dict[str, object]:
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
        "worst at": _place(worst, names) if worst else "",
    }


def _place(point: Row, names: Sequence[str]) -> str:
    return ", ".join(f"{name} {point.varied[name]:.6g}" for name in names)


#: Lines of progress that a sweep prints if there is no terminal to draw a bar on.
PROGRESS_LINES = 50
#: The path of the window: if it is varied, the timestep is checked point by point.
_DURATION = "window.duration"


def run_sweeps(
    scenes: Sequence[str],
    ranges: Sequence[str],
    members: int | None,
    seed: int,
    choice: Choice,
    jobs: int,
    out: Path,
) -> list[SweepResult]:
    """Run the points that a map or an ensemble of each scene still lacks, and read all of it.

    Parameters
    ----------
    ranges : of a map, two axes, as `parse_axis` reads them
    members, seed : of an ensemble, the number of members, and the seed of their random numbers
    choice : with one timestep at most
    """
    if ranges and members is not None:
        raise Complaint("takes '--vary' or '--ensemble', not both")
    if not scenes:
        raise Complaint("'--vary' and '--ensemble' take scenes to vary, got none")
    bases = scenes_to_run(scenes, expectations=False)
    if members is None:
        sweeps: list[Map | Ensemble] = [_map(base, ranges, choice) for base in bases]
    else:
        _check_members(members, seed)
        sweeps = [Ensemble(base.name, members, seed, _timestep(choice)) for base in bases]
    check_timesteps(
        [b for b, s in zip(bases, sweeps, strict=True) if _DURATION not in s.names], choice
    )
    return _carried_out(list(zip(sweeps, bases, strict=True)), choice, jobs, out)


def _check_members(members: int, seed: int) -> None:
    if members > MAX_MEMBERS:
        raise Complaint(f"an ensemble has {MAX_MEMBERS} members at most, got {members}")
    if seed > MAX_SEED:
        raise Complaint(f"'--seed' must be less than 2^128, got {seed}")


def varied_scene(
    scene: str, numbers: Sequence[str], number: int | None, seed: int | None
) -> Scenario:
    """Return a scene, or a member of an ensemble of it, with other numbers.

    Parameters
    ----------
    numbers : as PATH=VALUE
    number, seed : of the member
    """
    base = one_scene(scene)
    if number is not None:
        _check_members(number + 1, seed or 0)
        base = member(base, seed or 0, number)
    elif seed is not None:
        raise Complaint("'--seed' is for a member of an ensemble; add '--member'")
    values = dict(_number(text) for text in numbers)
    if len(values) < len(numbers):
        raise Complaint(f"'--vary' takes each number once, got {', '.join(numbers)}")
    with as_complaint(VaryError, ScenarioError):
        for path in values:
            check_path(base, path)
        if TIMESTEP in values:
            raise VaryError("the timestep is no number of the scene; give it to 'spincheck run'")
        return varied(base, values) if values else base


def choose_for_sweep(
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    time_limit: float | None = None,
    *,
    again: bool = False,
    python: str = "",
) -> Choice:
    """Engines, methods, at most one timestep, a time limit, s, and whether all is run again.

    Parameters
    ----------
    python : the command of the interpreter that versions run under; this one if empty
    """
    if len(timesteps) > 1:
        raise Complaint(
            f"'--timestep' may be given once here, got {len(timesteps)}; or vary it in a map"
        )
    choice = choose(engine_names, methods, timesteps, time_limit=time_limit, python=python)
    return replace(choice, again=again)


def print_sweeps(swept: Sequence[SweepResult], out: Path, as_json: bool) -> None:
    """Print sweeps, as JSON a single one or a list of them."""
    if as_json:
        records = [sweep_as_json(one) for one in swept]
        print(to_json(records[0] if len(records) == 1 else records))
        return
    for one in swept:
        print_sweep(one)
    say(
        f"Runs are in {out}; 'spincheck report {out}' draws them. 'spincheck show SCENE --toml', "
        "with '--vary' or '--member', prints the scene of one."
    )


def exit_code_of(swept: Iterable[SweepResult]) -> int:
    """0 if every run came to an end of its own, 1 if one failed, 3 if all did."""
    outcomes = {point.outcome for one in swept for point in one.points}
    if outcomes <= {"failed"}:
        return NOT_RUN
    return DISAGREES if "failed" in outcomes else AGREES


def _number(text: str) -> tuple[str, float]:
    path, _, value = text.partition("=")
    try:
        return path, float(value)
    except ValueError:
        raise Complaint(f"'--vary' takes PATH=VALUE, VALUE a number, got '{text}'") from None


def _map(base: Scenario, ranges: Sequence[str], choice: Choice) -> Map:
    with as_complaint(VaryError, before="'--vary' "):
        axes = [parse_axis(text) for text in ranges]
        for axis in axes:
            check_path(base, axis.path)
    paths = [axis.path for axis in axes]
    if len(axes) != 2 or paths[0] == paths[1]:
        raise Complaint(
            f"'--vary' must name two different numbers, got {', '.join(paths) or 'none'}"
        )
    if TIMESTEP in paths and choice.timesteps:
        raise Complaint("'--timestep' cannot be both given and varied")
    return Map(base.name, (axes[0], axes[1]), _timestep(choice))


def _timestep(choice: Choice) -> float | None:
    return choice.timesteps[0] if choice.timesteps else None


def _carried_out(
    sweeps: Sequence[tuple[Map | Ensemble, Scenario]], choice: Choice, jobs: int, out: Path
) -> list[SweepResult]:
    """Run what is missing of sweeps, and return them with the points of the methods chosen."""
    check_all_apply(choice, [base for _, base in sweeps])
    results = []
    with (
        as_complaint(ResultFileError),
        saying(gone_on_with(out)),
        open_store(out, create=True) as store,
    ):
        left = [(plan_sweep(sweep, base, choice, store), base) for sweep, base in sweeps]
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
                    run_sweep(planned, base, store, executor, advance)
        for sweep, base in sweeps:
            points = points_of(sweep, store.varied(base.name))
            pairs = {key.pair for key in choice.methods_on(base)}
            chosen = tuple(row for row in points if row.pair in pairs)
            results.append(SweepResult(sweep, base, chosen))
    return results
