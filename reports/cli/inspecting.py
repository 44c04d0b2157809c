"""What 'inspect' prints, as text and as JSON, and the files that 'inspect' and 'import' write."""

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ...engines import BodyReading
from ...engines.users_models import ModelFile, ModelFileError, parse_xml, read_model
from ...scenarios import printable
from ...scenarios.regular_files import write_new
from ..harness.executors import LocalWorkers
from ..pages.analysis.wording import plural
from ..users_models.findings import (
    LEGEND,
    Finding,
    added_masses,
    cell_text,
    listed,
    sections,
    stated_mass,
    weight_in_words,
    wrong_readings,
)
from ..users_models.inspection import (
    READ_LIMIT,
    CannotInspectError,
    InspectedLink,
    Inspection,
    inspect_model,
    reader_engines,
)
from ..users_models.mend import Mended, Wishes, mended
from ..users_models.scenes import LinkScene, link_scenes
from .terminal import NOT_RUN, Complaint, as_complaint, say, table, terminal_width, written

#: Largest number of lines of a list that are printed; '--json' has all.
MOST_LINES = 20


def models(
    files: Sequence[Path], packages: tuple[tuple[str, Path], ...]
) -> tuple[list[ModelFile], list[str]]:
    """Return the models of the files that can be read, and a message about each other file.

    Parameters
    ----------
    packages : names and folders of the packages that model files may refer to
    """
    read, wrong = [], []
    for file in files:
        try:
            read.append(read_model(file, packages))
        except ModelFileError as error:
            wrong.append(str(error))
    return read, wrong


def inspections(models: Sequence[ModelFile], engines: Sequence[str]) -> Iterator[Inspection]:
    """Yield the inspection of each model; engines read the models in a worker process.

    Parameters
    ----------
    engines : names of the engines that read the models; all that can if empty

    Raises
    ------
    Complaint
        If an engine is not known or cannot read a model of this format, or if no engine is
        installed that reads models.
    """
    with as_complaint(CannotInspectError):
        readers = reader_engines(engines, say)
        if not readers:
            raise Complaint("no engine is installed that reads model files", NOT_RUN)
        with LocalWorkers(1, READ_LIMIT) as worker:
            for model in models:
                yield inspect_model(model, worker, readers)


def print_inspection(inspection: Inspection) -> None:
    """Print a table with the inertia of each link as the file states it and as engines hold it.

    Below the table are the differences, the worst first, faults of the file, and remedies.
    """
    model = inspection.model
    stated = (
        plural(len(model.links), "link")
        + f", {sum(link.link.has_inertia for link in inspection.links)}"
    )
    _print(f"{model.path}: {model.format.upper()}, {stated} with a mass and a tensor")
    if weight := weight_in_words(inspection):
        _print(weight)
    shown = [
        link
        for link in inspection.links
        if link.link.stated is not None
        or any(reading.agrees is None and reading.body is not None for reading in link.readings)
    ]
    table([_row(link) for link in shown])
    if idle := len(inspection.links) - len(shown):
        _print(f"Not in the table: {plural(idle, 'link')} of which the file states no inertia.")
    if not inspection.is_well:
        _print(LEGEND)
    print()
    for heading, found in sections(inspection):
        _print_list(heading, found)
    if inspection.is_well:
        print("No differences found.\n")


def write_mended(
    inspection: Inspection, out: Path, wishes: Wishes, engines: Sequence[str]
) -> tuple[Mended, Inspection]:
    """Write a copy of a model's file, mended so that engines hold what it states, and inspect it.

    Parameters
    ----------
    inspection : the inspection of the original file
    out : path of the copy, at which there must be no file
    wishes : which optional changes are made
    engines : names of the engines that read the copy; all that can if empty

    Returns
    -------
    The mended file, with what was changed and what was left as it was; the inspection of the copy.

    Raises
    ------
    Complaint
        If the file is there already, or the copy cannot be written or read; what is not well-formed
        XML is not written.
    """
    one = mended(inspection, wishes)
    with as_complaint(ModelFileError):
        parse_xml(one.data, printable(str(out)))
    with written(out):
        write_new(out, one.data.decode(), replace=False)
    with as_complaint(ModelFileError):
        model = read_model(out, inspection.model.folders.packages)
    (after,) = inspections([model], engines)
    return one, after


def print_mended(one: Mended, before: Inspection, after: Inspection) -> None:
    """Print what was changed in a model's file, what was left as it was, and what that achieved.

    A table has, for each engine, the number of links that it holds wrongly before and after.

    Parameters
    ----------
    one : the mended file, with the changes
    before, after : inspections of the original and of the mended file
    """
    _print(f"{after.model.path}: {before.model.path}, mended. Links that engines hold otherwise:")
    table(
        [
            {"": " ".join(column)}
            | {"before": _count_of_wrong(before, column), "after": _count_of_wrong(after, column)}
            for column in after.columns
        ]
    )
    print()
    for heading, found in (("Changed", one.changes), ("Left as it was", one.left)):
        _print_list(heading, found)
    for heading, found in sections(after):
        _print_list(heading, found)


def _count_of_wrong(inspection: Inspection, column: tuple[str, str]) -> int | str:
    """Return the number of links that an engine holds wrongly; "refused" if it refused the file.

    `column` has the names of the engine and of the configuration in which it read the file.
    """
    if column in inspection.refusals:
        return "refused"
    return sum(reading.column == column for reading, _ in wrong_readings(inspection))


def _row(link: InspectedLink) -> dict[str, object]:
    """Return a link's row in the table of `print_inspection`, by the headings of the columns.

    The headings have line breaks, so that columns are hardly wider than their numbers.
    """
    stated = link.link.stated
    row: dict[str, object] = {"link": link.link.name, "kg": stated and stated.mass}
    for reading in link.readings:
        heading = reading.who.replace("@", " @").replace("-from", "- from")
        row[heading.replace(" ", "\n")] = cell_text(reading)
    return row


def _print_list(heading: str, lines: Sequence[Finding]) -> None:
    """Print a heading and at most `MOST_LINES` findings; print nothing if there are none."""
    if not lines:
        return
    print(f"{heading}:")
    for line in lines[:MOST_LINES]:
        _print(str(line), "  ", "    ")
    if len(lines) > MOST_LINES:
        print(f"  … and {len(lines) - MOST_LINES} more; '--json' has all")
    print()


def _print(text: str, first: str = "", rest: str = "") -> None:
    """Print a paragraph, wrapped if it goes to a terminal.

    Parameters
    ----------
    first, rest : indents of the first line, and of the others
    """
    text = printable(text)
    wrap = textwrap.TextWrapper(
        terminal_width() or len(first) + len(text) + 1,
        initial_indent=first,
        subsequent_indent=rest,
        break_long_words=False,
        break_on_hyphens=False,
    )
    print(wrap.fill(text))


def record(inspection: Inspection) -> dict[str, Any]:
    """Return an inspection as a JSON object: path of the `file`, its `links`, and a `summary`.

    Each link is as `_link_record` returns it. The summary has what holds for the whole file:
    whether all is well, counts of links, masses, why engines refused the file, and bodies that
    consist of welded links.
    """
    wrong = [" ".join(reading.column) for reading, _ in wrong_readings(inspection)]
    return {
        "file": str(inspection.model.path),
        "links": [_link_record(link) for link in inspection.links],
        "summary": {
            "well": inspection.is_well,
            "links": len(inspection.links),
            "stated": sum(link.link.has_inertia for link in inspection.links),
            "impossible": sum(not link.is_possible for link in inspection.links),
            "held_wrongly": {who: wrong.count(who) for who in map(" ".join, inspection.columns)},
            "mass": {"stated": stated_mass(inspection), "added": added_masses(inspection)},
            "refused": {" ".join(who): reason for who, reason in inspection.refusals.items()},
            "composed": [
                {"link": body.host.name, "welded": list(body.welded)}
                | _body_record(None if body.unread else body.stated)
                for body in inspection.composed
            ],
            "notes": list(inspection.model.notes),
        },
    }


def _link_record(link: InspectedLink) -> dict[str, Any]:
    """Return an inspected link as a JSON object.

    It has the link's name, `link`; the body that the file states, `stated`, or null; faults of its
    numbers, `problems`; and in `held`, for each engine and configuration, the body that the engine
    holds, and how and why this differs.
    """
    stated = link.link.stated
    return {
        "link": link.link.name,
        "stated": None if stated is None else _body_record(stated),
        "problems": [
            {"kind": p.kind, "impossible": p.impossible, "text": p.text} for p in link.problems
        ],
        "held": [
            {
                "engine": one.engine,
                "engine_version": one.engine_version,
                "configuration": one.configuration,
                **_body_record(one.body),
                "agrees": one.agrees,
                "cause": one.cause,
                "fused": list(one.fused),
                "difference": None if one.difference is None else vars(one.difference),
                "attitude_apart_deg": one.attitude_apart_deg
                and {f"{time:g}": angle for time, angle in one.attitude_apart_deg.items()},
            }
            for one in link.readings
        ],
    }


def _body_record(body: BodyReading | None) -> dict[str, Any]:
    """Return a body's mass, kg, com, m, and inertia tensor about the com, kg m², as a JSON object.

    All three are None if there is no body.
    """
    if body is None:
        return {"mass": None, "com": None, "inertia": None}
    return {"mass": body.mass, "com": body.com.tolist(), "inertia": body.inertia_com.tolist()}


def import_scenes(file: Path, out: Path, links: Sequence[str]) -> list[str]:
    """Write a scene for each link of a model file into a folder.

    Parameters
    ----------
    out : the folder; made if it does not exist
    links : names of the links that are wanted; all if empty

    Returns
    -------
    A line for each scene written, and one for each reason why links were left out.

    Raises
    ------
    Complaint
        If the file cannot be read, if a link in `links` is not in it, if no wanted link makes a
        scene, or if a scene's file exists already or cannot be written.
    """
    with as_complaint(ModelFileError):
        model = read_model(file)
    if unknown := [link for link in links if link not in {one.name for one in model.links}]:
        raise Complaint(printable(f"{file}: there is no link '{unknown[0]}'"))
    scenes = list(link_scenes(model, out.absolute()))
    wanted = [s for s in scenes if not links or {s.link, *s.welded}.intersection(links)]
    if not any(scene.text for scene in wanted):
        why = f"'{links[0]}' is welded to another and has no inertia of its own" if links else ""
        if wanted:
            why = "; ".join(_left_out(wanted))
        raise Complaint(printable(f"{file}: no link makes a scene; {why}"))
    paths = {out / f"{scene.name}.toml": scene for scene in wanted if scene.text}
    if there_already := [path for path in paths if path.exists()]:
        words = "a scene of that name exists already; remove it, or give another '--out'"
        raise Complaint(printable(f"{there_already[0]}: {words}"))
    lines = []
    with written(out):
        out.mkdir(parents=True, exist_ok=True)
        for path, scene in paths.items():
            write_new(path, scene.text, replace=False)
            with_others = f": {scene.link} with {listed(scene.welded)}, welded to it: one body"
            lines.append(f"{path}{with_others if scene.welded else ''}")
    return [printable(line) for line in [*lines, *_left_out(wanted)]]


def _left_out(scenes: Iterable[LinkScene]) -> list[str]:
    """Return a line for each reason why links make no scene, with the links' names."""
    by_reason: dict[str, list[str]] = {}
    for scene in scenes:
        if scene.left_out:
            by_reason.setdefault(scene.left_out, []).append(scene.link)
    return [f"left out: {', '.join(links)}: {reason}" for reason, links in by_reason.items()]
