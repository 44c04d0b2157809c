"""What a sweep is: a scene run at many points, on a grid of two numbers or at random."""

import json
from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

from ...engines import Outcome
from ...scenarios import Errors, Scenario
from ...scenarios.vary import TIMESTEP as TIMESTEP
from ...scenarios.vary import Axis as Axis
from .records import Key

#: A month on one core.
MAX_MEMBERS = 1_000_000
#: As many bits as numpy asks of a seed (`numpy.random.SeedSequence`).
MAX_SEED = (1 << 128) - 1
#: Outcomes of points that are not run: the varied numbers make no valid scene, or the run would
#: take more steps than a point may.
PointOutcome = Outcome | Literal["invalid", "skipped"]


@dataclass(frozen=True)
class Map:
    """Every pair of the values of two numbers.

    Attributes
    ----------
    scenario : the scene's name
    timestep : s, of every run; None where it is an axis or chosen point by point, so that the
        body turns equally far a step
    """

    scenario: str
    axes: tuple[Axis, Axis]
    timestep: float | None


@dataclass(frozen=True)
class Ensemble:
    """Scattered starts and bodies; a member does not depend on how many there are.

    Attributes
    ----------
    scenario : the scene's name
    timestep : s, of every run; None if it is chosen for each member, as in a map
    """

    scenario: str
    members: int
    seed: int
    timestep: float | None


@dataclass(frozen=True)
class PointResult:
    """One method at one point, against the point's own reference.

    Attributes
    ----------
    at : the axes' values in the order of the axes; of an ensemble the member's number
    key : scene, engine and method; engine and method are empty if the point is invalid, since it
        is then invalid for all methods
    timestep : s; 0 where the point is invalid before it is known
    cause : the kind of reason, in a word or two
    reason : why, where the outcome is not ok
    stopped_at : s, when it diverged or failed
    errors : up to where it stopped; None without samples
    uncertainty : the reference's, in ω, relative
    """

    at: tuple[float, ...]
    key: Key
    timestep: float
    outcome: PointOutcome
    cause: str = ""
    reason: str = ""
    stopped_at: float | None = None
    errors: Errors | None = None
    uncertainty: float = 0.0
    steps: int = 0


@dataclass(frozen=True, eq=False)
class MapResult:
    """A map with the scene that is varied, and its stored points, in the order of the axes."""

    map: Map
    scenario: Scenario
    points: tuple[PointResult, ...]


@dataclass(frozen=True, eq=False)
class EnsembleResult:
    """An ensemble with the scene that is scattered, and its stored members."""

    ensemble: Ensemble
    scenario: Scenario
    points: tuple[PointResult, ...]


@dataclass(frozen=True)
class SweepPoint:
    """One scene and timestep of a sweep.

    Attributes
    ----------
    at : the axes' values in the order of the axes; of an ensemble the member's number
    numbers : what is varied, by path, in the order of the axes; none for a member
    member : seed and number; None of a map
    timestep : s; None if it is chosen from the scene at the point
    """

    at: tuple[float, ...]
    numbers: tuple[tuple[str, float], ...] = ()
    member: tuple[int, int] | None = None
    timestep: float | None = None

    @property
    def identity(self) -> str:
        """JSON that identifies scene and timestep, whichever sweep the point belongs to."""
        parts: dict[str, float] = dict(self.numbers)
        if self.member is not None:
            parts["seed"], parts["member"] = self.member
        if self.timestep is not None:
            parts[TIMESTEP] = self.timestep
        return json.dumps(parts, sort_keys=True)

    def __str__(self) -> str:
        """The sweep in words."""
        parts = [f"{path} {value:.6g}" for path, value in self.numbers]
        if self.member is not None:
            parts.append(f"member {self.member[1]}")
        if self.timestep is not None:
            parts.append(f"timestep {self.timestep:.6g}")
        return ", ".join(parts)


def sweep_points(sweep: Map | Ensemble) -> Iterator[SweepPoint]:
    """All points of a sweep; of a map, the second axis varies fastest."""
    if isinstance(sweep, Ensemble):
        for number in range(sweep.members):
            yield SweepPoint((float(number),), (), (sweep.seed, number), sweep.timestep)
        return
    for at in product(*(axis.values for axis in sweep.axes)):
        yield _on_map(sweep, at)


def count_points(sweep: Map | Ensemble) -> int:
    """How many `sweep_points` there are."""
    if isinstance(sweep, Ensemble):
        return sweep.members
    return len(sweep.axes[0].values) * len(sweep.axes[1].values)


def sweep_point(sweep: Map | Ensemble, parts: Mapping[str, Any]) -> SweepPoint | None:
    """The point of a sweep that has an identity; None if the sweep has no such point.

    Parameters
    ----------
    parts : the identity, parsed
    """
    if isinstance(sweep, Ensemble):
        number = parts.get("member")
        if type(number) is not int or not 0 <= number < sweep.members:
            return None
        point = SweepPoint((float(number),), (), (sweep.seed, number), sweep.timestep)
    else:
        paths = [axis.path for axis in sweep.axes]
        at: tuple[Any, ...] = tuple(parts.get(path) for path in paths)
        if not all(_is_on(axis, value) for value, axis in zip(at, sweep.axes, strict=True)):
            return None
        point = _on_map(sweep, at)
    return point if json.loads(point.identity) == parts else None


def _is_on(axis: Axis, value: object) -> bool:
    if not isinstance(value, float | int):
        return False
    at = bisect_left(axis.values, value)
    return at < len(axis.values) and axis.values[at] == value


def _on_map(sweep: Map, at: tuple[float, ...]) -> SweepPoint:
    numbers = dict(zip((axis.path for axis in sweep.axes), at, strict=True))
    timestep = numbers.pop(TIMESTEP, sweep.timestep)
    return SweepPoint(at, tuple(numbers.items()), None, timestep)
