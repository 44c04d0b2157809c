"""The command `gradients`: judges and prints engines' derivatives, compared with exact ones."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...harness.gradients.compared import GradientRow
from ...harness.gradients.study import gradient_by, offered_by
from ...results.verdict_words import VERDICT
from ..choosing import choose, compile_first, executor_for
from ..named_scenes import scenes_to_run
from ..terminal import AGREES, DISAGREES, NOT_RUN, Complaint, say, table

#: Costs below this many steps are printed with one decimal, others with none.
DIGIT = 10.0


def gradients(
    scenes: Sequence[str],
    engine: Sequence[str],
    method: Sequence[str],
    timestep: float | None,
    window: float | None,
    time_limit: float | None,
) -> list[GradientRow]:
    """Return verdicts on the derivatives of methods' steps.

    Before each derivative is judged, its name is printed on stderr.

    Parameters
    ----------
    scenes : files, folders or names of library scenes
    engine : names of engines; if empty, all that are not optional
    method : names of methods; if empty, all that are not as shipped
    timestep : timestep of gradients through many steps, s; if None, it follows from the fastest
        rate
    window : time over which gradients through many steps are compared, s; 512 steps if None
    time_limit : CPU time that a run may take, s; the default if None

    Returns
    -------
    A row for each scene, method and derivative that the method offers.

    Raises
    ------
    Complaint
        If a name or number cannot be used.
    """
    for option, given in {"--timestep": timestep, "--window": window}.items():
        if given is not None and not 0 < given < float("inf"):
            raise Complaint(f"'{option}' must be above 0, got {given:g}")
    if timestep and window and window < timestep:
        raise Complaint(f"'--window' must be no shorter than '--timestep', got {window:g} s")
    scenarios = scenes_to_run(scenes, expectations=False)
    choice = choose(engine, method, (), scenarios=scenarios, time_limit=time_limit)
    compile_first()
    rows: list[GradientRow] = []
    with executor_for(1, choice) as executor:
        for scenario in scenarios:
            for one, way in choice.methods_on(scenario).values():
                if way.as_shipped and not method:
                    continue
                of = scenario, one, way.name
                for derivative in offered_by(executor, *of):
                    say(f"{scenario.name}  {one.name} {way.name}, {derivative}")
                    rows.append(gradient_by(executor, *of, derivative, timestep, window))
    return rows


def print_gradients(rows: Sequence[GradientRow]) -> None:
    """Print a table of verdicts, then their reasons, then a table of gradients through many steps.

    The last table is left out if no such gradients were computed.
    """
    table(list(map(_found, rows)))
    for row in rows:
        if row.judged.reason:
            print(f"{row.scene} {row.engine} {row.method}, {row.derivative}: {row.judged.reason}")
    if windows := list(_windows(rows)):
        print("\nGradient of the turn to a target, over the longest window:")
        table(windows)


def gradients_as_json(rows: Sequence[GradientRow]) -> list[dict[str, Any]]:
    """Return each row as a dictionary, for JSON: its attributes by name, nested ones too."""
    return [asdict(row) for row in rows]


def exit_code(rows: Sequence[GradientRow]) -> int:
    """Return the exit code: 1 if a derivative is wrong or fails, else 0 if one converges, else 3.

    A derivative also counts as wrong if it is not the derivative of the engine's own step.
    """
    if any(VERDICT[row.judged.verdict].fails or row.judged.is_own is False for row in rows):
        return DISAGREES
    return AGREES if any(row.judged.verdict == "converges" for row in rows) else NOT_RUN


def median_and_quartiles(costs: Sequence[float]) -> str:
    """Return the median and quartiles of costs, in steps, as "12 (10 to 15)"; empty without any."""
    if not costs:
        return ""
    low, middle, high = (
        f"{cost:.{int(cost < DIGIT)}f}" for cost in np.quantile(costs, [0.25, 0.5, 0.75])
    )
    return f"{middle} ({low} to {high})"


def _found(row: GradientRow) -> dict[str, object]:
    """Return the verdict on a derivative as a row of a table, by the headings of the columns."""
    return {
        "scene": row.scene,
        "engine": row.engine,
        "method": row.method,
        "derivative": row.derivative,
        "verdict": row.judged.verdict,
        "order": row.judged.order or "",
        "off its own step": "" if row.judged.off_own is None else f"{row.judged.off_own:.1e}",
        "cost, steps": median_and_quartiles(row.costs),
        "s": f"{row.seconds:.1f}",
    }


def useless(row: GradientRow) -> str:
    """Return, as text, the length of run, s, from which on its gradients are no better than zeros.

    The conditioning at that time follows in brackets. The text is empty if the gradients are better
    than zeros up to the end of the longest run.
    """
    there = [one for one in row.window if one.t == row.useless_from]
    return "".join(f"{one.t:.2g} ({one.conditioning:.0e})" for one in there)


def _windows(rows: Sequence[GradientRow]) -> Iterator[dict[str, object]]:
    """Yield a table row for each derivative whose gradients through many steps were computed.

    The row, by the headings of the columns, is about the longest window of time over which they
    were computed.
    """
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
                "as wrong as none from, s (conditioning)": useless(row),
            }
