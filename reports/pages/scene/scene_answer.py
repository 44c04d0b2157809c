"""The top of a scene's page: what to use, and how large the errors of engines' defaults are."""

import math
import shlex
from collections.abc import Sequence
from typing import Any

from ...harness.recorded.recorded_ladder import RecordedEngine
from ...results.records import Key, Row
from ..analysis.best_choice import (
    BOUNDS,
    BestChoice,
    best_choice,
    best_choices,
    nothing_because,
    within_in_words,
)
from ..analysis.report_data import Compared, MethodRuns, SceneRuns
from ..analysis.rounding_bias import rounding_bias
from ..analysis.wording import NOTHING, duration, ended, limited_errors, number, plural, typed
from ..analysis.work_precision import cost
from ..tables import Cell, figure, table
from .motion_data import noticeable_from

HEADINGS = (
    "run",
    "attitude off by, °",
    "more than 1° off from",
    "ω error, relative",
    "energy error, relative",
    "CPU s a simulated s",
)


#: Number of engines whose defaults are described, and drawn when the page opens.
SHOWN_DEFAULTS = 2
#: Number of wrong methods whose gains are drawn when the page opens.
SHOWN_WRONG = 2


def scene_answer(scene: SceneRuns) -> dict[str, Any] | None:
    """Return the contents of the top of a scene's page; None if the scene could not be solved.

    The entry `uses` has the best choice of each engine, the best of all first. `defaults` is a
    table of methods as shipped at their stock timesteps, and of the best choice of all. `others` is
    a table of clean methods at stock timesteps.
    """
    if scene.solved is None:
        return None
    of_files = _is_of_files(scene)
    choices = [] if of_files else best_choices(scene)
    shipped = [runs for runs in scene.methods if runs.as_shipped]
    others = [runs for runs in scene.methods if runs not in shipped]
    seen = {(run.row.key, run.row.timestep): run for run in scene.compared}
    rows = [_line(scene, runs, row, seen) for runs in shipped for row in runs.stock[:1]]
    rows += [_line(scene, best.runs, best.row, seen, "recommended") for best in choices[:1]]
    rest = [_line(scene, runs, row, seen) for runs in others for row in runs.stock]
    return {
        "title": "What the files show" if of_files else "What the defaults give",
        "sentence": _sentence(scene, next(iter(choices), None)),
        "uses": [_use(scene, choice) for choice in choices],
        "defaults": table(HEADINGS, rows),
        "others": table(HEADINGS, rest),
    }


def _is_of_files(scene: SceneRuns) -> bool:
    """Return whether a scene's runs are recorded motions, so that no advice on engines applies."""
    return {runs.engine for runs in scene.methods} == {RecordedEngine.name}


def shown_at_first(scene: SceneRuns) -> set[str]:
    """Return the labels of the methods that figures show when the page opens.

    They are the `SHOWN_DEFAULTS` methods as shipped with the smallest errors, and the best choice
    if there is one.
    """
    best = best_choice(scene)
    closest = [runs.label for runs, _ in closest_defaults(scene)[:SHOWN_DEFAULTS]]
    return {*closest, *([best.runs.label] if best else [])}


def gains_shown_at_first(scene: SceneRuns) -> set[str]:
    """Return the labels of the methods whose gains are shown when the page opens.

    They are at most `SHOWN_WRONG` methods that disagree, and one that does not: the best choice if
    there is one, else the first. Methods without evidence of their steps are left out.
    """
    examined = [one for one in scene.methods if one.verdict and one.evidence and one.evidence.steps]
    wrong = [one.label for one in examined if one.verdict and one.verdict.verdict == "disagrees"]
    right = [one.label for one in examined if one.label not in wrong]
    best = best_choice(scene)
    first = [best.runs.label] if best and best.runs.label in right else right[:1]
    return {*wrong[:SHOWN_WRONG], *first}


def closest_defaults(scene: SceneRuns) -> list[tuple[MethodRuns, Row]]:
    """Return methods as shipped with their runs at stock timesteps, the smallest error first.

    Each method comes with its run at its engine's stock timestep or at 1 ms, whichever is longer.
    Runs without errors come last.
    """
    shipped = [runs for runs in scene.methods if runs.as_shipped]
    tried = [(runs, row) for runs in shipped for row in runs.stock[:1]]
    return sorted(tried, key=lambda one: one[1].errors.attitude if one[1].errors else math.inf)


def attitude_in_degrees(scene: SceneRuns, row: Row) -> str:
    """Return a run's attitude error as text, in degrees; `NOTHING` if it has no errors.

    An error that does not exceed the reference's uncertainty is shown as "≤" and the uncertainty.
    """
    if row.errors is None:
        return NOTHING
    return limited_errors(row.errors, scene.uncertainty(row), ("attitude",))[0]


def _sentence(scene: SceneRuns, best: BestChoice | None) -> str:
    """Return sentences on the errors of defaults and of the best choice.

    If there is no best choice, a sentence says why nothing is recommended. If the runs are recorded
    motions, the sentences are about those alone.
    """
    defaults = closest_defaults(scene)
    if _is_of_files(scene):
        return " ".join(_run_in_words(scene, "The recorded motion", row) for _, row in defaults)
    sentences = [_run_in_words(scene, runs.label, row) for runs, row in defaults[:SHOWN_DEFAULTS]]
    if others := defaults[SHOWN_DEFAULTS:]:
        are = "is" if len(others) == 1 else "are"
        sentences.append(f"{plural(len(others), 'other default')} {are} no closer.")
    if best is None:
        return " ".join([*sentences, nothing_because(scene)])
    angle = attitude_in_degrees(scene, best.row)
    label = f"{best.runs.label} at {duration(best.timestep)}"
    if best.within:
        within = angle.removeprefix("≤ ")
        sentences.append(f"{_capital(label)} is within {within}°{_price(best, defaults)}.")
    else:
        sentences.append(
            f"No run comes within {within_in_words(BOUNDS)}; the most accurate is {label}, off by "
            f"{angle}°."
        )
    return " ".join(sentences)


def _run_in_words(scene: SceneRuns, label: str, row: Row) -> str:
    """Return a sentence with a run's attitude error; if it has none, how the run ended.

    `label` is the run's engine and method.
    """
    run = f"{_capital(label)} at {duration(row.timestep)}"
    if row.errors is not None:
        return f"{run} is off by {attitude_in_degrees(scene, row)}° at worst."
    if not row.made:
        return f"{run} was not run: {row.reason}."
    if row.outcome == "unsupported":
        return f"{run} cannot be run: {row.reason}."
    return f"{run} {ended(row)}."


def _price(best: BestChoice, defaults: Sequence[tuple[MethodRuns, Row]]) -> str:
    """Return, in words, the cost of the best choice relative to its engine as shipped.

    The text is empty if one of the two was not timed, or if the run as shipped is missing or not
    `ok`. `defaults` has the methods as shipped, each with its run.
    """
    for runs, row in defaults:
        usual = cost(row)
        if runs.engine == best.runs.engine and row.outcome == "ok" and usual and best.cost:
            ratio = number(best.cost / usual, 2)
            return f", for {ratio} times the CPU time of {runs.label}"
    return ""


def _use(scene: SceneRuns, choice: BestChoice) -> dict[str, Any]:
    """Return a best choice for the page: a summary, what users write, and a command to check it.

    The entries are `summary`, `setup` and `command`; `facts`, pairs of name and value; and
    `within`, whether the errors are within `BOUNDS`. If the adapter does not state what users
    write, `setup` is a command that writes a script.
    """
    off, key = attitude_in_degrees(scene, choice.row), choice.row.key
    options = [scene.name, "--engine", key.engine, "--method", key.method]
    options += ["--timestep", repr(choice.timestep)]
    missed = "" if choice.within else ", its most accurate run"
    return {
        "within": choice.within,
        "summary": f"{choice.runs.label} at {duration(choice.timestep)}: {off}°{missed}",
        "facts": _facts(scene, choice),
        "setup": choice.setup or shlex.join(["spincheck", "reproduce", *options]),
        "command": shlex.join(["spincheck", "run", *options]),
    }


def _facts(scene: SceneRuns, best: BestChoice) -> list[tuple[str, str]]:
    """Return pairs of name and value that the page states about a best choice."""
    assert best.row.errors is not None, "only a run with errors is recommended"
    limits = scene.uncertainty(best.row)
    attitude, omega = limited_errors(best.row.errors, limits, ("attitude", "omega"))
    run, timestep = best.row.timestep, f"{typed(best.timestep)} s"
    if run != best.timestep:
        timestep += f" (measured at {number(run, 4)} s)"
    finest, bias = best.finest_useful, rounding_bias(best.runs)
    facts = [
        ("engine", f"{best.runs.engine} {best.row.engine_version}"),
        ("integrator", best.runs.method),
        ("timestep", timestep),
        *([("finer makes it worse", f"below {duration(finest)}")] if finest else []),
        *([("rounding", f"biased by {bias:.2g} ulp a step")] if bias else []),
        ("attitude error", f"{attitude}°"),
        ("ω error", omega),
    ]
    if best.cost is not None:
        facts.append(("cost", f"{number(best.cost)} CPU s a simulated s"))
    return facts


def _line(
    scene: SceneRuns,
    runs: MethodRuns,
    row: Row,
    seen: dict[tuple[Key, float], Compared],
    note: str = "",
) -> list[Cell | str]:
    """Return a run as a row of a table with `HEADINGS`.

    Parameters
    ----------
    runs, row : all runs of the method, and the run
    seen : the runs whose errors are known at each sample, by key and timestep
    note : words that follow the timestep, such as "recommended"
    """
    compared = seen.get((row.key, row.timestep))
    noticed = noticeable_from(compared) if compared else None
    return [
        Cell(
            runs.label, "name", ", ".join(part for part in (duration(row.timestep), note) if part)
        ),
        *_errors(scene, row, noticed),
        figure(number(cost(row))),
    ]


def _errors(scene: SceneRuns, row: Row, noticed: float | None) -> list[Cell]:
    """Return four cells: a run's attitude error, when it first exceeds 1°, ω error, energy error.

    If the run has no errors, the first cell says how it ended, and the others are `NOTHING`.

    Parameters
    ----------
    noticed : the time at which the attitude error first exceeds 1°, s; None if it never does, or if
        that time is not known
    """
    if row.errors is None:
        word = ended(row) if row.made else "not run"
        kind = row.outcome if row.made else "unsupported"
        return [Cell(word, kind, note=row.reason), *[figure(NOTHING)] * 3]
    attitude, *others = limited_errors(
        row.errors, scene.uncertainty(row), ("attitude", "omega", "energy")
    )
    begins = f"{number(noticed)} s" if noticed is not None else "never"
    if row.errors.attitude > math.radians(1) and noticed is None:
        begins = NOTHING
    return [*map(figure, (attitude, begins, *others))]


def _capital(text: str) -> str:
    """Return a method's label, in which the engine's name is spelled as the engine itself does.

    This is done for engines whose spelling is known.
    """
    names = {"mujoco": "MuJoCo", "pybullet": "PyBullet"}
    engine, _, method = text.partition(" ")
    return f"{names.get(engine, engine)} {method}"
