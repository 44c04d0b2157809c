"""An inspection: links of a file × configurations of engines, and its findings as lines."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ....engines.checks.read_back import BodyReading
from ....engines.users_models import BodyDifference, Kind
from ....scenarios.users_models import (
    FileProblem,
    Link,
    ModelFile,
    RigidBody,
    Stated,
    principal_moments,
)

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

    @property
    def who(self) -> str:
        """Engine and configuration."""
        return f"{self.engine} {self.configuration}"


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
    def columns(self) -> list[tuple[str, str]]:
        """Engine and configuration of each reading of the file."""
        return [(reading.engine, reading.configuration) for reading in self.links[0].readings]

    @property
    def is_well(self) -> bool:
        """Whether neither the file nor any engine's bodies have a fault."""
        return not self.refusals and all(link.is_well for link in self.links)


#: Links that a line names.
MOST_NAMES = 3
#: Cells of the table where an engine holds what the file states, and where nothing is compared.
FINE, NOTHING = "ok", "–"


@dataclass(frozen=True)
class Finding:
    """One statement about some links.

    Attributes
    ----------
    who : engine and configuration; empty if it is about the file itself
    names : of the links; empty if it is about the whole file
    """

    who: str
    names: tuple[str, ...]
    text: str

    def __str__(self) -> str:
        about = [part for part in (self.who, listed(self.names)) if part]
        return f"{', '.join(about)}: {self.text}"


def listed(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def differences(inspection: Inspection) -> list[Finding]:
    """Findings about engines: refusals first, then the others by `badness`."""
    refused = [
        Finding(f"{engine} {configuration}", (), reason)
        for (engine, configuration), reason in inspection.refusals.items()
    ]
    wrong = [
        (reading, link.link.name)
        for link in inspection.links
        for reading in link.readings
        if reading.agrees is False
    ]
    wrong.sort(key=lambda one: badness(one[0]), reverse=True)
    return refused + _grouped(
        (reading.who, f"{reading.cause}{_apart(reading)}", name) for reading, name in wrong
    )


def stated_mass(inspection: Inspection) -> float:
    """Total mass of the file's links, kg."""
    stated = (link.link.stated for link in inspection.links)
    return sum(one.mass for one in stated if one is not None)


def added_masses(inspection: Inspection) -> dict[str, float]:
    """The total mass, kg, of bodies for which the file states nothing, by configuration."""
    added: dict[str, float] = {}
    for link in inspection.links:
        for reading in link.readings:
            if reading.kind == "nothing stated" and reading.body is not None and reading.body.mass:
                added[reading.who] = added.get(reading.who, 0.0) + reading.body.mass
    return added


def weight_in_words(inspection: Inspection) -> str:
    """The robot's mass, and the engines that give it more; empty if none does."""
    stated = stated_mass(inspection)
    by_mass: dict[str, list[str]] = {}
    for who, added in added_masses(inspection).items():
        by_mass.setdefault(f"{stated + added:.4g} kg in", []).append(who)
    if not by_mass:
        return ""
    masses = "; ".join(f"{mass} {' and '.join(who)}" for mass, who in by_mass.items())
    return f"Its links weigh {stated:.4g} kg together; {masses}."


def problems_of(inspection: Inspection, *, impossible: bool) -> list[Finding]:
    """Findings about the file: impossible or doubtful numbers."""
    return _grouped(
        ("", problem.text, f"{link.link.name} (line {link.link.where.rpartition(':')[2]})")
        for link in inspection.links
        for problem in link.problems
        if problem.impossible == impossible
    )


def composed_bodies(inspection: Inspection) -> list[Finding]:
    """The bodies of several links, with mass and moments of the whole."""
    return [
        Finding("", (body.host.name, *body.welded), body.unread or _whole(stated))
        for body in inspection.composed
        if (stated := body.stated) is not None
    ]


def _whole(stated: Stated) -> str:
    moments = ", ".join(f"{moment:.4g}" for moment in principal_moments(stated.inertia))
    return f"{stated.mass:.4g} kg, principal moments {moments} kg m²"


def worst_links(inspection: Inspection) -> list[InspectedLink]:
    """Links with a stated body and something wrong, the largest attitude error first."""
    wrong = [
        link
        for link in inspection.links
        if link.link.stated is not None and (not link.is_well or link.problems)
    ]
    return sorted(
        wrong, key=lambda link: max(map(badness, link.readings), default=(0.0, 0.0)), reverse=True
    )


def badness(reading: LinkReading) -> tuple[float, float]:
    """Attitude apart at the latest time, degrees, and the size of the difference.

    A body for which the file states nothing counts as worse than any that is held wrongly.
    """
    if reading.agrees is not False:
        return (0.0, 0.0)
    if reading.kind == "nothing stated":
        return (float("inf"), reading.body.mass if reading.body else 0.0)
    apart = reading.attitude_apart_deg
    worst = reading.difference.worst if reading.difference is not None else 0.0
    return (max(apart.values()) if apart else 0.0, worst)


def _grouped(entries: Iterable[tuple[str, str, str]]) -> list[Finding]:
    alike: dict[tuple[str, str], list[str]] = {}
    for who, text, name in entries:
        alike.setdefault((who, text), []).append(name)
    return [Finding(who, tuple(names), text) for (who, text), names in alike.items()]


def _apart(reading: LinkReading) -> str:
    apart = reading.attitude_apart_deg
    if apart is None:
        return ""
    angles = " and ".join(f"{angle:.3g}° after {time:g} s" for time, angle in apart.items())
    return f"; attitude off by {angles} of tumbling"


#: What the cells of `cell_text` mean.
LEGEND = (
    "ok: as in the file. Other cells: the largest relative difference of mass, com and tensor, and "
    "how far the attitude is off after tumbling for 1 s. fused: part of the body, or of the world, "
    "that it is fixed to."
)


def cell_text(reading: LinkReading) -> str:
    """The text of a cell: how one configuration holds one link."""
    if reading.kind == "refused":
        return "refused"
    if reading.agrees is None:
        if reading.body is None and reading.cause:
            return "fused"
        return "by shapes" if reading.body is not None and reading.cause else NOTHING
    if reading.agrees:
        return FINE
    if reading.difference is None:
        return f"{reading.body.mass:.3g} kg" if reading.body else NOTHING
    apart = reading.attitude_apart_deg
    return _share(reading.difference.worst) + (f", {apart[1.0]:.0f}°" if apart is not None else "")


def _share(share: float) -> str:
    if share == float("inf"):
        return "not zero"
    if share >= 10:
        return f"× {share:.3g}"
    return f"{share:.2%}" if share < 0.01 else f"{share:.0%}"
