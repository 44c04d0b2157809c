"""The findings of an inspection as lines: wrong bodies, faults of the file, and what to do."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from ...engines.model_readers import model_readers
from ...engines.users_models import (
    Advice,
    Configuration,
    principal_moments,
)
from .inspection import InspectedLink, Inspection, LinkReading

#: Largest number of links that a line names.
MOST_NAMES = 3
#: Texts of a cell of the table: the engine holds what the file states; nothing can be compared.
FINE, NOTHING = "ok", "–"
#: Meanings of the texts that `cell_text` returns.
LEGEND = (
    "ok: as in the file. Other cells: the largest relative difference of mass, com and tensor, and "
    "how far the attitude is off after tumbling for 1 s. fused: part of the body, or of the world, "
    "that it is fixed to. unread: the body has parts that were not read."
)
#: Advice on wrong bodies that holds for any engine, by the word for the cause (`LinkReading.kind`).
IN_ANY_ENGINE = {
    "nothing stated": Advice(
        "state their inertia, or that they have no mass",
        '<inertial><mass value="0"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>',
    ),
    "no tensor": Advice("state their tensors: the file has a mass alone"),
    "zero": Advice("correct their masses and tensors in the file: no body has them"),
    "rotation lost": Advice("write the tensor along the link's axes, without 'rpy'", "", True),
}


@dataclass(frozen=True)
class Finding:
    """A statement about some links, or what to do about them.

    Attributes
    ----------
    who : engines, each with its configuration; empty if the statement is about the file itself
    names : names of the links; empty if the statement is about the whole file
    text : the statement
    line : XML to put into the file; empty if there is none
    """

    who: tuple[str, ...]
    names: tuple[str, ...]
    text: str
    line: str = ""

    @property
    def about(self) -> str:
        """The engines and links that the finding is about, and a colon; empty if there are none."""
        about = [part for part in (" and ".join(self.who), listed(self.names)) if part]
        return f"{', '.join(about)}: " if about else ""

    def __str__(self) -> str:
        return f"{self.about}{self.text}{': ' if self.line else ''}{self.line}"


def listed(names: Sequence[str]) -> str:
    """Return the first `MOST_NAMES` names as text, and how many more there are."""
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def grouped(entries: Iterable[tuple[str, str, str]]) -> list[Finding]:
    """Return findings; entries with the same engine and statement become one, for all their links.

    Parameters
    ----------
    entries : three texts each: the engine with its configuration, or empty for the file itself; the
        statement; and the name of one link
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for who, text, name in entries:
        alike.setdefault((who, text), []).append(name)
    return [
        Finding((who,) if who else (), tuple(names), text) for (who, text), names in alike.items()
    ]


def wrong_readings(inspection: Inspection) -> list[tuple[LinkReading, str]]:
    """Return each `LinkReading` whose body differs from that in the file, with the link's name.

    The order is that of the file's links.
    """
    return [
        (reading, link.link.name)
        for link in inspection.links
        for reading in link.readings
        if reading.agrees is False
    ]


def sections(inspection: Inspection) -> list[tuple[str, list[Finding]]]:
    """Return pairs of a heading and its findings; headings without findings are left out."""
    by_heading = {
        "Bodies that engines hold differently, the worst first": differences(inspection),
        "Impossible in the file": problems_of(inspection, impossible=True),
        "Doubtful in the file": problems_of(inspection, impossible=False),
        "Welded together, each one body and one scene of 'import'": composed_bodies(inspection),
        "What to do": remedies(inspection),
        "Besides": [Finding((), (), note) for note in inspection.model.notes],
    }
    return [(heading, found) for heading, found in by_heading.items() if found]


def differences(inspection: Inspection) -> list[Finding]:
    """Return findings on what engines make of the model file.

    The first ones say why engines refuse it. The others are on links for which an engine's body
    differs from that in the file, the worst first (`badness`); links with the same engine and
    statement share one finding.
    """
    wrong = sorted(wrong_readings(inspection), key=lambda one: badness(one[0]), reverse=True)
    return [
        *(Finding((" ".join(who),), (), reason) for who, reason in inspection.refusals.items()),
        *grouped((one.who, f"{one.cause}{_apart(one)}", name) for one, name in wrong),
    ]


def _apart(reading: LinkReading) -> str:
    apart = reading.attitude_apart_deg
    if apart is None:
        return ""
    angles = " and ".join(f"{angle:.3g}° after {time:g} s" for time, angle in apart.items())
    return f"; attitude off by {angles} of tumbling"


def badness(reading: LinkReading) -> tuple[float, float]:
    """Return how wrong an engine's body is, as a sort key of two numbers.

    The first is the largest angle between the attitudes of the file's and the engine's body,
    degrees, and the second is the largest relative difference of these bodies. A body for which the
    file states nothing counts as worse than any other: the numbers are infinity and its mass, kg.
    Both are zero if the bodies agree or cannot be compared.
    """
    if reading.agrees is not False:
        return (0.0, 0.0)
    if reading.kind == "nothing stated":
        return (float("inf"), reading.body.mass if reading.body else 0.0)
    apart = reading.attitude_apart_deg
    worst = reading.difference.worst if reading.difference is not None else 0.0
    return (max(apart.values()) if apart else 0.0, worst)


def problems_of(inspection: Inspection, *, impossible: bool) -> list[Finding]:
    """Return findings about faults of the numbers in the file.

    Parameters
    ----------
    impossible : True for numbers that no body can have, False for doubtful numbers
    """
    return grouped(
        ("", problem.text, f"{link.link.name} (line {link.link.where.rpartition(':')[2]})")
        for link in inspection.links
        for problem in link.problems
        if problem.impossible == impossible
    )


def composed_bodies(inspection: Inspection) -> list[Finding]:
    """Return a finding on each body that consists of links welded together.

    It states the body's mass and principal moments. If the shapes of some link determine its
    inertia, it states instead that this inertia was not read.
    """
    lines = []
    for body in inspection.composed:
        assert body.stated is not None, "a part states an inertia"
        moments = ", ".join(f"{one:.4g}" for one in principal_moments(body.stated.inertia_com))
        text = f"{body.stated.mass:.4g} kg, principal moments {moments} kg m²"
        lines.append(Finding((), (body.host.name, *body.welded), body.unread or text))
    return lines


def stated_mass(inspection: Inspection) -> float:
    """Return the total mass that the file states for its links, kg."""
    stated = (link.link.stated for link in inspection.links)
    return sum(one.mass for one in stated if one is not None)


def added_masses(inspection: Inspection) -> dict[str, float]:
    """Return by how much engines make the model heavier than its file states, kg.

    It is the mass of the bodies for which the file states nothing, by the name of engine and
    configuration. Engines that add no mass are left out.
    """
    added: dict[str, float] = {}
    for reading, _ in wrong_readings(inspection):
        if reading.kind == "nothing stated" and reading.body is not None and reading.body.mass:
            added[reading.who] = added.get(reading.who, 0.0) + reading.body.mass
    return added


def weight_in_words(inspection: Inspection) -> str:
    """Return, in words, the mass that the file states, and the mass in engines where it is larger.

    The text is empty if it is larger in no engine.
    """
    stated = stated_mass(inspection)
    by_mass: dict[str, list[str]] = {}
    for who, added in added_masses(inspection).items():
        by_mass.setdefault(f"{stated + added:.4g} kg in", []).append(who)
    masses = "; ".join(f"{mass} {' and '.join(who)}" for mass, who in by_mass.items())
    return f"Its links weigh {stated:.4g} kg together; {masses}." if masses else ""


def remedies(inspection: Inspection) -> list[Finding]:
    """Return what users can do about refused files, then what they can do about wrong bodies.

    Advice that is the same for several engines is one finding.
    """
    alike: dict[tuple[str, str, tuple[str, ...]], Finding] = {}
    for one in (*_of_refusals(inspection), *_of_differences(inspection)):
        key = (one.text, one.line, one.names)
        before = alike[key].who if key in alike else ()
        alike[key] = replace(one, who=before + one.who)
    return list(alike.values())


def configuration_of(engine: str, name: str) -> Configuration:
    """Return a configuration of an engine by its name.

    Parameters
    ----------
    engine : the engine's name, with or without a version
    name : the configuration's name
    """
    configurations = model_readers()[engine.partition("@")[0]].configurations
    return next(one for one in configurations if one.name == name)


def _is_massless(one: InspectedLink) -> bool:
    """Whether a link's only fault is to move without an inertia, stated or that of its shapes."""
    lacks = one.link.moves and not one.link.has_inertia and not one.link.by_shapes
    return lacks and all(problem.kind == "zero tensor" for problem in one.problems)


def _is_small(one: InspectedLink, least: float) -> bool:
    """Whether a link's possible mass, kg, or a principal moment, kg m², is below `least`."""
    stated = one.link.stated
    if stated is None or not stated.is_physical or not one.is_possible:
        return False
    return min(stated.mass, float(principal_moments(stated.inertia_com)[0])) < least


#: By each word of `Advice.concerns`, the function that says whether a link is concerned. Its second
#: argument is `Advice.least`.
_CONCERNED: dict[str, Callable[[InspectedLink, float], bool]] = {
    "impossible": lambda one, _: not one.is_possible and not _is_massless(one),
    "massless": lambda one, _: _is_massless(one),
    "small": _is_small,
}


def _of_refusals(inspection: Inspection) -> Iterator[Finding]:
    """Yield advice on what to change in the file, for each engine that refuses it.

    There is a finding for each kind of link that may have caused the refusal, with these links.
    """
    for (engine, configuration), reason in inspection.refusals.items():
        refusals = model_readers()[engine.partition("@")[0]].refusals
        each = next((each for phrase, each in refusals.items() if phrase in reason), ())
        for advice in each:
            concerned = _CONCERNED[advice.concerns]
            links = tuple(one.link.name for one in inspection.links if concerned(one, advice.least))
            if links or len(each) == 1:
                yield Finding((f"{engine} {configuration}",), links, advice.text, advice.line)


def _of_differences(inspection: Inspection) -> Iterator[Finding]:
    """Yield advice on wrong bodies: a finding for each engine's configuration and each cause.

    Its text has the advice that holds for any engine, then the advice for this engine.
    """
    wrong: dict[tuple[tuple[str, str], str], list[str]] = {}
    for reading, name in wrong_readings(inspection):
        wrong.setdefault((reading.column, reading.kind), []).append(name)
    for ((engine, configuration), kind), names in wrong.items():
        of_both = (
            IN_ANY_ENGINE.get(kind),
            configuration_of(engine, configuration).advice.get(kind),
        )
        advice = [one for one in of_both if one is not None]
        if advice:
            newer = ", or use a newer version" if "@" in engine and advice[0].is_mended else ""
            text = "; ".join(one.text for one in advice) + newer
            yield Finding((f"{engine} {configuration}",), tuple(names), text, advice[0].line)


def cell_text(reading: LinkReading) -> str:
    """Return the text of a table cell, which says how well an engine holds a link (`LEGEND`)."""
    if reading.kind in ("refused", "unread"):
        return reading.kind
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
