"""Remedies where an engine holds another body than the file states: a flag, an option, a line."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ....engines.models.text import decimals
from ....engines.users_models import Kind, ModelReader, model_readers
from ....scenarios.users_models import Stated
from .findings import InspectedLink, Inspection, LinkReading, listed

#: The `<inertial>` of a frame without a mass.
NO_INERTIA = (
    '<inertial><mass value="0"/>'
    '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
)


@dataclass(frozen=True)
class Remedy:
    """What to do, and for which links of which configurations.

    Attributes
    ----------
    who : engines and configurations
    line : of XML to put into the file; empty where the remedy is something else
    """

    who: tuple[str, ...]
    links: tuple[str, ...]
    text: str
    line: str = ""

    def __str__(self) -> str:
        line = f": {self.line}" if self.line else ""
        return f"{', '.join(self.who)}; {listed(self.links)}: {self.text}{line}"


def remedies(inspection: Inspection) -> list[Remedy]:
    """All remedies, each once: of refusals first, then in the order of the table's columns."""
    wrong: dict[tuple[str, str, Kind], list[str]] = {}
    for link in inspection.links:
        for reading in link.readings:
            if reading.agrees is False:
                link_names = wrong.setdefault(
                    (reading.engine, reading.configuration, reading.kind), []
                )
                link_names.append(link.link.name)
    by_kind = [
        Remedy((f"{engine} {configuration}",), tuple(names), text, line)
        for (engine, configuration, kind), names in wrong.items()
        for text, line in _of_kind(engine, configuration, kind)
    ]
    alike: dict[tuple[str, str, tuple[str, ...]], Remedy] = {}
    for one in (*_of_refusals(inspection), *by_kind):
        key = (one.text, one.line, one.links)
        before = alike[key].who if key in alike else ()
        alike[key] = replace(one, who=before + one.who)
    return list(alike.values())


def line_without_rotation(link: InspectedLink, reading: LinkReading) -> str:
    """The link's `<inertial>` without a rotation, if an engine loses the rotation; else empty."""
    if reading.kind != "rotation lost" or link.link.stated is None:
        return ""
    return inertial_line(link.link.stated)


def inertial_line(stated: Stated) -> str:
    """The `<inertial>` of a link without a rotation, which every reader reads alike."""
    tensor = stated.inertia
    entries = {
        f"i{a}{b}": tensor[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i <= j
    }
    written = " ".join(f'{key}="{float(value)!r}"' for key, value in entries.items())
    return (
        f'<inertial><origin xyz="{decimals(stated.com)}"/>'
        f'<mass value="{float(stated.mass)!r}"/><inertia {written}/></inertial>'
    )


def _of_kind(engine: str, configuration: str, kind: Kind) -> Iterator[tuple[str, str]]:
    """What mends it in any engine, with what this one has to add."""
    reader, is_versioned = _reader(engine), "@" in engine
    own = reader.advice.get(kind)
    newer = ", or use a newer version" if is_versioned else ""
    if kind == "made up":
        for configured in reader.configurations:
            if configured.name == configuration and configured.remedy:
                yield configured.remedy, ""
    elif kind == "nothing stated":
        massless = f"no mass; {own.text}" if own else "no mass"
        yield f"state their inertia, or that they have {massless}", NO_INERTIA
    elif kind == "no tensor":
        yield "state their tensors: the file has a mass alone", ""
    elif kind == "zero":
        yield "correct their tensors in the file: no body has them", ""
    elif kind == "rotation lost":
        yield f"write the tensor along the link's axes, without 'rpy'{newer}", ""
    elif own:
        yield f"{own.text}{newer if own.is_mended else ''}", own.line


def _of_refusals(inspection: Inspection) -> Iterator[Remedy]:
    """What makes an engine accept a file that it refuses."""
    concerned = {
        "impossible": [
            link.link.name for link in inspection.links if any(p.impossible for p in link.problems)
        ],
        "massless": [
            link.link.name
            for link in inspection.links
            if link.link.moves and (link.link.stated is None or not link.link.stated.is_physical)
        ],
    }
    for (engine, configuration), reason in inspection.refusals.items():
        for known in _reader(engine).refusals:
            if any(phrase in reason for phrase in known.phrases):
                links = tuple(concerned[known.concerns])
                who = (f"{engine} {configuration}",)
                yield Remedy(who, links, known.advice.text, known.advice.line)
                break


def _reader(engine: str) -> ModelReader:
    """The reader of an engine, at whichever version."""
    return model_readers()[engine.partition("@")[0]]
