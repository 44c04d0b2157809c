"""A sweep on the terminal: a line a method, the worst point, and the same as JSON."""

import json
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ....scenarios import SIGNAL
from ...pages.analysis.ensemble_numbers import QUANTILES
from ...results.as_json import as_json
from ...results.sweep_records import Ensemble, EnsembleResult, Map, MapResult, PointResult
from ..terminal import table


def print_sweep(sweep: MapResult | EnsembleResult) -> None:
    """Print one line for each method, and its worst point."""
    names = sweep.sweep.names
    print(f"{sweep.scenario.name}: {_sweep_in_words(sweep.sweep)}")
    table([_line(method, points, names) for method, points in _by_method(sweep.points).items()])
    invalid = [point for point in sweep.points if point.outcome == "invalid"]
    if invalid:
        print(f"{len(invalid)} points are no scene; the first of them: {invalid[0].reason}")


def sweep_as_json(sweep: MapResult | EnsembleResult) -> dict[str, Any]:
    """What was asked for, and its points, with the names that scripts rely on."""
    names = sweep.sweep.names
    return asdict(sweep.sweep) | {"points": [point_record(point, names) for point in sweep.points]}


def point_record(point: PointResult, names: Sequence[str]) -> dict[str, Any]:
    """A point with the names that scripts rely on.

    Parameters
    ----------
    names : of the numbers that are varied
    """
    record = as_json(point)
    del record["place"]
    return record | {"at": dict(zip(names, point.at, strict=True))}


def _sweep_in_words(sweep: Map | Ensemble) -> str:
    if isinstance(sweep, Ensemble):
        return f"{sweep.members} members of seed {sweep.seed}"
    axes = ", ".join(f"{a.path} {a.values[0]:g} to {a.values[-1]:g}" for a in sweep.axes)
    return f"{len(sweep)} points, {axes}"


def _by_method(points: Iterable[PointResult]) -> dict[str, list[PointResult]]:
    by_method: dict[str, list[PointResult]] = {}
    for point in points:
        if point.outcome != "invalid":
            by_method.setdefault(f"{point.key.engine} {point.key.method}", []).append(point)
    return dict(sorted(by_method.items()))


def _line(method: str, points: Sequence[PointResult], names: Sequence[str]) -> dict[str, object]:
    outcomes = Counter(point.outcome for point in points)
    causes = Counter(point.cause for point in points if point.cause)
    run = [(_attitude(p), p) for p in points if p.outcome in ("ok", "diverged", "failed")]
    run.sort(key=lambda pair: pair[0])
    errors = [error for error, _ in run]
    return {
        "method": method,
        "ended": ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common()),
        "why": ", ".join(f"{cause} {count}" for cause, count in causes.most_common()),
        **{f"off by, °: {name}": _quantile(errors, share) for name, share in QUANTILES.items()},
        "worst at": _place(run[-1][1], names) if run else "",
    }


def _attitude(point: PointResult) -> float:
    """The error in degrees; infinite of a run that did not finish."""
    if point.outcome != "ok" or point.errors is None:
        return math.inf
    return point.errors.attitude * SIGNAL["attitude"].shown


def _quantile(ascending: Sequence[float], share: float) -> float | None:
    """The smallest of the values that this fraction of them does not exceed; values may be inf."""
    if not ascending:
        return None
    return float(np.quantile(ascending, share, method="inverted_cdf"))


def _place(point: PointResult, names: Sequence[str]) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in zip(names, point.at, strict=True))


def flat_records(sweep: MapResult | EnsembleResult) -> list[dict[str, Any]]:
    """Points as flat records: their coordinates are one column of JSON, as they differ by sweep."""
    kind = "map" if isinstance(sweep.sweep, Map) else f"seed {sweep.sweep.seed}"
    names = sweep.sweep.names
    records = [point_record(point, names) for point in sweep.points]
    return [{"sweep": kind, **record, "at": json.dumps(record["at"])} for record in records]
