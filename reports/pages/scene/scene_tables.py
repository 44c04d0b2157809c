"""The tables on a scene's page: its reference, verdicts, conserved quantities and runs."""

import math
from collections import Counter

from ....reference import facts, invariants
from ....scenarios import EFFECTS, SIGNALS, FloatArray, Scenario, Signal
from ...harness.scene_checks.published import published_values
from ...results.records import Row
from ...results.results import SceneResult
from ..analysis.report_data import MethodRuns, SceneRuns
from ..analysis.timesteps import in_words, survival
from ..analysis.wording import (
    NOTHING,
    count,
    limited_errors,
    number,
    observed,
    order,
    plural,
)
from ..analysis.work_precision import cost, curve_of
from ..overview.overview import reason_of
from ..tables import (
    Captioned,
    Cell,
    Table,
    figure,
    method_anchor,
    named,
    records,
    table,
    verdict_cell,
)


def effects_table(scenario: Scenario) -> Table:
    """Return a table that says of each effect whether the scene has it."""
    rows = [
        (
            name.replace("_", ", axes of the "),
            "simulated" if name in scenario.called_for else "left out",
        )
        for name in EFFECTS
    ]
    return table(("effect", "here"), rows)


def exact_motion_table(solved: SceneResult) -> Table:
    """Return a table of the reference's uncertainty and conditioning in each signal."""
    known = {
        "uncertainty": solved.solution.uncertainty,
        "what one ulp in the start does": solved.solution.conditioning,
    }
    return records(
        {"signal": Cell(signal.error_title, "name")}
        | {what: figure(number(signal.shown * of[signal.name])) for what, of in known.items()}
        for signal in SIGNALS
        if signal.name in dict(solved.solution.uncertainty)
    )


def facts_table(solved: SceneResult) -> Table:
    """Return a table of numbers that are derived from the scene, with their units and meanings."""
    rows = [
        (fact.name, figure(observed(fact.value)), fact.unit, fact.meaning)
        for fact in facts(solved.scenario)
    ]
    return table(("fact", "value", "unit", "meaning"), rows)


def verdict_table(scene: SceneRuns) -> Table:
    """Return a table of the verdicts on a scene's methods; each row has an anchor for links."""
    made = records(_verdict_row(scene, runs) for runs in scene.methods)
    anchors = tuple(method_anchor(runs.engine, runs.method) for runs in scene.methods)
    return Table(made.headings, made.rows, anchors)


def signals_table(scene: SceneRuns) -> Table:
    """Return a table with a row for each method and signal, about the error of the finest run.

    Each row also has the observed order, and the timestep below which rounding makes the error
    grow.
    """
    return records(
        {
            **named(runs.pair),
            "signal": signal.error_title,
            "timestep, s": figure(number(runs.finest.timestep)),
            "error": figure(number(error * signal.shown)),
            "order found": figure(order(curve.observed_order) if error else NOTHING),
            "declared": figure(_declared(runs, signal)),
            "rounding takes over below, s": figure(number(floor.timestep if floor else None)),
            "where the error is": figure(number(floor.error * signal.shown if floor else None)),
        }
        for runs in scene.methods
        for signal in scene.signals
        if scene.solved and runs.finest and runs.finest.errors
        for error, curve in [(runs.finest.errors[signal.name], curve_of(scene, runs, signal.name))]
        for floor in [curve.least]
    )


def _declared(runs: MethodRuns, signal: Signal) -> str:
    """Return a method's declared order of accuracy in a signal as text; `NOTHING` if not known."""
    declared = runs.declared
    if declared is None:
        return NOTHING
    return str(signal.declared_order(declared.order, declared.attitude_order))


def published_table(scenario: Scenario) -> Table | None:
    """Return a table of published values beside exact ones; None if there are none."""
    holds = {True: Cell("✓ holds", "converges"), False: Cell("✗ does not hold", "disagrees")}
    made = records(
        {
            "quantity": Cell(value.quantity, "name"),
            "t, s": figure(f"{value.published.t:g}"),
            "printed": figure(_components(value.printed)),
            "ours": figure(_components(value.ours)),
            "difference": figure(number(value.difference) if value.is_known else NOTHING),
            "tolerance": figure(number(value.published.tolerance)),
            "": holds[value.holds] if value.is_known else Cell("the exact motion ends before"),
            "source": value.published.source,
        }
        for value in published_values(scenario)
    )
    return made if made.rows else None


def drifts_table(scene: SceneRuns) -> Table | None:
    """Return a table of the relative drifts of each method's finest run.

    Methods whose finest run has no drifts are left out. None is returned if the motion conserves
    nothing, or if no method is left.
    """
    laws = [invariant.law for invariant in invariants(scene.exact.scenario)]
    shown = [(runs, runs.finest) for runs in scene.methods]
    made = records(
        {
            **named(runs.pair),
            "timestep, s": figure(number(row.timestep)),
            **{law.formula: figure(number(row.drifts.get(law.name))) for law in laws},
        }
        for runs, row in shown
        if row is not None and row.drifts is not None
    )
    return made if laws and made.rows else None


def runs_tables(scene: SceneRuns) -> list[Captioned]:
    """Return a table for each method, which has the errors and the cost of each run in a row."""
    headings = (
        "timestep, s",
        "steps",
        *(signal.error_title for signal in scene.signals),
        "largest drift, relative",
        "CPU s a simulated s",
        "outcome",
    )
    return [
        Captioned(
            runs.label,
            _summary(runs),
            table(headings, [_run_row(scene, row) for row in runs.rows]),
        )
        for runs in scene.methods
    ]


def printed(scene: SceneRuns) -> list[tuple[str, str]]:
    """Return pairs of a method and a text that its engine printed; the same pair is given once."""
    outputs = [(runs.label, row.printed) for runs in scene.methods for row in runs.rows]
    return list(dict.fromkeys((label, text) for label, text in outputs if text.strip()))


def _verdict_row(scene: SceneRuns, runs: MethodRuns) -> dict[str, Cell | str]:
    """Return a method's verdict, its numbers and reason as a table row, by the columns' headings.

    If there is no verdict yet, the row says so.
    """
    verdict = runs.verdict
    if verdict is None:
        return {
            **named(runs.pair),
            "verdict": Cell("no verdict", "absent"),
            "order of steps": figure(NOTHING),
            "tail": figure(NOTHING),
            "known to": figure(NOTHING),
            "stable up to, s": figure(NOTHING),
            "why": "stopped early",
        }
    survives, turn = in_words(survival(runs.rows, scene.fastest_rate if scene.solved else None))
    stable = Cell(survives, "number", f"{turn} rad a step" if turn != NOTHING else "")
    declared = f"declared {runs.declared.order}" if runs.declared and verdict.order else ""
    tail, known_to = verdict.tail, verdict.steps.known_to if verdict.steps else None
    level = f"level {verdict.level:.0e}" if tail is not None and tail < verdict.level else ""
    return {
        **named(runs.pair),
        "verdict": verdict_cell(verdict.verdict, verdict.ground),
        "order of steps": Cell(str(verdict.order or NOTHING), "number", declared),
        "tail": Cell(number(tail), "number", level),
        "known to": figure(number(known_to)),
        "stable up to, s": stable,
        "why": Cell(reason_of(verdict), note=_besides(runs)),
    }


def _besides(runs: MethodRuns) -> str:
    """Return a sentence on what acted without the scene's calling for it; empty if nothing did."""
    names = dict.fromkeys(name for row in runs.rows for name in row.unasked)
    return f"Active though the scene does not call for it: {', '.join(names)}." if names else ""


def _summary(runs: MethodRuns) -> str:
    """Return a line about a method: the engine's version, the verdict, and how its runs ended."""
    ended = Counter(row.outcome for row in runs.rows if row.made)
    versions = dict.fromkeys(row.engine_version for row in runs.rows)
    outcomes = ", ".join(f"{amount} {outcome}" for outcome, amount in ended.items())
    verdict = runs.verdict.verdict if runs.verdict else "no verdict"
    return f"{', '.join(versions)} · {verdict} · {plural(sum(ended.values()), 'run')}: {outcomes}"


def _components(values: FloatArray) -> str:
    """Return numbers as text, with nine digits each, and a dash for each NaN."""
    return ", ".join("—" if math.isnan(value) else f"{value:.9g}" for value in values)


def _run_row(scene: SceneRuns, row: Row) -> list[Cell | str]:
    """Return a run as a table row: timestep, steps, errors, largest drift, cost, and outcome."""
    errors = [NOTHING] * len(scene.signals)
    if row.errors is not None:
        names = [signal.name for signal in scene.signals]
        errors = limited_errors(row.errors, scene.uncertainty(row), names)
    when = f" at {number(row.stopped_at)} s" if row.stopped_at is not None else ""
    cause = f" ({row.cause})" if row.cause else ""
    outcome = f"{row.outcome}{cause}{when}" if row.made else "not run"
    return [
        Cell(
            number(row.timestep) if row.timestep else NOTHING,
            "number",
            "stock" if row.stock else "",
        ),
        figure(count(row.steps)),
        *map(figure, errors),
        figure(_largest_drift(row)),
        figure(number(cost(row))),
        Cell(outcome, row.outcome, note=row.reason),
    ]


def _largest_drift(row: Row) -> str:
    """Return a run's largest drift, and the name of what drifts, as text; `NOTHING` if unknown."""
    if not row.drifts:
        return NOTHING
    name = max(row.drifts, key=lambda law: row.drifts[law] if row.drifts else 0.0)
    return f"{number(row.drifts[name])} {name}"
