"""What a sweep is: a scene run at many points, on a grid of two numbers or at random."""

import math
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Field

from ...scenarios import Scenario, loads
from ...scenarios.vary import MAX_COUNT, TIMESTEP, Axis, check_path
from .records import Record, Row, SceneName

#: A month on one core.
MAX_MEMBERS = 1_000_000
#: As many bits as numpy asks of a seed (`numpy.random.SeedSequence`).
MAX_SEED = (1 << 128) - 1


@dataclass(frozen=True)
class SweepPoint:
    """One scene and timestep of a sweep.

    Attributes
    ----------
    numbers : what is varied, by path, in the order of the axes; none for a member
    member : seed and number; None of a map
    timestep : s; None if it is chosen from the scene at the point, or is each engine's stock one
    """

    numbers: tuple[tuple[str, float], ...] = ()
    member: tuple[int, int] | None = None
    timestep: float | None = None

    @property
    def varied(self) -> dict[str, float]:
        """Scene and timestep, which identify the point, whichever sweep it belongs to."""
        parts: dict[str, float] = dict(self.numbers)
        if self.member is not None:
            parts["seed"], parts["member"] = self.member
        if self.timestep is not None:
            parts[TIMESTEP] = self.timestep
        return parts

    def __str__(self) -> str:
        """The sweep in words."""
        parts = [f"{path} {value:.6g}" for path, value in self.numbers]
        if self.member is not None:
            parts.append(f"member {self.member[1]}")
        if self.timestep is not None:
            parts.append(f"timestep {self.timestep:.6g}")
        return ", ".join(parts)


def _two_axes(axes: tuple[Axis, Axis]) -> tuple[Axis, Axis]:
    """The axes of a map, as `parse_axis` makes them."""
    for axis in axes:
        values, positive = axis.values, axis.logarithmic or axis.path == TIMESTEP
        if not 2 <= len(values) <= MAX_COUNT:
            raise ValueError(f"{axis.path}: {len(values)} values")
        is_finite = -math.inf < values[0] <= values[-1] < math.inf
        if not (is_finite and all(a < b for a, b in pairwise(values))):
            raise ValueError(f"{axis.path}: its values do not increase")
        if positive and values[0] <= 0:
            raise ValueError(f"{axis.path}: {values[0]:g} is not positive")
    if axes[0].path == axes[1].path:
        raise ValueError(f"{axes[0].path}: varied twice")
    return axes


_Timestep = Annotated[float, Field(gt=0, lt=math.inf)]


@dataclass(frozen=True)
class Map:
    """Every pair of the values of two numbers.

    Attributes
    ----------
    scenario : the scene's name
    timestep : s, of every run; None where it is an axis or chosen point by point, so that the
        body turns equally far a step
    """

    kind: ClassVar = "map"
    scenario: SceneName
    axes: Annotated[tuple[Axis, Axis], AfterValidator(_two_axes)]
    timestep: _Timestep | None

    @property
    def names(self) -> list[str]:
        """The paths of the axes."""
        return [axis.path for axis in self.axes]

    def __len__(self) -> int:
        """How many points there are."""
        return len(self.axes[0].values) * len(self.axes[1].values)

    def points(self) -> Iterator[SweepPoint]:
        """All points; the second axis varies fastest."""
        return map(self._at, product(*(axis.values for axis in self.axes)))

    def point(self, parts: Mapping[str, Any]) -> SweepPoint | None:
        """The point that has an identity, parsed; None if there is none."""
        at: tuple[Any, ...] = tuple(parts.get(path) for path in self.names)
        if not all(_is_on(axis, value) for value, axis in zip(at, self.axes, strict=True)):
            return None
        point = self._at(at)
        return point if point.varied == parts else None

    def check(self, scenario: Scenario) -> None:
        """Check that the scene has both numbers; raises a ValueError that names the path."""
        for path in self.names:
            check_path(scenario, path)

    def __str__(self) -> str:
        """Its size and its axes, in words."""
        axes = ", ".join(f"{a.path} {a.values[0]:g} to {a.values[-1]:g}" for a in self.axes)
        return f"{len(self)} points, {axes}"

    def _at(self, at: tuple[float, ...]) -> SweepPoint:
        numbers = dict(zip(self.names, at, strict=True))
        timestep = numbers.pop(TIMESTEP, self.timestep)
        return SweepPoint(tuple(numbers.items()), None, timestep)


@dataclass(frozen=True)
class Ensemble:
    """Scattered starts and bodies; a member does not depend on how many there are.

    Attributes
    ----------
    scenario : the scene's name
    timestep : s, of every run; None for each engine's stock timestep
    """

    kind: ClassVar = "ensemble"
    scenario: SceneName
    members: Annotated[int, Field(gt=0, le=MAX_MEMBERS)]
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)]
    timestep: _Timestep | None

    @property
    def names(self) -> list[str]:
        """A member has a number only."""
        return ["member"]

    def __len__(self) -> int:
        """How many members there are."""
        return self.members

    def points(self) -> Iterator[SweepPoint]:
        """All members."""
        return map(self._member, range(self.members))

    def point(self, parts: Mapping[str, Any]) -> SweepPoint | None:
        """The point that has an identity, parsed; None if there is none."""
        number = parts.get("member")
        if type(number) is not int or not 0 <= number < self.members:
            return None
        point = self._member(number)
        return point if point.varied == parts else None

    def check(self, scenario: Scenario) -> None:
        """Nothing to do: every scene can be scattered."""

    def __str__(self) -> str:
        """Its size and its seed, in words."""
        return f"{self.members} members of seed {self.seed}"

    def _member(self, number: int) -> SweepPoint:
        return SweepPoint((), (self.seed, number), self.timestep)


def _is_on(axis: Axis, value: object) -> bool:
    if not isinstance(value, float | int):
        return False
    at = bisect_left(axis.values, value)
    return at < len(axis.values) and axis.values[at] == value


@dataclass(frozen=True)
class DefinedSweep(Record):
    """A sweep that was asked for, and the file of the scene that is varied."""

    scenario: SceneName
    sweep: Map | Ensemble
    toml: str

    def varied(self) -> Scenario:
        """The scene that is varied.

        Raises
        ------
        ValueError
            If it is none, or cannot be swept so.
        """
        if self.sweep.scenario != self.scenario:
            raise ValueError(f"a sweep of '{self.sweep.scenario}' under '{self.scenario}'")
        scenario = loads(self.toml, self.scenario)
        self.sweep.check(scenario)
        return scenario


@dataclass(frozen=True, eq=False)
class SweepResult:
    """A sweep with the scene that is varied, and its stored points, in the order of the axes."""

    sweep: Map | Ensemble
    scenario: Scenario
    points: tuple[Row, ...]

    def at(self, point: Row) -> tuple[float, ...]:
        """Return a point's values in the order of the axes; of an ensemble the member's number."""
        return place(self.sweep, point)


def place(sweep: Map | Ensemble, point: Row) -> tuple[float, ...]:
    """As `SweepResult.at`."""
    return tuple(map(point.varied.__getitem__, sweep.names))


def swept(stored: Iterable[DefinedSweep], points: Iterable[Row]) -> list[SweepResult]:
    """The sweeps with their points.

    Raises
    ------
    ValueError
        If a definition is none.
    """
    of_scene: dict[str, list[Row]] = defaultdict(list)
    for row in points:
        of_scene[row.key.scenario].append(row)
    return [
        SweepResult(one.sweep, one.varied(), points_of(one.sweep, of_scene[one.scenario]))
        for one in stored
    ]


def points_of(sweep: Map | Ensemble, stored: Iterable[Row]) -> tuple[Row, ...]:
    """The points of a sweep among those of its scene, in its order.

    It loops over the stored points, not over all of the sweep: few may have been run.
    """
    found = [row for row in stored if sweep.point(row.varied) is not None]
    return tuple(sorted(found, key=lambda row: (place(sweep, row), row.pair)))
