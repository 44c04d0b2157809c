"""Results as JSON, with the names that scripts rely on."""

from typing import Any

from ....scenarios.fastest_rate import fastest_rate
from ...pages.analysis.timesteps import Survival, survival
from ...results.as_json import as_json
from ...results.records import Key, Row, Verdict
from ...results.store import Results


def results_as_json(results: Results) -> dict[str, Any]:
    """Rows and verdicts with the names that scripts rely on."""
    return {
        "rows": [row_record(row) for row in results.rows],
        "verdicts": verdict_records(results),
        "encodings": [as_json(runs) for runs in results.encodings],
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
    return as_json(row) | {"survived": row.survived}


def verdict_record(verdict: Verdict) -> dict[str, Any]:
    """A verdict with the names that scripts rely on; its signals by their names."""
    record = as_json(verdict)
    return record | {"signals": {one.pop("signal"): one for one in record["signals"]} or None}
