"""The page of a user's model: how engines hold its links, the worst first, and remedies."""

from collections.abc import Sequence
from pathlib import Path

from ...engines import BodyReading
from ...engines.users_models import principal_moments
from ...scenarios import printable
from ...scenarios.regular_files import file_name
from ..pages.tables import Cell, Table, figure, table
from ..pages.templating import ReportFolder, templates, write_assets
from .findings import (
    LEGEND,
    WHAT_TO_DO,
    cell_text,
    configuration_of,
    line_without_rotation,
    sections,
    weight_in_words,
    worst_links,
)
from .inspection import InspectedLink, Inspection, LinkReading

#: Number of links that are described; the table has all.
MOST_SHOWN = 12
#: Name of the file's own body.
FILES_OWN = "the file"


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
    model, worst = inspection.model, worst_links(inspection)
    return {
        "file": printable(str(model.path)),
        "format": model.format.upper(),
        "links": len(inspection.links),
        "stated": sum(li.link.stated is not None for li in inspection.links),
        "wrong": sum(not link.is_well for link in inspection.links),
        "is_well": inspection.is_well,
        "weight": weight_in_words(inspection),
        "configurations": _configurations(inspection),
        "refusals": [(" ".join(who), reason) for who, reason in inspection.refusals.items()],
        "cards": [_card(link) for link in worst[:MOST_SHOWN]],
        "left": len(worst) - len(worst[:MOST_SHOWN]),
        "sections": sections(inspection),
        "what_to_do": WHAT_TO_DO,
        "legend": LEGEND,
        "all_links": _all_links(inspection),
    }


def _configurations(inspection: Inspection) -> Table:
    """Table of the configurations, and how many links each holds as the file states them."""
    rows = []
    for readings in zip(*(link.readings for link in inspection.links), strict=True):
        first = readings[0]
        counts = [
            str(sum(one.agrees is True for one in readings)),
            str(sum(one.agrees is False for one in readings)),
            str(sum(one.body is None for one in readings)),
        ]
        cells = [figure(count) for count in counts]
        if first.kind == "refused":
            cells = [Cell("refused", "failed"), figure(""), figure("")]
        summary = configuration_of(*first.column).summary
        rows.append([Cell(first.who, "name", summary), Cell(first.engine_version), *cells])
    return table(("engine and configuration", "version", "as stated", "otherwise", "fused"), rows)


def _all_links(inspection: Inspection) -> Table:
    kinds = {True: "converges", False: "disagrees", None: "absent"}
    rows = []
    for link in inspection.links:
        stated = link.link.stated
        cells = [
            Cell(cell_text(one), "failed" if one.kind == "refused" else kinds[one.agrees])
            for one in link.readings
        ]
        mass = figure("" if stated is None else f"{stated.mass:.3g}")
        wrong = ", ".join(problem.kind for problem in link.problems)
        rows.append([Cell(printable(link.link.name), "name"), mass, *cells, Cell(wrong)])
    return table(("link", "kg", *map(" ".join, inspection.columns), "the file"), rows)


def _card(link: InspectedLink) -> dict[str, object]:
    """One link: numbers, faults of the file, and the line that corrects it."""
    return {
        "name": printable(link.link.name),
        "where": printable(link.link.where),
        "problems": tuple(problem.text for problem in link.problems),
        "numbers": _numbers(link),
        "line": line_without_rotation(link),
    }


def _numbers(link: InspectedLink) -> Table:
    rows = []
    if link.link.stated is not None:
        rows.append([Cell(FILES_OWN, "name"), *_body(link.link.stated), *[Cell("")] * 3])
    for one in link.readings:
        rows.append([Cell(one.who, "name"), *_body(one.body), *_verdict(one)])
    heads = (
        *("", "kg", "com, m", "principal moments, kg m²"),
        *("axes turned", "attitude off, 1 s and 3 s", ""),
    )
    return table(heads, rows)


def _body(body: BodyReading | None) -> list[Cell]:
    if body is None:
        return [Cell("")] * 3
    moments = ", ".join(f"{moment:.3g}" for moment in principal_moments(body.inertia_com))
    com = ", ".join(f"{x:.3g}" for x in body.com)
    return [figure(f"{body.mass:.4g}"), figure(com), figure(moments)]


def _verdict(reading: LinkReading) -> list[Cell]:
    verdict = "as the file states it" if reading.agrees else reading.cause or "nothing to compare"
    turned = angles = ""
    if reading.agrees is False and reading.difference is not None:
        apart = reading.attitude_apart_deg or {}
        turned = f"{reading.difference.axes_deg:.3g}°"
        angles = ", ".join(f"{angle:.3g}°" for angle in apart.values())
    if reading.kind == "refused":
        verdict = "refuses the file"
    return [figure(turned), figure(angles), Cell(printable(verdict))]
