"""Judges and prints engines' derivatives, compared with the exact ones, for the command line."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from ...harness.gradients.study import GradientRow, gradients_by
from ..choosing import choose, compile_first, executor_for
from ..named_scenes import scenes_to_run
from ..terminal import AGREES, DISAGREES, NOT_RUN, Complaint, say, table


def gradients(
    scenes: Sequence[str],
    engine: Sequence[str],
    method: Sequence[str],
    timestep: float | None,
    time_limit: float | None,
) -> list[GradientRow]:
    """Judge the derivatives of every method that is named, or of all but those as shipped."""
    if timestep is not None and not 0 < timestep < float("inf"):
        raise Complaint(f"'--timestep' must be above 0, got {timestep:g}")
    scenarios = scenes_to_run(scenes, expectations=False)
    choice = choose(engine, method, (), scenarios=scenarios, time_limit=time_limit)
    compile_first()
    rows: list[GradientRow] = []
    with executor_for(1, choice) as executor:
        for scenario in scenarios:
            for one, way in choice.methods_on(scenario).values():
                if way.as_shipped and not method:
                    continue
                say(f"{scenario.name}  {one.name} {way.name}")
                rows += gradients_by(executor, scenario, one, way.name, timestep)
    return rows


def print_gradients(rows: Sequence[GradientRow]) -> None:
    """Print the verdicts, the reasons below, then the gradients at the end of windows."""
    table(list(map(_found, rows)))
    for row in rows:
        if row.judged.reason:
            print(f"{row.scene} {row.engine} {row.method}, {row.derivative}: {row.judged.reason}")
    if windows := list(_windows(rows)):
        print("\nGradient of the turn to a target, over the longest window:")
        table(windows)


def gradients_as_json(rows: Sequence[GradientRow]) -> list[dict[str, Any]]:
    """Return a record of each row."""
    return [asdict(row) for row in rows]


def exit_code(rows: Sequence[GradientRow]) -> int:
    """Return the exit code: whether a derivative is wrong, or none could be judged."""
    if any(row.judged.verdict == "disagrees" or row.judged.is_own is False for row in rows):
        return DISAGREES
    return AGREES if any(row.judged.verdict == "converges" for row in rows) else NOT_RUN


def _found(row: GradientRow) -> dict[str, object]:
    return {
        "scene": row.scene,
        "engine": row.engine,
        "method": row.method,
        "derivative": row.derivative,
        "verdict": row.judged.verdict,
        "order": row.judged.order or "",
        "off its own step": "" if row.judged.off_own is None else f"{row.judged.off_own:.1e}",
        "cost, steps": "" if row.cost is None else f"{row.cost:.0f}",
        "s": f"{row.seconds:.1f}",
    }


def _windows(rows: Sequence[GradientRow]) -> Iterator[dict[str, object]]:
    for row in rows:
        if row.window:
            last = row.window[-1]
            yield {
                "scene": row.scene,
                "engine": row.engine,
                "method": row.method,
                "derivative": row.derivative,
                "timestep, s": f"{row.timestep:.2g}",
                "window, s": f"{last.t:.2g}",
                "error": f"{last.error:.1e}",
                "cosine": f"{last.cosine:.4f}",
                "conditioning": f"{last.conditioning:.1e}",
                "useless from, s": "" if row.useless_from is None else f"{row.useless_from:.2g}",
            }
