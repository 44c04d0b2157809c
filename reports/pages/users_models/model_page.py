"""The page of a user's model: how engines hold its links, the worst first, and remedies."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....engines.users_models import model_readers
from ....scenarios import FloatArray, printable
from ....scenarios.regular_files import file_name
from ....scenarios.users_models import Stated, principal_moments
from ...harness.users_models.findings import (
    LEGEND,
    InspectedLink,
    Inspection,
    LinkReading,
    cell_text,
    composed_bodies,
    differences,
    problems_of,
    weight_in_words,
    worst_links,
)
from ...harness.users_models.inspect import attitude_apart
from ...harness.users_models.remedy import line_without_rotation, remedies
from ..analysis.trace_style import TraceStyle, trace_styles
from ..tables import Cell, Table, figure, table
from ..templating import ReportFolder, templates, write_assets
from .inertia_ellipsoid import Solid, solid_squares, time_curves, views

#: Number of links with pictures; the table has all.
MOST_SHOWN = 12
#: Times at which curves are computed, s.
TIMES = np.linspace(0.0, 3.0, 61)
#: Style of the file's own body.
INK = "var(--ink)"
FILES_OWN = "the file"
Who = tuple[str, str]


def write_model_page(inspection: Inspection, folder: Path, name: str) -> Path:
    """Write `models/NAME.html` and the style sheets it needs; returns the page.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    written = ReportFolder(folder)
    write_assets(written, "style.css", "model.css")
    page = templates().get_template("model.html").render(root="../", **_content(inspection))
    return written.write(f"models/{name}.html", page)


def page_names(paths: Sequence[Path]) -> list[str]:
    """A page name for each file: folder and file name, in safe characters."""
    names: list[str] = []
    for path in paths:
        names.append(file_name(f"{path.absolute().parent.name}-{path.stem}", names))
    return names


def _content(inspection: Inspection) -> dict[str, object]:
    model = inspection.model
    who = inspection.columns
    drawn = trace_styles(who)
    worst = worst_links(inspection)
    wrong = [link for link in inspection.links if not link.is_well]
    return {
        "file": printable(str(model.path)),
        "format": model.format.upper(),
        "links": len(inspection.links),
        "stated": sum(li.link.stated is not None for li in inspection.links),
        "wrong": len(wrong),
        "is_well": inspection.is_well,
        "weight": weight_in_words(inspection),
        "configurations": _configurations(inspection, who),
        "remedies": remedies(inspection),
        "refusals": [(" ".join(key), reason) for key, reason in inspection.refusals.items()],
        "cards": [_card(link, drawn) for link in worst[:MOST_SHOWN]],
        "left": len(worst) - len(worst[:MOST_SHOWN]),
        "differences": differences(inspection),
        "impossible": problems_of(inspection, impossible=True),
        "doubtful": problems_of(inspection, impossible=False),
        "composed": composed_bodies(inspection),
        "legend": LEGEND,
        "all_links": _all_links(inspection, who),
        "notes": model.notes,
    }


def _configurations(inspection: Inspection, who: Sequence[Who]) -> Table:
    """Table of the configurations, and how many links each holds as the file states them."""
    readers = model_readers()
    rows = []
    for k, (engine, configuration) in enumerate(who):
        readings = [link.readings[k] for link in inspection.links]
        by_name = {one.name: one for one in readers[engine.partition("@")[0]].configurations}
        summary = by_name[configuration].summary
        counts = [sum(h.agrees is answer for h in readings) for answer in (True, False)]
        refused = (engine, configuration) in inspection.refusals
        rows.append(
            [
                Cell(f"{engine} {configuration}", "name", summary),
                Cell(readings[0].engine_version),
                Cell("refused" if refused else str(counts[0]), "failed" if refused else "number"),
                Cell("" if refused else str(counts[1]), "number"),
                figure(str(sum(h.body is None for h in readings) if not refused else "")),
            ]
        )
    heads = ("engine and configuration", "version", "as stated", "otherwise", "fused")
    return table(heads, rows)


def _all_links(inspection: Inspection, who: Sequence[Who]) -> Table:
    rows = []
    for link in inspection.links:
        stated = link.link.stated
        mass = figure("" if stated is None else f"{stated.mass:.3g}")
        problems = ", ".join(problem.kind for problem in link.problems)
        cells = [_coloured(reading) for reading in link.readings]
        rows.append([Cell(printable(link.link.name), "name"), mass, *cells, Cell(problems)])
    return table(("link", "kg", *(" ".join(one) for one in who), "the file"), rows)


def _coloured(reading: LinkReading) -> Cell:
    kinds = {True: "converges", False: "disagrees", None: "absent"}
    return Cell(
        cell_text(reading), "failed" if reading.kind == "refused" else kinds[reading.agrees]
    )


def _card(link: InspectedLink, drawn: dict[Who, TraceStyle]) -> dict[str, object]:
    """One link: numbers, pictures, faults of the file, and the line that corrects it."""
    stated = link.link.stated
    otherwise = [
        reading for reading in link.readings if reading.agrees is False and reading.body is not None
    ]
    solids = list(_solids(stated, otherwise, drawn))
    lines = (line_without_rotation(link, reading) for reading in link.readings)
    return {
        "name": printable(link.link.name),
        "where": printable(link.link.where),
        "problems": tuple(problem.text for problem in link.problems),
        "numbers": _numbers(stated, link.readings),
        "views": views(solids) if any(s.squares is not None for s in solids) else [],
        "solids": solids,
        "curves": _curves(otherwise, drawn),
        "line": next(filter(None, lines), ""),
    }


def _solids(
    stated: Stated | None, otherwise: Sequence[LinkReading], drawn: dict[Who, TraceStyle]
) -> Iterator[Solid]:
    if stated is not None:
        squares = solid_squares(stated.mass, stated.inertia)
        yield Solid(FILES_OWN, INK, "solid", stated.com, squares)
    for reading in otherwise:
        assert reading.body is not None, "only what holds a body holds another one"
        style = drawn[reading.engine, reading.configuration]
        squares = solid_squares(reading.body.mass, reading.body.inertia_com)
        yield Solid(reading.who, style.colour, style.dash, reading.body.com, squares)


def _curves(
    otherwise: Sequence[LinkReading], drawn: dict[Who, TraceStyle]
) -> dict[str, Any] | None:
    """Curves of the attitude difference over time, of the bodies that are possible."""
    curves: list[tuple[str, TraceStyle, FloatArray]] = []
    for reading in otherwise:
        if reading.attitude_apart_deg is None or reading.expected is None or reading.body is None:
            continue
        apart = attitude_apart(reading.expected.inertia, reading.body.inertia_com, TIMES)
        if apart is not None:
            style = drawn[reading.engine, reading.configuration]
            curves.append((reading.who, style, np.degrees(apart)))
    return time_curves(TIMES, curves) if curves else None


def _numbers(stated: Stated | None, readings: Sequence[LinkReading]) -> Table:
    rows, nothing = [], [Cell("")] * 3
    if stated is not None:
        rows.append([Cell(FILES_OWN, "name"), *_body(stated.mass, stated.com, stated.inertia)])
        rows[-1] += nothing
    for one in readings:
        got = one.body
        body = _body(got.mass, got.com, got.inertia_com) if got else nothing
        rows.append([Cell(one.who, "name"), *body, *_verdict(one)])
    heads = (
        "",
        "kg",
        "com, m",
        "principal moments, kg m²",
        "axes turned",
        "attitude off, 1 s and 3 s",
        "",
    )
    return table(heads, rows)


def _body(mass: float, com: FloatArray, inertia: FloatArray) -> list[Cell]:
    return [
        figure(f"{mass:.4g}"),
        figure(", ".join(f"{x:.3g}" for x in com)),
        figure(", ".join(f"{moment:.3g}" for moment in principal_moments(inertia))),
    ]


def _verdict(reading: LinkReading) -> list[Cell]:
    apart = reading.attitude_apart_deg
    turned = "" if reading.difference is None else f"{reading.difference.axes_deg:.3g}°"
    angles = "" if apart is None else ", ".join(f"{angle:.3g}°" for angle in apart.values())
    verdict = "as the file states it" if reading.agrees else reading.cause or "nothing to compare"
    if reading.agrees is not False:
        turned = angles = ""
    if reading.kind == "refused":
        verdict = "refuses the file"
    return [figure(turned), figure(angles), Cell(printable(verdict))]
