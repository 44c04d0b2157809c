"""Distributions of errors at stock timesteps over random starts and bodies, from ensembles."""

import math
from collections.abc import Sequence
from typing import Any

from ....engines import Method
from ....reference.kinds import KINDS, kind_of
from ...results.ensemble_records import EnsembleResult
from ...results.records import Pair, Row
from ...results.results import Results
from ..analysis.measures import ATTITUDE, QUANTILES, Members, members_of
from ..analysis.trace_style import TraceStyle, trace_styles
from ..analysis.wording import NOTHING, count, duration, readable
from ..figures.distribution import distribution
from ..figures.figures import Titled
from ..tables import Cell, figure, scene_page, table


def spread(results: Results) -> dict[str, Any] | None:
    """Return the distributions of errors at stock timesteps; None if there are none.

    The dictionary has a `heading`, a `text` on what is shown, and `kinds`: for each kind of motion
    that an ensemble was run on, what `_of_kind` returns, and the names and pages of its `scenes`.
    """
    ensembles = [one for one in results.ensembles if one.points and one.ensemble.timestep is None]
    declared = _declared([point for one in ensembles for point in one.points], results)
    styles = trace_styles(list(declared))
    kinds = []
    for kind in KINDS:
        of_kind = [one for one in ensembles if kind_of(one.scenario) == kind]
        if of_kind and (drawn := _of_kind(kind, of_kind, declared, styles)):
            pages = {one.scenario.name: scene_page(one.scenario.name) for one in of_kind}
            drawn["scenes"] = [(n, p if n in results.scenes else "") for n, p in pages.items()]
            kinds.append(drawn)
    if not kinds:
        return None
    return {
        "heading": "Random starts and bodies of each kind of motion",
        "text": f"{ATTITUDE.title}, at stock timesteps; ∞: a run did not finish; {NOTHING}: p99 of "
        "fewer than 100 members, where it is the largest.",
        "kinds": kinds,
    }


def _declared(points: Sequence[Row], results: Results) -> dict[Pair, Method | None]:
    """Return, for each method that was run, what its adapter declared; None if that is not stored.

    Methods are sorted by engine, and within an engine as the adapter lists them.

    Parameters
    ----------
    points : the runs on the members of ensembles
    """
    listed = {pair: rank for rank, pair in enumerate(results.methods)}
    pairs = {point.pair for point in points}
    ordered = sorted(pairs, key=lambda p: (p[0], listed.get(p, len(listed)), p[1]))
    return {pair: results.methods.get(pair) for pair in ordered}


def _of_kind(
    kind: str,
    ensembles: list[EnsembleResult],
    declared: dict[Pair, Method | None],
    styles: dict[Pair, TraceStyle],
) -> dict[str, Any] | None:
    """Return the figure and table for one kind of motion; None if no error exceeds 0.

    They show the best method as shipped and the best clean method of each engine. The entries are
    `kind`, the number of `members` as text, `table`, `figure`, and `styles`, one for each row.

    Parameters
    ----------
    kind : the kind of motion
    ensembles : the ensembles of that kind
    declared : what the adapters declared about the methods
    styles : how the methods are drawn
    """
    # Two ensembles of the same scene may have members in common.
    points = {(p.key.scenario, p.variation, p.pair): p for one in ensembles for p in one.points}
    shown = _shown(list(points.values()), declared)
    if not any((one.errors(ATTITUDE) > 0).any() for one in shown):
        return None
    members = {(scene, place) for scene, place, _ in points}
    return {
        "kind": kind,
        "members": count(len(members)),
        "table": table(("", *QUANTILES), [_row(one) for one in shown]),
        "styles": [styles[one.pair] for one in shown],
        "figure": Titled(f"spread {kind}", "", "", [distribution(shown, styles, ATTITUDE)]),
    }


def _shown(points: Sequence[Row], declared: dict[Pair, Method | None]) -> list[Members]:
    """Return the runs of each engine's best method as shipped, and of its best clean method.

    The best method has the least median error. Clean methods that differ from others only in how
    they read models are left out.

    Parameters
    ----------
    points : runs on the members of ensembles
    declared : what the adapters declared about the methods, from `_declared`
    """
    chosen: dict[tuple[str, bool], Members] = {}
    members = members_of(points, declared)
    for one in sorted(members, key=_from_best):
        method = declared[one.pair]
        if one.points and (method is None or method.as_shipped or not method.reader):
            chosen.setdefault((one.pair[0], bool(method and method.as_shipped)), one)
    return sorted(chosen.values(), key=lambda one: list(declared).index(one.pair))


def _from_best(one: Members) -> tuple[float, float]:
    """Return a sort key: the median and the largest error; both are infinite if nothing was run."""
    median, *_, largest = one.quantiles(ATTITUDE) or (math.inf, math.inf)
    assert median is not None, "a median there always is"
    assert largest is not None, "a largest there always is"
    return median, largest


def _row(one: Members) -> list[Cell | str]:
    """Return a method's quantiles of attitude errors as a row of a table."""
    values = one.quantiles(ATTITUDE)
    assert values is not None, "only methods that were run are shown"
    steps = {point.timestep for point in one.points if point.timestep}
    label = f"{' '.join(one.pair)}, {duration(max(steps))}" if steps else " ".join(one.pair)
    return [Cell(label, "name"), *(figure(readable(value)) for value in values)]
