"""A sweep on the terminal: a line a method, the worst point, and the same as JSON."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from ...pages.analysis.measures import A_TURN, ATTITUDE, QUANTILES, TURNS, Members
from ...results.as_json import as_json
from ...results.sweep_records import Ensemble, PlacedRow, SweepResult
from ..terminal import table


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
    """Points as flat records: their coordinates are one column of JSON, as they differ by sweep."""
    sweep = swept.sweep
    kind = f"seed {sweep.seed}" if isinstance(sweep, Ensemble) else sweep.kind
    records = [point_record(point, sweep.names) for point in swept.points]
    return [{"sweep": kind, "at": json.dumps(one.pop("at")), **one} for one in records]
