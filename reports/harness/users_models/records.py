"""The records of an inspection: links of a file × configurations of engines."""

from dataclasses import dataclass

from ....engines.checks.read_back import BodyReading
from ....engines.users_models import BodyDifference, Kind
from ....scenarios.users_models import FileProblem, Link, ModelFile, RigidBody, Stated

#: s after which two motions are compared.
TIMES = (1.0, 3.0)


@dataclass(frozen=True, eq=False)
class LinkReading:
    """One link as one engine holds it.

    Attributes
    ----------
    body : None if there is none: the engine refused the file, or fused the link with another
    agrees : whether it is what the file states; None if there is nothing to compare
    cause : in words, how it differs and why; empty if it agrees
    kind : the cause in a word
    fused : links whose mass the engine has added to this one
    expected : the exact sum of the parts, which `difference` is taken from; None as `stated`
    attitude_apart_deg : by the time in s, between the file's body and the engine's, tumbling from
        the same start; None where there is no such motion
    """

    engine: str
    engine_version: str
    configuration: str
    body: BodyReading | None
    agrees: bool | None
    cause: str = ""
    kind: Kind = ""
    fused: tuple[str, ...] = ()
    expected: Stated | None = None
    difference: BodyDifference | None = None
    attitude_apart_deg: dict[float, float] | None = None


@dataclass(frozen=True, eq=False)
class InspectedLink:
    """One link, the faults of its numbers in the file, and the bodies that the engines hold."""

    link: Link
    problems: tuple[FileProblem, ...]
    readings: tuple[LinkReading, ...]

    @property
    def is_well(self) -> bool:
        """Whether the numbers in the file are possible and every engine holds them."""
        impossible = any(problem.impossible for problem in self.problems)
        return not impossible and all(reading.agrees is not False for reading in self.readings)


@dataclass(frozen=True, eq=False)
class Inspection:
    """A whole file.

    Attributes
    ----------
    refusals : why an engine holds nothing of the file, by engine and configuration
    composed : bodies of several links, which move as one
    """

    model: ModelFile
    links: tuple[InspectedLink, ...]
    refusals: dict[tuple[str, str], str]
    composed: tuple[RigidBody, ...] = ()

    @property
    def is_well(self) -> bool:
        """Whether neither the file nor any engine's bodies have a fault."""
        return not self.refusals and all(link.is_well for link in self.links)
