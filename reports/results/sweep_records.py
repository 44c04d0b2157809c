"""What a sweep is: a scene run at many points, on a grid of two numbers or at random."""

from dataclasses import dataclass
from typing import Literal

from ...engines import Outcome
from ...scenarios import Errors, Scenario
from ...scenarios.vary import TIMESTEP as TIMESTEP
from ...scenarios.vary import Axis as Axis
from .records import Key

#: Besides how a run can end: the varied numbers make no scene, or the run would take more steps
#: than a point may. Neither is run.
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
    """Scattered starts and bodies; a member is the same however many there are.

    Attributes
    ----------
    scenario : the scene's name
    timestep : s, of every run; None where it is chosen member by member, as in a map
    """

    scenario: str
    members: int
    seed: int
    timestep: float | None


@dataclass(frozen=True)
class Point:
    """One method at one point, against the point's own reference.

    Attributes
    ----------
    at : the axes' values in the order of the axes; of an ensemble the member's number
    key : scene, engine and method; engine and method are empty where the point is invalid, which
        it is for all methods at once
    timestep : s; 0 where the point is invalid before it is known
    cause : the kind of reason, in a word or two, the same for all points of that kind
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
    """A map with the scene that is varied, and the points that are there, in the axes' order."""

    map: Map
    scenario: Scenario
    points: tuple[Point, ...]


@dataclass(frozen=True, eq=False)
class EnsembleResult:
    """An ensemble with the scene that is scattered, and the members that are there."""

    ensemble: Ensemble
    scenario: Scenario
    points: tuple[Point, ...]
