"""The page of a map: what was varied, how to do it again, the figure and its tables."""

import shlex
from collections import Counter
from dataclasses import dataclass

from ...engines import Method
from ...scenarios.vary import Axis
from ..results.records import Pair
from ..results.store import Results
from ..results.sweep_records import MapResult, PointResult
from .analysis.map_grid import Grid, axis_title
from .figures.figures import Titled
from .figures.map_figure import map_figure
from .links import map_page
from .map_tables import bounds_table, ends_table, survival_table
from .tables import Table

#: Digits of a range's ends in a command: those that were typed, and none that rounding added.
TYPED_DIGITS = 12

CAPTION = (
    "Every cell is one run against the exact motion of its own scene. Colour: the largest error of "
    "ω, relative; signs on the bare page: runs that did not finish, or were not made. Lines are "
    "drawn by theory, from the scene at t = 0 alone, and told below."
)


@dataclass(frozen=True, eq=False)
class MapPage:
    """Everything that the HTML page and the Markdown file of a map show.

    Attributes
    ----------
    name : unique in a report; `link` leads to it from the overview
    """

    name: str
    link: str
    title: str
    scene: str
    scene_title: str
    command: str
    timestep: str
    figure: Titled
    survival: Table
    ends: Table
    bounds: Table


def map_pages(results: Results) -> list[MapPage]:
    """One a map that has any points."""
    seen: Counter[str] = Counter()
    pages = []
    for result in results.maps:
        if any(point.key.engine for point in result.points):
            seen[result.map.scenario] += 1
            name = f"{result.map.scenario}-{seen[result.map.scenario]}"
            methods = methods_of(result.points, results)
            pages.append(_page(name, Grid(result, methods, results.stock_timesteps)))
    return pages


def methods_of(points: tuple[PointResult, ...], results: Results) -> dict[Pair, Method | None]:
    """Those that were run, engines by name, their methods as the adapter lists them."""
    pairs = {(point.key.engine, point.key.method) for point in points if point.key.engine}
    listed = {pair: rank for rank, pair in enumerate(results.methods)}
    ordered = sorted(pairs, key=lambda p: (p[0], listed.get(p, len(listed)), p[1]))
    return {pair: results.methods.get(pair) for pair in ordered}


def _page(name: str, grid: Grid) -> MapPage:
    result = grid.result
    across, up = (axis_title(axis) for axis in result.map.axes)
    return MapPage(
        name=name,
        link=map_page(name),
        title=f"{result.map.scenario}: {result.map.axes[0].path} × {result.map.axes[1].path}",
        scene=result.map.scenario,
        scene_title=result.scenario.title,
        command=command(result),
        timestep=timestep_in_words(result.map.timestep, result.map.axes),
        figure=Titled("map", f"{up} against {across}", CAPTION, map_figure(grid)),
        survival=survival_table(grid),
        ends=ends_table(result.points, grid.methods),
        bounds=bounds_table(grid),
    )


def command(result: MapResult) -> str:
    """What makes this map, as typed in a shell."""
    words = ["spincheck", "map", result.map.scenario]
    for axis in result.map.axes:
        words += ["--vary", vary_option(axis)]
    if result.map.timestep is not None:
        words += ["--timestep", f"{result.map.timestep:.{TYPED_DIGITS}g}"]
    return shlex.join(words)


def vary_option(axis: Axis) -> str:
    """An axis as `PATH=LO:HI:COUNT[:log]`."""
    low, high = (f"{value:.{TYPED_DIGITS}g}" for value in (axis.values[0], axis.values[-1]))
    spacing = ":log" if axis.logarithmic else ""
    return f"{axis.path}={low}:{high}:{len(axis.values)}{spacing}"


def timestep_in_words(timestep: float | None, axes: tuple[Axis, ...] = ()) -> str:
    """Which timestep the runs take, where it is not an axis."""
    if any(axis.path == "timestep" for axis in axes):
        return ""
    if timestep is None:
        return "Timesteps are chosen run by run, so that the body turns equally far in a step."
    return f"Every run takes steps of {timestep:g} s."
