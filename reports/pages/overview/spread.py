"""How errors at stock timesteps are distributed over starts and bodies: a curve an engine."""

import math
from collections.abc import Sequence
from typing import Any

from ....engines import Method
from ....reference.kinds import KINDS, kind_of
from ...results.records import Pair, Row
from ...results.results import Results
from ...results.sweep_records import Ensemble, SweepResult
from ..analysis.measures import ATTITUDE, QUANTILES, Members, members_of
from ..analysis.trace_style import TraceStyle, trace_styles
from ..analysis.wording import NOTHING, count, duration, readable
from ..figures.distribution import LOW, distribution
from ..figures.figures import Titled
from ..sweeps.sweep_pages import methods_of, numbered
from ..tables import Cell, figure, sweep_page, table


def spread(results: Results) -> dict[str, Any] | None:
    """The distributions at stock timesteps, a kind of motion each; None without any ensemble."""
    by_kind: dict[str, dict[str, SweepResult]] = {kind: {} for kind in KINDS}
    for name, one in numbered(results):
        if isinstance(one.sweep, Ensemble) and one.sweep.timestep is None:
            by_kind[kind_of(one.scenario)][name] = one
    every = [one for ensembles in by_kind.values() for one in ensembles.values()]
    declared = {pair: known for one in every for pair, known in methods_of(one, results).items()}
    styles = trace_styles(list(declared))
    kinds = [
        drawn
        for kind, ensembles in by_kind.items()
        if ensembles and (drawn := _of_kind(kind, ensembles, declared, styles))
    ]
    if not kinds:
        return None
    return {
        "heading": "Random starts and bodies of each kind of motion",
        "text": f"{ATTITUDE.title}, at stock timesteps; ∞: a run did not finish; {NOTHING}: p99 of "
        "fewer than 100 members, where it is the largest.",
        "kinds": kinds,
    }


def _of_kind(
    kind: str,
    ensembles: dict[str, SweepResult],
    declared: dict[Pair, Method | None],
    styles: dict[Pair, TraceStyle],
) -> dict[str, Any] | None:
    """The members of a kind: each engine's default and best method, the scenes and their pages."""
    # Two ensembles of a scene may have members in common.
    points = {
        (p.key.scenario, p.variation, p.pair): p for one in ensembles.values() for p in one.points
    }
    shown = _shown(list(points.values()), declared)
    if not any((one.errors(ATTITUDE) > 0).any() for one in shown):
        return None
    members = {(scene, place) for scene, place, _ in points}
    return {
        "kind": kind,
        "members": count(len(members)),
        "scenes": [(e.scenario.name, sweep_page("ensemble", n)) for n, e in ensembles.items()],
        "table": table(("", *QUANTILES), [_row(one) for one in shown]),
        "styles": [styles[one.pair] for one in shown],
        "figure": Titled(f"spread {kind}", "", "", [distribution(shown, styles, ATTITUDE, LOW)]),
    }


def _shown(points: Sequence[Row], declared: dict[Pair, Method | None]) -> list[Members]:
    """The members of each engine's first method as shipped, and of the best of the others."""
    chosen: dict[tuple[str, bool], Members] = {}
    members = members_of(points, declared)
    for one in sorted(members, key=_from_best):
        method = declared[one.pair]
        if one.points and (method is None or method.as_shipped or not method.reader):
            chosen.setdefault((one.pair[0], bool(method and method.as_shipped)), one)
    return sorted(chosen.values(), key=lambda one: list(declared).index(one.pair))


def _from_best(one: Members) -> tuple[float, float]:
    """The median and the largest, infinite without members."""
    median, *_, largest = one.quantiles(ATTITUDE) or (math.inf, math.inf)
    assert median is not None, "a median there always is"
    assert largest is not None, "a largest there always is"
    return median, largest


def _row(one: Members) -> list[Cell | str]:
    values = one.quantiles(ATTITUDE)
    assert values is not None, "only methods that were run are shown"
    steps = {point.timestep for point in one.points if point.timestep}
    label = f"{' '.join(one.pair)}, {duration(max(steps))}" if steps else " ".join(one.pair)
    return [Cell(label, "name"), *(figure(readable(value)) for value in values)]
