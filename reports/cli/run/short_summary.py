"""A summary of a run's results, in at most twenty lines of eighty columns: the answer first."""

import math
import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from ....engines.fault import ENVIRONMENTAL
from ....scenarios import Signal
from ...pages.analysis.best_choice import BOUNDS, best_choice, within_in_words
from ...pages.analysis.finest_timesteps import finest_in_words, finest_timesteps
from ...pages.analysis.questions import at_stock, leading
from ...pages.analysis.report_data import ReportData, report_data
from ...pages.analysis.wording import duration, plural
from ...results.records import Row
from ...results.results import Results
from ...results.verdict_words import LISTED
from ...results.verdicts import Verdict
from ..terminal import command
from .summary import aligned, of_signals

WIDTH = 80
#: Largest number of lines for one reason; largest number of scenes whose best choices are printed
#: one by one.
REASON_LINES, SCENES_PRINTED = 3, 3
#: Largest number of methods whose errors are printed: first methods as shipped, then the most
#: accurate clean method of each engine, the smallest errors first among either. Room is kept for
#: at least `OTHERS` clean methods.
METHODS_SHOWN, OTHERS = 8, 3
#: Angles from this on, degrees, are printed as whole numbers.
LEAST_WHOLE = 9.5


def short_summary(results: Results, path: Path, timesteps: Sequence[float] = ()) -> list[str]:
    """Return the lines of the summary of a run.

    Parameters
    ----------
    path : the result file, which a printed command names
    timesteps : timesteps that the user asked for, s; if there are any, the errors at these
        timesteps are printed in place of those at stock timesteps and of best choices
    """
    report = report_data(results)
    lines = [
        *_counts(results.verdicts),
        *_first_failure(results.verdicts, path),
        *_lost(results.rows),
    ]
    if timesteps:
        return [*lines, *_asked_for(results.rows, timesteps)]
    return [*lines, *_at_stock(report), *_best(report), *_finest(report)]


def _counts(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Yield lines with the number of scenes and verdicts, and how often each verdict occurs.

    Clean methods and methods as shipped are counted apart.
    """
    scenes = len({verdict.key.scenario for verdict in verdicts})
    yield f"{plural(scenes, 'scene')}, {plural(len(verdicts), 'verdict')}."
    for of_what, shipped in (
        ("With the effects of the scene alone", False),
        ("As shipped, with the engine's defaults", True),
    ):
        counts = Counter(v.verdict for v in verdicts if v.as_shipped == shipped)
        if counts:
            words = ", ".join(f"{k.word} {counts[k.word]}" for k in LISTED if counts[k.word])
            yield from textwrap.wrap(f"{of_what}: {words}.", WIDTH)


def _first_failure(verdicts: Sequence[Verdict], path: Path) -> Iterator[str]:
    """Yield lines on the first failing verdict, with its reason, and on how many more fail.

    Parameters
    ----------
    path : the result file, which a printed command names
    """
    wrong = [verdict for verdict in verdicts if not verdict.agrees]
    if not wrong:
        return
    first = wrong[0]
    key = first.key
    text = f"Fails: {key.scenario}, {key.label}: {'; '.join(first.findings)}"
    yield from textwrap.wrap(
        text, WIDTH, max_lines=REASON_LINES, placeholder=" …", break_on_hyphens=False
    )
    if len(wrong) > 1:
        more = "1 more fails" if len(wrong) == 2 else f"{len(wrong) - 1} more fail"
        yield f"{more}: '{command('rows', path)} --verdicts' has them all."


def _lost(rows: Sequence[Row]) -> Iterator[str]:
    """Yield lines with the number of runs that failed because of the machine, and one reason."""
    lost = [row for row in rows if row.cause in ENVIRONMENTAL]
    if lost:
        text = f"{plural(len(lost), 'run')} lost by the machine's fault: {lost[0].reason}"
        yield from textwrap.wrap(text, WIDTH, max_lines=REASON_LINES, placeholder=" …")
        yield "The same command makes them again."


def _at_stock(report: ReportData) -> Iterator[str]:
    """Yield a heading, and a line with the attitude errors of each method that is shown.

    The line has the median and the largest error over the scenes, at the stock timestep. For each
    engine, one method as shipped and the most accurate clean method are shown, but at most
    `METHODS_SHOWN` in all.
    """
    by_pair = {one.pair: one for one in at_stock(report)}
    first = [by_pair[pair] for pair in leading(report) if pair in by_pair]
    first.sort(key=lambda one: one.middle)
    others = [one for one in first if not one.shipped]
    defaults = [one for one in first if one.shipped][: METHODS_SHOWN - len(others[:OTHERS])]
    shown = [*defaults, *others[: METHODS_SHOWN - len(defaults)]]
    if shown:
        yield f"{'Attitude error, stock timestep (*as shipped)':45}{'median':>8}  worst"
    for one in shown:
        name = f"{'*' if one.shipped else ' '} {one.label}, {duration(one.timestep)}"
        unfinished = "blew up" if one.blew_up else "failed"
        middle, most = (
            unfinished if math.isinf(error) else _degrees(error)
            for error in (one.middle, one.largest)
        )
        yield f"{name:45}{middle:>8}  {most} {one.worst}"[:WIDTH]


def _best(report: ReportData) -> Iterator[str]:
    """Yield lines with the best choice of method and timestep for each scene, its error and cost.

    If there are best choices for more than `SCENES_PRINTED` scenes, the lines name the methods that
    are the best choice most often, instead.
    """
    choices = {scene.name: best_choice(scene) for scene in report.scenes}
    best = {name: choice for name, choice in choices.items() if choice is not None}
    if not best:
        return
    if len(best) > SCENES_PRINTED:
        methods = Counter(choice.runs.label for choice in best.values())
        often = ", ".join(f"{name} on {count}" for name, count in methods.most_common(3))
        yield from textwrap.wrap(f"Best choice ({within_in_words(BOUNDS)}): {often}.", WIDTH)
        return
    for name, choice in best.items():
        assert choice.row.errors is not None, "only a run with errors is chosen"
        price = f", {choice.cost:.1e} CPU s per simulated s" if choice.cost else ""
        method = f"{choice.runs.label} at {duration(choice.timestep)}"
        yield f"Best for {name}: {method}"
        yield f"    {_degrees(math.degrees(choice.row.errors.attitude))} off{price}"


def _finest(report: ReportData) -> Iterator[str]:
    """Yield lines on methods whose errors rounding makes grow, or whose rounding is biased."""
    for sentence in finest_in_words(list(finest_timesteps(report).values())):
        yield from textwrap.wrap(f"{sentence}.", WIDTH, max_lines=REASON_LINES, placeholder=" …")


def _asked_for(rows: Sequence[Row], timesteps: Sequence[float]) -> Iterator[str]:
    """Yield a heading, and a line for each run: its errors, or how it ended if it has none.

    Parameters
    ----------
    timesteps : the timesteps of the runs that are shown, s
    """
    shown = [row for row in rows if row.timestep in timesteps]
    errors = (dict(row.errors) for row in shown if row.errors)
    headings, *numbers = aligned(of_signals(errors, _brief)) or [""]
    width = WIDTH - len(headings)
    yield f"{'scene, method, timestep':{width}}{headings}"
    for row in shown:
        ended = f" {row.outcome}: {row.cause or row.reason}"
        yield (_named_run(row, width) + (numbers.pop(0) if row.errors else ended))[:WIDTH]


def _brief(signal: Signal, error: float) -> str:
    """Return an error in a signal as short text, an angle in degrees."""
    return _degrees(math.degrees(error)) if signal.unit == "rad" else f"{error:.0e}"


def _named_run(row: Row, width: int) -> str:
    """Return a run's scene, method and timestep as a text that is padded to a width, characters.

    Names that are too long are cut; the timestep never is.
    """
    timestep = f" {duration(row.timestep)}"
    name, room = f"{row.key.scenario} {row.key.label}", width - len(timestep) - 1
    return f"{name if len(name) <= room else f'{name[: room - 1]}…'}{timestep}".ljust(width)


def _degrees(degrees: float) -> str:
    """Return an angle, degrees, as short text."""
    return f"{degrees:.0f}°" if degrees >= LEAST_WHOLE else f"{degrees:.1g}°"
