"""A map or an ensemble as tables: survival, how runs ended, quantiles, the worst members."""

import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from statistics import median_high

from ...results.records import Pair, Row
from ...results.sweep_records import Ensemble
from ..analysis.map_grid import Grid
from ..analysis.measures import OMEGA, QUANTILES, Measure, Members, is_coloured, marks
from ..analysis.wording import NOTHING, ended, limited, number
from ..figures.map_figure import legend_of_bounds
from ..tables import Cell, Table, figure, named, records, table

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
        [*named(of_method.pair).values(), *_member(ensemble, point)]
        for of_method in members
        for point in of_method.worst(WORST)
    )
    return table(("engine", "method", "member", "ω error", "how it ended", "as a scene file"), rows)


def member_command(ensemble: Ensemble, number_of_member: int) -> str:
    """The shell command that writes a member as a scene file."""
    words = ["spincheck", "show", ensemble.scenario, "--toml", "--member", str(number_of_member)]
    path = f"{ensemble.scenario}-{ensemble.seed}-{number_of_member}.toml"
    return f"{shlex.join([*words, '--seed', str(ensemble.seed)])} > {shlex.quote(path)}"


def _quantile_row(of_method: Members, measure: Measure) -> Iterator[Cell]:
    run, finished = len(of_method.points), len(of_method.finished)
    yield from named(of_method.pair).values()
    yield figure(str(run))
    yield figure(percent(finished, run) if run else NOTHING)
    for value in of_method.quantiles(measure) or (None,) * len(QUANTILES):
        yield figure(number(value))


def _member(ensemble: Ensemble, point: Row) -> Iterator[Cell]:
    member = int(point.varied["member"])
    yield figure(str(member))
    error = OMEGA.of(point) if point.errors else None
    yield figure(limited(error, point.reference_uncertainty))
    if is_coloured(point):
        yield Cell("finished")
    else:
        yield Cell(ended(point), "", point.reason)
    yield Cell(member_command(ensemble, member), "command")


#: rad a step, limits of the columns: half decades around the turn that a method can resolve.
TURNS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)


def survival_table(grid: Grid) -> Table:
    """Percentage of the runs that finished, by the angle that ω(0) turns the body in a step."""
    return _by_turn(grid, lambda runs: percent(sum(map(is_coloured, runs)), len(runs)))


def medians_table(grid: Grid, measure: Measure) -> Table:
    """The median of a measure, likewise."""

    def middle(points: list[Row]) -> str:
        values = [value for point in points if (value := measure.of(point)) is not None]
        return number(median_high(values)) if values else NOTHING

    return _by_turn(grid, middle)


def ends_table(points: Iterable[Row], pairs: Iterable[Pair]) -> Table:
    """How many runs of each method finished, and how many ended in each other way."""
    points = list(points)
    marks_by_end = marks(points)
    counts: dict[Pair, Counter[str]] = {pair: Counter() for pair in pairs}
    for point in points:
        mark = None if is_coloured(point) else marks_by_end[point.outcome, point.cause]
        counts[point.pair][mark.label if mark else "finished"] += 1
    labels = ["finished", *dict.fromkeys(mark.label for mark in marks_by_end.values())]
    return records(
        named(pair) | {label: _count(counts[pair][label]) for label in labels} for pair in counts
    )


def bounds_table(grid: Grid) -> Table:
    """Table of the lines: meaning, and source."""
    rows = ((Cell(b.label, "name"), b.meaning, b.source) for b in legend_of_bounds(grid))
    return table(("line", "what it says", "source"), rows)


def _count(amount: int) -> Cell:
    return Cell(str(amount), "number" if amount else "number none")


def _by_turn(grid: Grid, said: Callable[[list[Row]], str]) -> Table:
    """What is said of the runs of each method in each range of turns that has any."""
    by_turn = {pair: _runs_by_turn(grid, pair) for pair in grid.methods}
    shown = [k for k in range(len(TURNS) + 1) if any(by_turn[pair][k] for pair in by_turn)]
    return records(
        named(pair) | {_range(k): figure(said(runs[k]) if runs[k] else NOTHING) for k in shown}
        for pair, runs in by_turn.items()
    )


def _runs_by_turn(grid: Grid, pair: Pair) -> list[list[Row]]:
    by_turn: list[list[Row]] = [[] for _ in range(len(TURNS) + 1)]
    for node, point in grid.points[pair].items():
        if point.simulated and node in grid.numbers:
            turn = grid.numbers[node].turning * point.timestep
            by_turn[sum(turn > limit for limit in TURNS)].append(point)
    return by_turn


def _range(k: int) -> str:
    if k == 0:
        return f"up to {TURNS[0]:g} rad"
    if k == len(TURNS):
        return f"over {TURNS[-1]:g} rad"
    return f"{TURNS[k - 1]:g} to {TURNS[k]:g} rad"


def percent(part: int, whole: int) -> str:
    """`97 %`; 0 and 100 are printed only for none and all."""
    rounded = round(100 * part / whole)
    if part and not rounded:
        return "< 1 %"
    if part < whole and rounded == 100:
        return "> 99 %"
    return f"{rounded} %"
