"""The page of a version report: what changed, and verdicts, errors and times version by version."""

from collections.abc import Callable, Sequence
from pathlib import Path

from ...harness.version_changes import NOTABLE, OverVersions, VersionChange
from ...harness.version_runs import VersionRun
from ..analysis.wording import number
from ..tables import Cell, Table, figure, table, verdict_cell
from ..templating import templates, write_assets
from ..written import ReportFolder

#: Printed where there is no number.
NONE = "–"


def write_version_page(
    engine: str, over: Sequence[OverVersions], timestep: float, folder: Path
) -> Path:
    """Write `ENGINE-versions.html` and its style sheet; returns the page.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    written = ReportFolder(folder)
    write_assets(written, "style.css")
    versions = [run.version for run in over[0].runs] if over else []
    changes = [change for one in over for change in one.changes]
    content = {
        "engine": engine,
        "versions": versions,
        "timestep": number(timestep),
        "factor": number(NOTABLE),
        "worse": sum(change.is_worse for change in changes),
        "alike": sum(not change.what for change in changes),
        "count": len(changes),
        "changes": _changes(changes),
        "by_version": _by_version(over, versions, _verdict),
        "errors": _by_version(over, versions, _error),
        "times": _by_version(over, versions, _time),
    }
    page = templates().get_template("versions.html").render(root="", **content)
    return written.write(f"{engine}-versions.html", page)


def _changes(changes: Sequence[VersionChange]) -> Table:
    """The comparisons with a change: regressions first, round-off last."""
    shown = sorted((c for c in changes if c.what), key=lambda c: (not c.is_worse, c.is_round_off))
    headings = ("scene", "method", "from", "to", "what changed", "")
    return table(
        headings,
        [(c.scenario, c.method, c.older, c.newer, c.what, _regression(c)) for c in shown],
    )


def _regression(change: VersionChange) -> Cell:
    return Cell("✗ worse", "disagrees") if change.is_worse else Cell("")


def _by_version(
    over: Sequence[OverVersions],
    versions: Sequence[str],
    cell: Callable[[VersionRun, OverVersions], Cell],
) -> Table:
    rows: list[list[Cell | str]] = [
        [one.scenario, one.method, *(cell(run, one) for run in one.runs)] for one in over
    ]
    return table(("scene", "method", *versions), rows)


def _verdict(run: VersionRun, _: OverVersions) -> Cell:
    verdict = run.verdict
    order = "" if verdict.order is None else f"order {verdict.order:.2f}"
    return verdict_cell(verdict.verdict, detail=order or _short(verdict.reason))


def _short(reason: str) -> str:
    return reason.partition(";")[0]


def _error(run: VersionRun, _: OverVersions) -> Cell:
    if run.errors is None:
        return Cell(run.outcome, detail=_short(run.reason))
    return Cell(number(run.errors.omega), "number", f"{number(run.errors.attitude)} rad")


def _time(run: VersionRun, one: OverVersions) -> Cell:
    """Time of a step, as a multiple of that of the oldest version timed."""
    first = next((other.seconds for other in one.runs if other.seconds), ())
    if not run.seconds:
        return figure(NONE)
    ratios = sorted(new / old for old, new in zip(first, run.seconds, strict=True))
    return Cell(f"{ratios[len(ratios) // 2]:.2f}", "number", f"{ratios[0]:.2f} to {ratios[-1]:.2f}")
