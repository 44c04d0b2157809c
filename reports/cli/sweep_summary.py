"""A sweep on the terminal: a line a method, the worst point, and the same as JSON."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..results.sweep_records import EnsembleResult, MapResult, PointResult, sweep_points
from .terminal import table

#: Of the ω errors of the runs that came to their end.
QUANTILES = {"median": 0.5, "90 %": 0.9, "99 %": 0.99}


def print_sweep(found: MapResult | EnsembleResult) -> None:
    """Print how each method fared, and where it was worst."""
    names = _names(found)
    print(f"{found.scenario.name}: {_asked(found)}")
    table([_line(method, points, names) for method, points in _by_method(found.points).items()])
    invalid = [point for point in found.points if point.outcome == "invalid"]
    if invalid:
        print(f"{len(invalid)} points are no scene; the first of them: {invalid[0].reason}")


def sweep_as_json(found: MapResult | EnsembleResult) -> dict[str, Any]:
    """What was asked for, and its points, with the names that scripts rely on."""
    asked = found.map if isinstance(found, MapResult) else found.ensemble
    names = _names(found)
    return asdict(asked) | {"points": [point_record(point, names) for point in found.points]}


def point_record(point: PointResult, names: Sequence[str]) -> dict[str, Any]:
    """A point with the names that scripts rely on.

    Parameters
    ----------
    names : of what it is at
    """
    errors = point.errors
    return {
        "at": dict(zip(names, point.at, strict=True)),
        **asdict(point.key),
        "timestep": point.timestep,
        "outcome": point.outcome,
        "cause": point.cause,
        "reason": point.reason,
        "stopped_at": point.stopped_at,
        "omega_error": errors.omega if errors else None,
        "attitude_error": errors.attitude if errors else None,
        "angular_momentum_error": errors.angular_momentum if errors else None,
        "energy_error": errors.energy if errors else None,
        "reference_uncertainty": point.uncertainty,
        "steps": point.steps,
    }


def _names(found: MapResult | EnsembleResult) -> list[str]:
    return [axis.path for axis in found.map.axes] if isinstance(found, MapResult) else ["member"]


def _asked(found: MapResult | EnsembleResult) -> str:
    if isinstance(found, EnsembleResult):
        return f"{found.ensemble.members} members of seed {found.ensemble.seed}"
    total = sum(1 for _ in sweep_points(found.map))
    axes = ", ".join(f"{a.path} {a.values[0]:g} to {a.values[-1]:g}" for a in found.map.axes)
    return f"{total} points, {axes}"


def _by_method(points: Iterable[PointResult]) -> dict[str, list[PointResult]]:
    found: dict[str, list[PointResult]] = {}
    for point in points:
        if point.outcome != "invalid":
            found.setdefault(f"{point.key.engine} {point.key.method}", []).append(point)
    return dict(sorted(found.items()))


def _line(method: str, points: Sequence[PointResult], names: Sequence[str]) -> dict[str, object]:
    outcomes = Counter(point.outcome for point in points)
    ended = [(p.errors.omega, p) for p in points if p.errors is not None and p.outcome == "ok"]
    ended.sort(key=lambda pair: pair[0])
    errors = [error for error, _ in ended]
    worst = ended[-1] if ended else None
    causes = Counter(point.cause for point in points if point.cause)
    return {
        "method": method,
        **{name: outcomes[name] for name in ("ok", "diverged", "unsupported", "failed", "skipped")},
        "why": ", ".join(f"{cause} {count}" for cause, count in causes.most_common()),
        **{f"ω error, {name}": _quantile(errors, share) for name, share in QUANTILES.items()},
        "worst": worst[0] if worst else None,
        "worst at": _place(worst[1], names) if worst else "",
    }


def _quantile(ascending: Sequence[float], share: float) -> float | None:
    """The least value that this share of them do not exceed: one that occurred, be others inf."""
    if not ascending:
        return None
    return float(np.quantile(ascending, share, method="inverted_cdf"))


def _place(point: PointResult, names: Sequence[str]) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in zip(names, point.at, strict=True))


def flat_records(found: MapResult | EnsembleResult) -> list[dict[str, Any]]:
    """Points for a table: one column for what they are at, as JSON, for sweeps have it differ."""
    asked = f"seed {found.ensemble.seed}" if isinstance(found, EnsembleResult) else "map"
    names = _names(found)
    records = [point_record(point, names) for point in found.points]
    return [{"sweep": asked, **record, "at": json.dumps(record["at"])} for record in records]
