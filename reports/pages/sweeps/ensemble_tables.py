"""An ensemble as tables: quantiles of the errors, and the members that went worst."""

import shlex
from collections.abc import Iterator, Sequence

from ...results.sweep_records import Ensemble, PlacedRow
from ..analysis.ensemble_numbers import OMEGA, QUANTILES, Members
from ..analysis.map_marks import is_coloured
from ..analysis.measures import Measure
from ..analysis.wording import NOTHING, limited, number
from ..tables import Cell, Table, figure, table
from .map_tables import percent

#: Number of worst members shown of each method.
WORST = 3


def quantile_table(members: Sequence[Members], measure: Measure) -> Table:
    """The quantiles of a measure, from the best member to the worst."""
    *shares, worst = QUANTILES
    if measure.more_is_better:
        worst = "fewest"
    return table(
        ("engine", "method", "members", "finished", *shares, worst),
        (list(_quantile_row(of_method, measure)) for of_method in members),
    )


def worst_table(ensemble: Ensemble, members: Sequence[Members]) -> Table:
    """The worst members of each method, with the commands that write them as scene files."""
    rows = (
        [Cell(engine, "name"), Cell(method, "name"), *_member(ensemble, point)]
        for of_method in members
        for engine, method in [of_method.pair]
        for point in of_method.worst(WORST)
    )
    return table(("engine", "method", "member", "ω error", "how it ended", "as a scene file"), rows)


def member_command(ensemble: Ensemble, number_of_member: int) -> str:
    """The shell command that writes a member as a scene file."""
    words = ["spincheck", "member", ensemble.scenario, "--member", str(number_of_member)]
    path = f"{ensemble.scenario}-{ensemble.seed}-{number_of_member}.toml"
    return f"{shlex.join([*words, '--seed', str(ensemble.seed)])} > {shlex.quote(path)}"


def _quantile_row(of_method: Members, measure: Measure) -> Iterator[Cell]:
    engine, method = of_method.pair
    run, finished = len(of_method.points), len(of_method.finished)
    yield Cell(engine, "name")
    yield Cell(method, "name")
    yield figure(str(run))
    yield figure(percent(finished, run) if run else NOTHING)
    for value in of_method.quantiles(measure) or (None,) * len(QUANTILES):
        yield figure(number(value))


def _member(ensemble: Ensemble, point: PlacedRow) -> Iterator[Cell]:
    member = int(point.at[0])
    yield figure(str(member))
    error = OMEGA.of(point) if point.errors else None
    yield figure(limited(error, point.reference_uncertainty))
    if is_coloured(point):
        yield Cell("finished")
    else:
        at = f" at {number(point.stopped_at)} s" if point.stopped_at is not None else ""
        yield Cell(f"{point.outcome}{at}", "", point.reason)
    yield Cell(member_command(ensemble, member), "command")
