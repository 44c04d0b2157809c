"""A map's points as grids, method by method, with the scene at every one of them."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ....engines import Method
from ....reference.stability_bounds import StabilityNumbers, stability_numbers
from ....scenarios import FloatArray
from ....scenarios.errors import ScenarioError
from ....scenarios.vary import TIMESTEP, Axis, varied
from ...results.records import Pair, Row
from ...results.sweep_records import Map, SweepResult

#: Units of a scene file's numbers, by the last key of their paths.
UNITS = {
    "mass": "kg",
    "inertia": "kg m²",
    "com": "m",
    "particles": "kg, m",
    "euler_zyz_deg": "deg",
    "rotation_vector_deg": "deg",
    "omega_body": "rad/s",
    "omega_world": "rad/s",
    "euler_zyz_rates": "rad/s",
    "position": "m",
    "velocity": "m/s",
    "acceleration": "m/s²",
    "rotational": "N m s",
    "body": "N m",
    "world": "N m",
    "duration": "s",
    TIMESTEP: "s",
}

#: A point's indices in the grid: row, that of the second axis, and column.
Node = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Grid:
    """A map, sorted.

    Attributes
    ----------
    result : the map as stored; the first axis runs across, the second up
    methods : what adapters declared of those that were run, in reading order; None where unknown
    stock_timesteps : of their engines that have one, s
    """

    result: SweepResult
    methods: dict[Pair, Method | None]
    stock_timesteps: dict[str, float] = field(default_factory=dict)

    @property
    def axes(self) -> tuple[Axis, Axis]:
        """Across, and up."""
        assert isinstance(self.result.sweep, Map), "an ensemble has no axes"
        return self.result.sweep.axes

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        across, up = self.axes
        return len(up.values), len(across.values)

    @cached_property
    def points(self) -> dict[Pair, dict[Node, Row]]:
        """The points by method and grid point."""
        across, up = ({value: k for k, value in enumerate(axis.values)} for axis in self.axes)
        by_method: dict[Pair, dict[Node, Row]] = {pair: {} for pair in self.methods}
        for point in self.result.points:
            first, second = self.result.at(point)
            by_method[point.pair][up[second], across[first]] = point
        return by_method

    @cached_property
    def numbers(self) -> dict[Node, StabilityNumbers]:
        """Rates and limits that theory gives for the scene, at each grid point that has one."""
        across, up = self.axes
        by_scene: dict[tuple[float, ...], StabilityNumbers | None] = {}
        by_node = {}
        for row, second in enumerate(up.values):
            for column, first in enumerate(across.values):
                at = {across.path: first, up.path: second}
                of_scene = {path: value for path, value in at.items() if path != TIMESTEP}
                same = tuple(of_scene.values())
                if same not in by_scene:
                    by_scene[same] = self._numbers(of_scene)
                if (numbers := by_scene[same]) is not None:
                    by_node[row, column] = numbers
        return by_node

    def _numbers(self, of_scene: dict[str, float]) -> StabilityNumbers | None:
        try:
            return stability_numbers(varied(self.result.scenario, of_scene))
        except ScenarioError:
            return None

    @cached_property
    def timesteps(self) -> FloatArray:
        """s, at each grid point; NaN where no method was run."""
        chosen = np.full(self.shape, math.nan)
        for of_method in self.points.values():
            for node, point in of_method.items():
                chosen[node] = point.timestep or math.nan
        return chosen

    def is_cut(self, point: Row) -> bool:
        """Whether a run ended before the window, where the exact motion is no longer known."""
        across, up = self.axes
        first, second = self.result.at(point)
        node = up.values.index(second), across.values.index(first)
        if point.errors is None or node not in self.numbers:
            return False
        # The last sample is at the whole step nearest to the end.
        return self.numbers[node].duration - point.steps * point.timestep > point.timestep

    def evaluated(self, value: Callable[[StabilityNumbers, float], float]) -> FloatArray:
        """A function of the numbers and the timestep at each grid point, (rows, columns)."""
        values = np.full(self.shape, math.nan)
        for node, numbers in self.numbers.items():
            values[node] = value(numbers, float(self.timesteps[node]))
        return values


def axis_title(axis: Axis) -> str:
    """The path with its unit, as in `start.omega_body[2], rad/s`."""
    return f"{axis.path}, {unit}" if (unit := _unit(axis)) else axis.path


def with_unit(axis: Axis, value: float) -> str:
    """One of its values, as in `40 rad/s`."""
    return f"{value:.4g} {_unit(axis)}".rstrip()


def _unit(axis: Axis) -> str:
    return UNITS.get(axis.path.rpartition(".")[2].partition("[")[0], "")


def places(axis: Axis) -> FloatArray:
    """Where an axis's values are drawn."""
    return np.array([place_of(axis, value) for value in axis.values])


def place_of(axis: Axis, value: float) -> float:
    """Where a value is drawn: at its logarithm to base 10 if the axis is logarithmic."""
    return math.log10(value) if axis.logarithmic else value
