"""The command 'inspect': a table link × configuration, what differs in words, and both as JSON."""

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ....engines.checks.read_back import BodyReading
from ....scenarios import printable
from ....scenarios.users_models import ModelFile, ModelFileError, Stated, read_model
from ...harness.executors import LocalWorkers
from ...harness.users_models.findings import (
    LEGEND,
    InspectedLink,
    Inspection,
    LinkReading,
    added_masses,
    cell_text,
    composed_bodies,
    differences,
    problems_of,
    stated_mass,
    weight_in_words,
)
from ...harness.users_models.inspect import (
    READ_LIMIT,
    CannotInspectError,
    inspect_model,
    reader_engines,
)
from ...harness.users_models.remedy import remedies
from ...pages.analysis.wording import plural
from ..terminal import NOT_RUN, Complaint, as_complaint, say, table, terminal_width, written


def record(inspection: Inspection) -> dict[str, Any]:
    """An inspection as a JSON object."""
    return {
        "file": str(inspection.model.path),
        "links": [_link_record(link) for link in inspection.links],
        "summary": {
            "well": inspection.is_well,
            "links": len(inspection.links),
            "stated": sum(is_stated(link) for link in inspection.links),
            "impossible": sum(
                any(p.impossible for p in link.problems) for link in inspection.links
            ),
            "held_wrongly": {
                f"{engine} {configuration}": sum(
                    reading.agrees is False
                    for link in inspection.links
                    for reading in link.readings
                    if (reading.engine, reading.configuration) == (engine, configuration)
                )
                for engine, configuration in inspection.columns
            },
            "mass": {"stated": stated_mass(inspection), "added": added_masses(inspection)},
            "refused": {" ".join(who): reason for who, reason in inspection.refusals.items()},
            "composed": [
                {
                    "link": body.host.name,
                    "welded": list(body.welded),
                    **(_body_record(body.stated) or {}),
                }
                for body in inspection.composed
            ],
            "notes": list(inspection.model.notes),
        },
    }


def _link_record(link: InspectedLink) -> dict[str, Any]:
    return {
        "link": link.link.name,
        "stated": _body_record(link.link.stated),
        "problems": [
            {"kind": p.kind, "impossible": p.impossible, "text": p.text} for p in link.problems
        ],
        "held": [_reading_record(reading) for reading in link.readings],
    }


def _reading_record(reading: LinkReading) -> dict[str, Any]:
    difference = reading.difference
    apart = reading.attitude_apart_deg
    return {
        "engine": reading.engine,
        "engine_version": reading.engine_version,
        "configuration": reading.configuration,
        **(_body_record(reading.body) or {"mass": None, "com": None, "inertia": None}),
        "agrees": reading.agrees,
        "cause": reading.cause,
        "fused": list(reading.fused),
        "difference": None if difference is None else vars(difference),
        "attitude_apart_deg": apart and {f"{time:g}": angle for time, angle in apart.items()},
    }


def _body_record(body: Stated | BodyReading | None) -> dict[str, Any] | None:
    if body is None:
        return None
    inertia = body.inertia if isinstance(body, Stated) else body.inertia_com
    return {"mass": body.mass, "com": body.com.tolist(), "inertia": inertia.tolist()}


def is_stated(link: InspectedLink) -> bool:
    """Whether the file gives a link a mass and a tensor."""
    return link.link.stated is not None and link.link.stated.is_physical


#: Lines of a list that are printed; '--json' has all.
MOST_LINES = 20


def models(
    files: Sequence[Path], packages: tuple[tuple[str, Path], ...]
) -> tuple[list[ModelFile], list[str]]:
    """The models of the files that can be read, and the complaints about the others."""
    read, wrong = [], []
    for file in files:
        try:
            read.append(read_model(file, packages))
        except ModelFileError as error:
            wrong.append(str(error))
    return read, wrong


def inspections(models: Sequence[ModelFile], engines: Sequence[str]) -> Iterator[Inspection]:
    """Inspect models one after the other; engines read them in one worker process each."""
    with as_complaint(CannotInspectError):
        readers = reader_engines(engines, say)
        if not readers:
            raise Complaint("no engine is installed that reads model files", NOT_RUN)
        with LocalWorkers(1, READ_LIMIT) as worker:
            for model in models:
                yield inspect_model(model, worker, readers)


def write_pages(inspected: Sequence[Inspection], out: Path) -> Iterator[Path]:
    """Write a page for each model."""
    from ...pages.users_models.model_page import page_names, write_model_page

    names = page_names([one.model.path for one in inspected])
    with written(out):
        for one, name in zip(inspected, names, strict=True):
            yield write_model_page(one, out, name)


def print_inspection(inspection: Inspection) -> None:
    """Print the table, the differences (worst first), faults of the file, and remedies."""
    model = inspection.model
    stated = sum(map(is_stated, inspection.links))
    _print(
        f"{model.path}: {model.format.upper()}, {plural(len(model.links), 'link')}, {stated} with "
        "a mass and a tensor"
    )
    if weight := weight_in_words(inspection):
        _print(weight)
    shown = [link for link in inspection.links if _has_something(link)]
    table([_row(link, inspection.columns) for link in shown])
    if idle := len(inspection.links) - len(shown):
        _print(f"Not in the table: {plural(idle, 'link')} of which the file states no inertia.")
    if not inspection.is_well:
        _print(LEGEND)
    print()
    _print_list("Bodies that engines hold differently, the worst first:", differences(inspection))
    _print_list("Impossible in the file:", problems_of(inspection, impossible=True))
    _print_list("Doubtful in the file:", problems_of(inspection, impossible=False))
    _print_list(
        "Welded together, each one body and one scene of 'import':", composed_bodies(inspection)
    )
    _print_list("What to do:", remedies(inspection))
    _print_list("Besides:", model.notes)
    if inspection.is_well:
        print("No differences found.\n")


def _has_something(link: InspectedLink) -> bool:
    """Whether the file states an inertial of a link, or an engine derives it from its shapes."""
    return link.link.stated is not None or any(
        reading.agrees is None and reading.body is not None for reading in link.readings
    )


def _row(link: InspectedLink, heads: Sequence[tuple[str, str]]) -> dict[str, object]:
    stated = link.link.stated
    cells = {
        _heading(engine, configuration): cell_text(reading)
        for (engine, configuration), reading in zip(heads, link.readings, strict=True)
    }
    return {"link": link.link.name, "kg": stated and stated.mass, **cells}


def _heading(engine: str, configuration: str) -> str:
    """The heading, broken into lines as narrow as the cells."""
    return f"{engine.replace('@', ' @')} {configuration.replace('-from', '- from')}".replace(
        " ", "\n"
    )


def _print_list(heading: str, lines: Iterable[object]) -> None:
    lines = list(lines)
    if not lines:
        return
    print(heading)
    for line in lines[:MOST_LINES]:
        _print(str(line), "  ", "    ")
    if len(lines) > MOST_LINES:
        print(f"  … and {len(lines) - MOST_LINES} more; '--json' has all")
    print()


def _print(text: str, first: str = "", rest: str = "") -> None:
    """Print a paragraph; wrapped on a terminal only."""
    width = terminal_width()
    text = printable(text)
    if width is None:
        print(f"{first}{text}")
        return
    wrapped = textwrap.wrap(
        text,
        width,
        initial_indent=first,
        subsequent_indent=rest,
        break_long_words=False,
        break_on_hyphens=False,
    )
    print("\n".join(wrapped))
