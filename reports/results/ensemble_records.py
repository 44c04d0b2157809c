"""Records of ensembles: scenes whose start and body are scattered at random."""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from ...scenarios import Scenario, loads
from .records import Record, Row, SceneName

#: Largest number of members: a month of computing on one core.
MAX_MEMBERS = 1_000_000
#: Largest seed: as many bits as numpy asks for (`numpy.random.SeedSequence`).
MAX_SEED = (1 << 128) - 1


@dataclass(frozen=True)
class EnsemblePoint:
    """A member of an ensemble, identified by numbers, and the timestep of its runs.

    Attributes
    ----------
    seed : seed of the ensemble
    number : number of the member in the ensemble, from 0
    timestep : s; None for each engine's stock timestep
    """

    seed: int
    number: int
    timestep: float | None = None

    @property
    def varied(self) -> dict[str, float]:
        """What identifies the member's runs, by name: seed, member (its number), and timestep.

        The timestep is left out if it is None.
        """
        parts: dict[str, float] = {"seed": self.seed, "member": self.number}
        return parts if self.timestep is None else {**parts, "timestep": self.timestep}

    def __str__(self) -> str:
        """Return the member's number and the timestep in words."""
        at = "" if self.timestep is None else f", timestep {self.timestep:.6g}"
        return f"member {self.number}{at}"


_Timestep = Annotated[float, Field(gt=0, lt=math.inf)]


@dataclass(frozen=True)
class Ensemble:
    """An ensemble: a scene whose start and body are scattered at random.

    A member depends only on the seed and on its own number, not on the number of members.

    Attributes
    ----------
    scenario : the scene's name
    members : number of members
    seed : seed of the random numbers
    timestep : timestep of every run, s; None for each engine's stock timestep
    """

    scenario: SceneName
    members: Annotated[int, Field(gt=0, le=MAX_MEMBERS)]
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)]
    timestep: _Timestep | None

    def __len__(self) -> int:
        """Return the number of members."""
        return self.members

    def points(self) -> Iterator[EnsemblePoint]:
        """Yield all members, each with the timestep of its runs."""
        return map(self._member, range(self.members))

    def point(self, parts: Mapping[str, Any]) -> EnsemblePoint | None:
        """Return the member of this ensemble to which a stored run belongs; None if to none.

        Parameters
        ----------
        parts : the values that identify the run (`EnsemblePoint.varied`)
        """
        number = parts.get("member")
        if type(number) is not int or not 0 <= number < self.members:
            return None
        point = self._member(number)
        return point if point.varied == parts else None

    def __str__(self) -> str:
        """Return the ensemble's size and its seed in words."""
        return f"{self.members} members of seed {self.seed}"

    def _member(self, number: int) -> EnsemblePoint:
        """Return the member with a given number."""
        return EnsemblePoint(self.seed, number, self.timestep)


@dataclass(frozen=True)
class DefinedEnsemble(Record):
    """An ensemble that a user asked for, and the scene that is scattered.

    Attributes
    ----------
    scenario : the scene's name
    toml : the text of the scene's file
    """

    scenario: SceneName
    ensemble: Ensemble
    toml: str

    def varied(self) -> Scenario:
        """Return the scene that is scattered.

        Raises
        ------
        ValueError
            If the file is not a valid scene, or the ensemble is of another scene.
        """
        if self.ensemble.scenario != self.scenario:
            raise ValueError(f"an ensemble of '{self.ensemble.scenario}' under '{self.scenario}'")
        return loads(self.toml, self.scenario)


@dataclass(frozen=True, eq=False)
class EnsembleResult:
    """An ensemble, the scene that is scattered, and the stored runs of its members.

    Attributes
    ----------
    points : the rows of the runs, sorted by member, engine and method
    """

    ensemble: Ensemble
    scenario: Scenario
    points: tuple[Row, ...]


def swept(stored: Iterable[DefinedEnsemble], points: Iterable[Row]) -> list[EnsembleResult]:
    """Return ensembles with their stored runs.

    Parameters
    ----------
    stored : the definitions of the ensembles
    points : the stored runs in which something is varied

    Raises
    ------
    ValueError
        If the definition of an ensemble is invalid.
    """
    of_scene: dict[str, list[Row]] = defaultdict(list)
    for row in points:
        of_scene[row.key.scenario].append(row)
    return [
        EnsembleResult(one.ensemble, one.varied(), points_of(one.ensemble, of_scene[one.scenario]))
        for one in stored
    ]


def points_of(ensemble: Ensemble, stored: Iterable[Row]) -> tuple[Row, ...]:
    """Return the runs of an ensemble's members, sorted by member, engine and method.

    Parameters
    ----------
    stored : the runs of the ensemble's scene in which something is varied
    """
    found = [row for row in stored if ensemble.point(row.varied) is not None]
    return tuple(sorted(found, key=lambda row: (row.varied["member"], row.pair)))
