"""Runs and verdicts as lines, of 80 columns unless numbers need more, and as JSON."""

import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from ....scenarios import SIGNALS, Signal
from ....scenarios.fastest_rate import fastest_rate
from ...pages.analysis.best_choice import finest_useful
from ...pages.analysis.report_data import report_data
from ...pages.analysis.rounding_bias import rounding_bias
from ...pages.analysis.timesteps import Survival, survival
from ...pages.analysis.work_precision import cost
from ...results.as_json import as_json
from ...results.records import Key, Row
from ...results.results import Results
from ...results.verdict_words import VERDICT
from ...results.verdicts import MADE, Verdict

WIDTH = 80
#: Widths of the names of scene and method in a verdict's line, characters.
SCENE, METHOD = 25, 25
#: Largest number of lines of a reason.
REASON_LINES = 3
#: Width of the column that shows the values of `Row.varied`, characters.
VARIED = 24


def run_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a heading for each method on each scene, and below it a line for each run.

    The line of a run begins with its timestep, and a star before it if that is a stock timestep.
    For a run on a member of an ensemble, it begins with seed and member instead; for one with some
    of the engine's defaults switched off, with the defaults that are left.

    Parameters
    ----------
    rows : the runs, sorted by method and scene
    """
    for (key, varied), runs in groupby(rows, key=lambda row: (row.key, tuple(row.varied))):
        yield cut(
            "; ".join([f"{key.scenario}: {key.label}", ", ".join(varied)][: 1 + bool(varied)]),
            WIDTH,
        )
        group = list(runs)
        finished = [row for row in group if row.errors]
        columns = of_signals(dict(row.errors) for row in finished if row.errors)
        if not varied:
            costs = ("" if (n := cost(row)) is None else f"{n:.1e}" for row in finished)
            columns.append(["CPU s/s", *costs])
        headings, *numbers = aligned(columns) or [""]
        yield f"  {'at':{VARIED}}{headings}" if varied else f"  {'timestep, s':>11} {headings}"
        for row in group:
            begun = _begun(row)
            yield begun + numbers.pop(0) if row.errors else cut(begun + _ended(row), WIDTH)


def of_signals(
    errors: Iterable[Mapping[str, float]],
    words: Callable[[Signal, float], str] = lambda _, error: f"{error:.1e}",
) -> list[list[str]]:
    """Return a column for each signal in which any run has an error: its label, then the errors.

    Parameters
    ----------
    errors : the errors of each run, by signal
    words : function that returns an error in a signal as text
    """
    known = list(errors)
    shown = [signal for signal in SIGNALS if any(signal.name in one for one in known)]
    return [
        [s.label, *(words(s, one[s.name]) if s.name in one else "" for one in known)] for s in shown
    ]


def aligned(columns: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table whose columns are aligned on the right; none without columns."""
    widths = [max(map(len, column)) + 1 for column in columns]
    return [
        "".join(text.rjust(width) for text, width in zip(line, widths, strict=True))
        for line in zip(*columns, strict=True)
    ]


def verdict_lines(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Yield a heading, then a line for each verdict with its reasons in indented lines below.

    The reasons are all unmet expectations, and the verdict's own reason unless the verdict is
    `converges` or `unsupported`.
    """
    yield f"{'scene':{SCENE}} {'method':{METHOD}} {'verdict':11} {'order':>5} {'known to':>8}"
    for verdict in verdicts:
        key = verdict.key
        order = "" if verdict.order is None else f"{verdict.order}"
        known = f"{verdict.steps.known_to:.1e}" if verdict.steps else ""
        yield (
            f"{cut(key.scenario, SCENE):{SCENE}} {cut(key.label, METHOD):{METHOD}} "
            f"{verdict.verdict:11} {order:>5} {known:>8}"
        ).rstrip()
        reasons = [
            *verdict.unmet,
            *([verdict.reason] if VERDICT[verdict.verdict].needs_reason else []),
        ]
        yield from textwrap.wrap(
            "; ".join(reasons),
            WIDTH,
            initial_indent="    ",
            subsequent_indent="    ",
            max_lines=REASON_LINES,
            placeholder=" …",
            break_on_hyphens=False,
        )


def cut(text: str, width: int) -> str:
    """Return a text, cut to `width` characters if it is longer; it then ends in an ellipsis."""
    return text if len(text) <= width else f"{text[: width - 1]}…"


def _begun(row: Row) -> str:
    """Return the beginning of a run's line: what is varied in the run, or else its timestep, s.

    What may be varied (`Row.varied`) is the member of an ensemble, or the engine's defaults.
    """
    if row.varied:
        values = "  ".join(map(_value, row.varied.values()))
        return f"  {cut(values.rstrip(), VARIED - 1):{VARIED}}"
    return f"{'*' if row.stock else ' '} {row.timestep:11.5g} "


def _value(varied: object) -> str:
    """Return a value that is varied in a run (`Row.varied`) as text; a number is padded."""
    if isinstance(varied, int | float):
        # A member, its seed and a timestep fit into `VARIED` together.
        return f"{varied:<4}" if isinstance(varied, int) else f"{varied:<11.6g}"
    return ", ".join(map(str, varied)) if isinstance(varied, list) else f"{varied}"


def _ended(row: Row) -> str:
    """Return, in words, how and when a run ended, and why."""
    when = f" at {row.stopped_at:.3g} s" if row.stopped_at is not None else ""
    return f"{row.outcome if row.made else 'not run'}{when}: {row.reason}"


def results_as_json(results: Results) -> dict[str, Any]:
    """Return a JSON object with the lists `rows` and `verdicts`.

    Their items are what `row_record` and `verdict_records` return. Scripts rely on the keys' names.
    """
    return {
        "rows": [row_record(row) for row in results.rows],
        "verdicts": verdict_records(results),
    }


def verdict_records(results: Results) -> list[dict[str, Any]]:
    """Return verdicts as JSON objects, which have the entries of `verdict_record`.

    Each also has the finest useful timestep of its method, the bias of rounding on the scene, and
    the largest timestep at which runs survived.
    """
    fastest_rates = {
        name: fastest_rate(scene.scenario, scene.solution.trajectory.omega_body)
        for name, scene in results.scenes.items()
    }
    floors = {
        (scene.name, runs.pair): (finest_useful(scene, runs), rounding_bias(runs))
        for scene in report_data(results).scenes
        for runs in scene.methods
    }
    rows: dict[Key, list[Row]] = {}
    for row in results.rows:
        rows.setdefault(row.key, []).append(row)
    return [
        verdict_record(verdict)
        | _floor_record(*floors.get((verdict.key.scenario, verdict.key.pair), (None, None)))
        | _survival_record(
            survival(rows.get(verdict.key, ()), fastest_rates.get(verdict.key.scenario))
        )
        for verdict in results.verdicts
    ]


def _floor_record(finest: float | None, bias: float | None) -> dict[str, Any]:
    """Return a method's finest useful timestep, s, and its bias of rounding, ulp a step, for JSON.

    The keys are `finest_useful_timestep` and `rounding_bias_ulp_a_step`. Either value is None if no
    run shows it.
    """
    return {"finest_useful_timestep": finest, "rounding_bias_ulp_a_step": bias}


def _survival_record(survival: Survival | None) -> dict[str, Any]:
    """Return the largest timestep that a method survives as entries of a JSON object.

    The keys are `largest_surviving_timestep`, s; `largest_surviving_turn`, the turn in such a step
    at the fastest rate, rad; and `all_tried_survived`. If `survival` is None, that timestep is not
    known, and all values are None.
    """
    return {
        "largest_surviving_timestep": survival.timestep if survival else None,
        "largest_surviving_turn": survival.turn if survival else None,
        "all_tried_survived": survival.at_least if survival else None,
    }


def run_records(results: Results) -> list[dict[str, Any]]:
    """Return a JSON object for every run of a result file, those of ensembles too.

    `row_record` says what such an object has.
    """
    return [row_record(row) for row in results.every_row]


def row_record(row: Row) -> dict[str, Any]:
    """Return a run as a JSON object; scripts rely on the names of the keys.

    It has the fields of `Row` without the motion, one entry for the error in each signal, what is
    varied in the run (`variation`), and whether it survived.
    """
    return as_json(row) | {"variation": row.varied, "survived": row.survived}


def verdict_record(verdict: Verdict) -> dict[str, Any]:
    """Return a verdict as a JSON object; scripts rely on the names of the keys.

    It has the fields of `Verdict`, and its properties `reason`, `tail`, `level`, `order` and
    `ground` (`MADE`).
    """
    return as_json(verdict) | {name: getattr(verdict, name) for name in MADE}
