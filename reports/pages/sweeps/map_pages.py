"""The page of a map: definition, command, figure and tables."""

import shlex
from dataclasses import dataclass

from ....scenarios.vary import Axis
from ...results.store import Results
from ...results.sweep_records import MapResult
from ..analysis.map_grid import Grid, axis_title
from ..figures.figures import Titled
from ..figures.map_figure import map_figure
from ..links import map_page
from ..tables import Table
from .map_tables import bounds_table, ends_table, survival_table
from .sweep_pages import (
    method_options,
    methods_of,
    numbered,
    timestep_in_words,
    timestep_option,
    typed,
)

CAPTION = (
    "Every cell is one run against the exact motion of its own scene. Colour: the largest error of "
    "ω, relative; signs on the bare page: runs that did not finish, or were not made. Lines are "
    "drawn by theory, from the scene at t = 0 alone, and explained below."
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
    """A page for each map that has any points."""
    return [
        _page(
            name, Grid(result, methods, results.stock_timesteps), method_options(methods, results)
        )
        for name, result in numbered(results.maps)
        for methods in [methods_of(result.points, results)]
    ]


def _page(name: str, grid: Grid, options: list[str]) -> MapPage:
    result = grid.result
    across, up = (axis_title(axis) for axis in result.sweep.axes)
    return MapPage(
        name=name,
        link=map_page(name),
        title=f"{result.sweep.scenario}: {result.sweep.axes[0].path} × {result.sweep.axes[1].path}",
        scene=result.sweep.scenario,
        scene_title=result.scenario.title,
        command=command(result, options),
        timestep=timestep_in_words(result.sweep.timestep, result.sweep.axes),
        figure=Titled("map", f"{up} against {across}", CAPTION, map_figure(grid)),
        survival=survival_table(grid),
        ends=ends_table(result.points, grid.methods),
        bounds=bounds_table(grid),
    )


def command(result: MapResult, methods: list[str]) -> str:
    """The shell command that makes this map, with the options that name its methods."""
    words = ["spincheck", "map", result.sweep.scenario]
    for axis in result.sweep.axes:
        words += ["--vary", vary_option(axis)]
    return shlex.join([*words, *timestep_option(result.sweep.timestep), *methods])


def vary_option(axis: Axis) -> str:
    """An axis as `PATH=LO:HI:COUNT[:log]`."""
    low, high = typed(axis.values[0]), typed(axis.values[-1])
    spacing = ":log" if axis.logarithmic else ""
    return f"{axis.path}={low}:{high}:{len(axis.values)}{spacing}"
