"""What the commands `map`, `member` and `run --ensemble` do, and print."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ....scenarios import Scenario, ScenarioError
from ....scenarios.scatter import member
from ....scenarios.vary import TIMESTEP, VaryError, check_path, parse_axis, varied
from ...harness.choice import Choice
from ...harness.sweep import plan_sweep, run_sweep
from ...pages.analysis.measures import A_TURN, ATTITUDE, QUANTILES, TURNS, Members
from ...results.as_json import as_json
from ...results.result_file import ResultFileError
from ...results.store import open_store
from ...results.sweep_records import (
    MAX_MEMBERS,
    MAX_SEED,
    Ensemble,
    Map,
    PlacedRow,
    SweepResult,
    points_of,
)
from ..choosing import Where, check_timesteps, choose, executor_for, say_if_compiling
from ..named_scenes import one_scene, scenes_to_run
from ..run.running import check_all_apply, gone_on_with
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
)


def print_sweep(swept: SweepResult) -> None:
    """Print one line for each method, and its worst point."""
    names = swept.sweep.names
    print(f"{swept.scenario.name}: {swept.sweep}")
    table([_line(points, names) for points in _by_method(swept.points)])
    no_scene = {point.place: point.reason for point in swept.points if point.cause == "scene"}
    if no_scene:
        first = next(iter(no_scene.values()))
        print(f"{len(no_scene)} points are no scene; the first of them: {first}")


def sweep_as_json(swept: SweepResult) -> dict[str, Any]:
    """What was asked for, and its points, with the names that scripts rely on."""
    names = swept.sweep.names
    return asdict(swept.sweep) | {"points": [point_record(point, names) for point in swept.points]}


def point_record(point: PlacedRow, names: Sequence[str]) -> dict[str, Any]:
    """A point with the names that scripts rely on.

    Parameters
    ----------
    names : of the numbers that are varied
    """
    record = as_json(point)
    del record["place"]
    return record | {"at": dict(zip(names, point.at, strict=True))}


def _by_method(points: Iterable[PlacedRow]) -> list[list[PlacedRow]]:
    by_method: dict[tuple[str, str], list[PlacedRow]] = {}
    for point in points:
        by_method.setdefault(point.pair, []).append(point)
    return [by_method[pair] for pair in sorted(by_method)]


def _line(points: Sequence[PlacedRow], names: Sequence[str]) -> dict[str, object]:
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


def _place(point: PlacedRow, names: Sequence[str]) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in zip(names, point.at, strict=True))


def flat_records(swept: SweepResult) -> list[dict[str, Any]]:
    """The points of a sweep, each with what it belongs to and where it is first."""
    sweep = swept.sweep
    kind = f"seed {sweep.seed}" if isinstance(sweep, Ensemble) else sweep.kind
    records = [point_record(point, sweep.names) for point in swept.points]
    return [{"sweep": kind, "at": one.pop("at"), **one} for one in records]


#: Lines of progress that a sweep prints if there is no terminal to draw a bar on.
PROGRESS_LINES = 50
#: The path of the window: if it is varied, the timestep is checked point by point.
_DURATION = "window.duration"


def run_map(
    scene: str,
    ranges: Sequence[str],
    choice: Choice,
    where: Where,
    out: Path,
) -> list[SweepResult]:
    """Run the points that a map still lacks, and read the whole map.

    Parameters
    ----------
    ranges : two axes, as `parse_axis` reads them
    choice : with one timestep at most
    """
    base = one_scene(scene)
    sweep = _map(base, ranges, choice)
    if _DURATION not in (axis.path for axis in sweep.axes):
        check_timesteps([base], choice)
    return _carried_out([(sweep, base)], choice, where, out)


def run_ensembles(
    scenes: Sequence[str],
    members: int,
    seed: int,
    choice: Choice,
    where: Where,
    out: Path,
) -> list[SweepResult]:
    """Run the members that ensembles still lack, and read them; see also `run_map`.

    Parameters
    ----------
    members, seed : number of members of each scene, and the seed of their random numbers
    """
    if not scenes:
        raise Complaint("'--ensemble' takes scenes to scatter, got none")
    bases = scenes_to_run(scenes, expectations=False)
    check_timesteps(bases, choice)
    _check_members(members, seed)
    ensembles = [(Ensemble(base.name, members, seed, _timestep(choice)), base) for base in bases]
    return _carried_out(ensembles, choice, where, out)


def member_text(scene: str, seed: int, number: int) -> str:
    """A member's scenario file."""
    _check_members(number + 1, seed)
    return member(one_scene(scene), seed, number).text


def _check_members(members: int, seed: int) -> None:
    if members > MAX_MEMBERS:
        raise Complaint(f"an ensemble has {MAX_MEMBERS} members at most, got {members}")
    if seed > MAX_SEED:
        raise Complaint(f"'--seed' must be less than 2^128, got {seed}")


def varied_text(scene: str, numbers: Sequence[str]) -> str:
    """The scenario file of a scene with other numbers.

    Parameters
    ----------
    numbers : as PATH=VALUE
    """
    base = one_scene(scene)
    values = dict(_number(text) for text in numbers)
    if len(values) < len(numbers):
        raise Complaint(f"takes each number once, got {', '.join(numbers)}")
    with as_complaint(VaryError, ScenarioError):
        for path in values:
            check_path(base, path)
        if TIMESTEP in values:
            raise VaryError("the timestep is no number of the scene; give it to 'spincheck run'")
        return varied(base, values).text


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


def exit_code(points: Iterable[PlacedRow]) -> int:
    """0 if every run came to an end of its own, 1 if one failed, 3 if all did."""
    outcomes = {point.outcome for point in points}
    if outcomes <= {"failed"}:
        return NOT_RUN
    return DISAGREES if "failed" in outcomes else AGREES


def _number(text: str) -> tuple[str, float]:
    path, _, value = text.partition("=")
    try:
        return path, float(value)
    except ValueError:
        raise Complaint(f"takes PATH=VALUE, VALUE a number, got '{text}'") from None


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
    sweeps: Sequence[tuple[Map | Ensemble, Scenario]], choice: Choice, where: Where, out: Path
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
                executor_for(where, choice) as executor,
                progress(total - complete, PROGRESS_LINES) as advance,
            ):
                for planned, base in left:
                    run_sweep(planned, base, store, executor, advance)
        for sweep, base in sweeps:
            points = points_of(sweep, store.points(base.name))
            pairs = {key.pair for key in choice.methods_on(base)}
            chosen = tuple(row for row in points if row.pair in pairs)
            results.append(SweepResult(sweep, base, chosen))
    return results
