"""The command 'inspect': a table link × configuration, then what differs, in words."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ...engines.read_back import BodyReading
from ...scenarios import printable
from ...scenarios.model_files import ModelFileError, Stated
from ..harness.executors import LocalWorkers
from ..harness.inspection import CannotInspectError, Held, InspectedLink, Inspection, inspect_model
from ..harness.inspection.inspect import READ_LIMIT
from .terminal import BAD_INPUT, NOT_RUN, Complaint, table

#: Lines of differences that are printed; '--json' has all.
MOST_LINES = 20
#: Links that a line names.
MOST_NAMES = 3
#: What a cell says where an engine holds what the file states, and where there is nothing to say.
FINE, NOTHING = "ok", "–"


def inspected(
    files: Sequence[Path], engines: Sequence[str], packages: tuple[tuple[str, Path], ...]
) -> list[Inspection]:
    """Inspect files one after the other; engines read them in one worker process.

    Raises
    ------
    Complaint
        If a file cannot be read, or no engine can be asked.
    """
    try:
        with LocalWorkers(1, READ_LIMIT) as worker:
            return [inspect_model(file, worker, engines, packages) for file in files]
    except ModelFileError as error:
        raise Complaint(str(error), BAD_INPUT) from None
    except CannotInspectError as error:
        raise Complaint(str(error), NOT_RUN) from None


def record(inspection: Inspection) -> dict[str, Any]:
    """As the contract of `--json` has it."""
    return {
        "file": str(inspection.model.path),
        "links": [_link_record(link) for link in inspection.links],
        "summary": {
            "well": inspection.is_well,
            "links": len(inspection.links),
            "stated": sum(_is_stated(link) for link in inspection.links),
            "impossible": sum(
                any(p.impossible for p in link.problems) for link in inspection.links
            ),
            "held_wrongly": {
                f"{engine} {configuration}": sum(
                    held.agrees is False
                    for link in inspection.links
                    for held in link.held
                    if (held.engine, held.configuration) == (engine, configuration)
                )
                for engine, configuration in _columns(inspection)
            },
            "refused": {" ".join(who): reason for who, reason in inspection.refusals.items()},
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
        "held": [_held_record(held) for held in link.held],
    }


def _held_record(held: Held) -> dict[str, Any]:
    difference = held.difference
    apart = held.attitude_apart_deg
    return {
        "engine": held.engine,
        "engine_version": held.engine_version,
        "configuration": held.configuration,
        **(_body_record(held.body) or {"mass": None, "com": None, "inertia": None}),
        "agrees": held.agrees,
        "cause": held.cause,
        "fused": list(held.fused),
        "difference": None if difference is None else vars(difference),
        "attitude_apart_deg": apart and {f"{time:g}": angle for time, angle in apart.items()},
    }


def _body_record(body: Stated | BodyReading | None) -> dict[str, Any] | None:
    if body is None:
        return None
    inertia = body.inertia if isinstance(body, Stated) else body.inertia_com
    return {"mass": body.mass, "com": body.com.tolist(), "inertia": inertia.tolist()}


def print_inspection(inspection: Inspection) -> None:
    """Table, differences worst first, what the file has wrong, and what to do."""
    model = inspection.model
    columns = _columns(inspection)
    stated = sum(map(_is_stated, inspection.links))
    print(
        f"{printable(str(model.path))}: {model.format.upper()}, {len(model.links)} links, "
        f"{stated} with an inertia of their own"
    )
    table([_row(link, columns) for link in inspection.links if _has_something(link)])
    if idle := sum(not _has_something(link) for link in inspection.links):
        print(f"{idle} more links state no inertia and are not in the table.\n")
    _print_list("What engines hold otherwise:", _differences(inspection))
    _print_list("What the file has wrong:", _problems(inspection))
    _print_list("What to do:", _remedies(inspection))
    _print_list("Besides:", list(model.notes))
    print("All is well.\n" if inspection.is_well else "")


def _columns(inspection: Inspection) -> list[tuple[str, str]]:
    first = inspection.links[0].held
    return [(held.engine, held.configuration) for held in first]


def _is_stated(link: InspectedLink) -> bool:
    return link.link.stated is not None and link.link.stated.is_physical


def _has_something(link: InspectedLink) -> bool:
    """Whether the file states an inertial of a link, or an engine derives it from its shapes."""
    return link.link.stated is not None or any(
        held.agrees is None and held.body is not None for held in link.held
    )


def _row(link: InspectedLink, columns: Sequence[tuple[str, str]]) -> dict[str, object]:
    stated = link.link.stated
    cells = {
        f"{engine} {configuration}": _cell(held)
        for (engine, configuration), held in zip(columns, link.held, strict=True)
    }
    return {
        "link": link.link.name,
        "mass, kg": stated and stated.mass,
        **cells,
        "the file": ", ".join(problem.kind for problem in link.problems),
    }


def _cell(held: Held) -> str:
    if held.agrees is None:
        if held.body is None and held.cause.startswith("fused"):
            return "fused"
        return "from shapes" if held.body is not None and held.cause else NOTHING
    if held.agrees:
        return FINE
    if held.difference is None:
        return "not nothing"
    apart = held.attitude_apart_deg
    return f"{_percent(held.difference.worst)} off" + (
        f", {apart[1.0]:.0f}° in 1 s" if apart is not None else ""
    )


def _percent(share: float) -> str:
    return (
        f"{share:.3g} times" if share >= 10 else f"{share:.2%}" if share < 0.01 else f"{share:.0%}"
    )


def _differences(inspection: Inspection) -> list[str]:
    """Refusals first, then worst motion, then largest difference; alike ones in one line."""
    refused = [
        f"{engine} {configuration}: {reason}"
        for (engine, configuration), reason in inspection.refusals.items()
    ]
    wrong = [
        (link.link.name, held)
        for link in inspection.links
        for held in link.held
        if held.agrees is False
    ]
    wrong.sort(key=lambda one: _badness(one[1]), reverse=True)
    alike: dict[str, list[str]] = {}
    for name, held in wrong:
        description = f"{held.engine} {held.configuration}: {held.cause}{_apart(held)}"
        alike.setdefault(description, []).append(name)
    return refused + [f"{_names(names)}, {description}" for description, names in alike.items()]


def _names(names: Sequence[str]) -> str:
    """The first of them, and how many there are."""
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _badness(held: Held) -> tuple[float, float]:
    apart = held.attitude_apart_deg
    worst = held.difference.worst if held.difference is not None else 0.0
    return (max(apart.values()) if apart else 0.0, worst)


def _apart(held: Held) -> str:
    if held.attitude_apart_deg is None:
        return ""
    angles = (f"{angle:.3g}° after {time:g} s" for time, angle in held.attitude_apart_deg.items())
    return f"; tumbling, it is {' and '.join(angles)} from where it should be"


def _problems(inspection: Inspection) -> list[str]:
    problems = [
        (not problem.impossible, f"{link.link.where}: link '{link.link.name}': {problem.text}")
        for link in inspection.links
        for problem in link.problems
    ]
    return [text for _, text in sorted(problems, key=lambda one: one[0])]


def _remedies(inspection: Inspection) -> Iterator[str]:
    from ...engines.model_reader import model_readers

    readers = model_readers()
    for engine, configuration in _columns(inspection):
        wrong = any(
            held.agrees is False and (held.engine, held.configuration) == (engine, configuration)
            for link in inspection.links
            for held in link.held
        )
        for known in readers[engine].configurations:
            if wrong and known.name == configuration and known.remedy:
                yield f"{engine} {configuration}: {known.remedy}"


def _print_list(heading: str, lines: Sequence[str] | Iterator[str]) -> None:
    lines = list(lines)
    if not lines:
        return
    print(heading)
    for line in lines[:MOST_LINES]:
        print(f"  {printable(line)}")
    if len(lines) > MOST_LINES:
        print(f"  … and {len(lines) - MOST_LINES} more; '--json' has all")
    print()
