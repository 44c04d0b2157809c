"""What an inspection finds: a link of a file × a configuration of an engine."""

from dataclasses import dataclass

from ....engines.inspection import Difference, Kind
from ....engines.read_back import BodyReading
from ....scenarios.model_files import Link, ModelFile, Problem, Stated

#: s after which two motions are compared.
TIMES = (1.0, 3.0)


@dataclass(frozen=True, eq=False)
class Held:
    """What one engine holds of one link.

    Attributes
    ----------
    body : None if it holds nothing: it refused the file, or fused the link with another
    agrees : whether that is what the file states; None where there is nothing to compare
    cause : in words, what it holds and why; empty where it agrees
    kind : the same in a word
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
    difference: Difference | None = None
    attitude_apart_deg: dict[float, float] | None = None


@dataclass(frozen=True, eq=False)
class InspectedLink:
    """One link, what its file has wrong, and what the engines hold."""

    link: Link
    problems: tuple[Problem, ...]
    held: tuple[Held, ...]

    @property
    def is_well(self) -> bool:
        """Whether the file states something possible and every engine holds it."""
        impossible = any(problem.impossible for problem in self.problems)
        return not impossible and all(held.agrees is not False for held in self.held)


@dataclass(frozen=True, eq=False)
class Inspection:
    """A whole file.

    Attributes
    ----------
    refusals : why an engine holds nothing of the file, by engine and configuration
    """

    model: ModelFile
    links: tuple[InspectedLink, ...]
    refusals: dict[tuple[str, str], str]

    @property
    def is_well(self) -> bool:
        """Whether nothing is wrong with the file, nor with what the engines hold of it."""
        return not self.refusals and all(link.is_well for link in self.links)
