"""Results on the terminal: a matrix of verdicts, the reasons, and the same as JSON."""

from dataclasses import asdict
from typing import Any

from ....scenarios import errors_by_key
from ....scenarios.fastest_rate import fastest_rate
from ...pages.analysis.survival import Survival, survival
from ...results.records import Key, Row, SignalVerdict, Verdict
from ...results.store import Results
from ...results.verdict_words import VERDICT
from ..terminal import table


def print_results(results: Results) -> None:
    """Print a table of verdicts, scenes × methods, then the reason of each but `converges`."""
    methods = {
        (v.key.engine, v.key.method): ", as shipped" if v.as_shipped else ""
        for v in results.verdicts
    }
    words = {
        (v.key.scenario, v.key.engine, v.key.method): v.verdict + ("!" if v.unmet else "")
        for v in results.verdicts
    }
    table(
        [
            {"scene": scene}
            | {
                f"{e} {m}{how}": words.get((scene, e, m), "")
                for (e, m), how in sorted(methods.items())
            }
            for scene in sorted({v.key.scenario for v in results.verdicts})
        ]
    )
    differing = [v for v in results.verdicts if VERDICT[v.verdict].needs_reason]
    for verdict in results.verdicts:
        if verdict.unmet or (verdict in differing and not verdict.as_shipped):
            print(_sentence(verdict))
    if shipped := sum(verdict.as_shipped for verdict in differing):
        print(f"{shipped} times an engine as shipped does not converge; the report says why.")


def results_as_json(results: Results) -> dict[str, Any]:
    """Rows and verdicts with the names that scripts rely on."""
    return {
        "rows": [row_record(row) for row in results.rows],
        "verdicts": verdict_records(results),
    }


def verdict_records(results: Results) -> list[dict[str, Any]]:
    """Verdicts, each with the largest timestep that its method survives."""
    fastest_rates = {
        name: fastest_rate(scene.scenario, scene.solution.trajectory.omega_body)
        for name, scene in results.scenes.items()
    }
    rows: dict[Key, list[Row]] = {}
    for row in results.rows:
        rows.setdefault(row.key, []).append(row)
    return [
        verdict_record(verdict)
        | _survival_record(
            survival(rows.get(verdict.key, ()), fastest_rates.get(verdict.key.scenario))
        )
        for verdict in results.verdicts
    ]


def _survival_record(survival: Survival | None) -> dict[str, Any]:
    return {
        "largest_surviving_timestep": survival.timestep if survival else None,
        "largest_surviving_turn": survival.turn if survival else None,
        "all_tried_survived": survival.at_least if survival else None,
    }


def row_record(row: Row) -> dict[str, Any]:
    """A run with the names that scripts rely on."""
    return asdict(row.key) | {
        "engine_version": row.engine_version,
        "timestep": row.timestep,
        "stock": row.stock,
        "outcome": row.outcome,
        "reason": row.reason,
        "cause": row.cause,
        "survived": row.survived,
        "stopped_at": row.stopped_at,
        **errors_by_key(row.errors),
        "drifts": row.drifts,
        "defects": {name: asdict(one) for name, one in (row.defects or {}).items()} or None,
        "reference_uncertainty": row.uncertainty,
        "steps": row.steps,
        "seconds_per_step": row.seconds_per_step,
        "seconds_spread": row.seconds_spread,
        "wall_seconds_per_step": row.wall_seconds_per_step,
    }


def verdict_record(verdict: Verdict) -> dict[str, Any]:
    """A verdict with the names that scripts rely on."""
    return asdict(verdict.key) | {
        "verdict": verdict.verdict,
        "reason": verdict.reason,
        "signal": verdict.signal,
        "order": verdict.order,
        "limit_error": verdict.limit_error,
        "tolerance": verdict.tolerance,
        "signals": {one.signal: _signal_record(one) for one in verdict.signals} or None,
        "unmet": list(verdict.unmet),
        "as_shipped": verdict.as_shipped,
        "known": verdict.is_expected_failure,
    }


def _signal_record(signal: SignalVerdict) -> dict[str, Any]:
    return {name: value for name, value in asdict(signal).items() if name != "signal"}


def _sentence(verdict: Verdict) -> str:
    key = verdict.key
    unmet = "".join(f"\n  unmet expectation: {line}" for line in verdict.unmet)
    how = " (as shipped)" if verdict.as_shipped else ""
    where = f"{key.scenario}, {key.engine} {key.method}{how}"
    return f"{where}: {verdict.verdict}: {verdict.reason}{unmet}"
