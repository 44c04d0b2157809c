"""The command `compare`: what changed from one result to another."""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ....engines import engines
from ...pages.analysis.changes import COST_FACTOR, ERROR_FACTOR, Change, changes
from ...pages.analysis.wording import plural
from ...results.results import Results
from ..run import running
from ..terminal import AGREES, DISAGREES, Complaint, table


def compare(old: str, new: str, stored: Path) -> list[Change]:
    """Return the changes from one result file to another, or from one engine to another.

    Parameters
    ----------
    old, new : paths of two result files, or names of two engines; at least one of the names has a
        version, such as "mujoco@3.3.0", or an encoding, such as "mujoco as welded"
    stored : the result file that has the results of both engines; not used for two files

    Raises
    ------
    Complaint
        If a file cannot be read, or has no results of an engine.
    """
    names_engines = any(mark in old + new for mark in ("@", " as "))
    if names_engines and not (_is_file(old) or _is_file(new)):
        return changes_between_versions(running.read(stored), old, new)
    for name in (old, new):
        if name in engines() and not Path(name).exists():
            raise Complaint(
                f"{name}: no such result file; an engine is compared with another version of it, "
                f"such as {name}@1.2.3, or with another encoding"
            )
    return changes(running.read(Path(old)), running.read(Path(new)))


def _is_file(name: str) -> bool:
    """Whether a name is that of a file: it is one, or has a folder before it, as no engine's."""
    path = Path(name)
    return path.is_file() or path.name != name


def changes_between_versions(results: Results, older: str, newer: str) -> list[Change]:
    """Return the changes from the results of one engine to those of another, in one result file.

    `older` and `newer` are the engines' names, such as "mujoco@3.3.0". Each change names both, as
    in "mujoco@3.3.0 → 4.0.0". A `Complaint` is raised if the file has no verdict on one of them.
    """
    for name in (older, newer):
        if not any(verdict.key.engine == name for verdict in results.verdicts):
            raise Complaint(
                f"{name}: no result of it is in the file; 'spincheck run SCENE --engine …' makes "
                "them"
            )
    name = f"{older} → {newer.partition('@')[2] or newer}"
    return changes(_alone(results, older, name), _alone(results, newer, name))


def _alone(results: Results, engine: str, name: str) -> Results:
    """Return the runs and verdicts of one engine, under another name.

    Parameters
    ----------
    engine : the engine whose runs and verdicts are kept
    name : the name in place of the engine's; both engines get it, as results are compared by name
    """
    rows = [row for row in results.rows if row.key.engine == engine]
    verdicts = [verdict for verdict in results.verdicts if verdict.key.engine == engine]
    return replace(
        results,
        rows=[replace(row, key=replace(row.key, engine=name)) for row in rows],
        verdicts=[replace(one, key=replace(one.key, engine=name)) for one in verdicts],
    )


def exit_code(changes: Sequence[Change]) -> int:
    """Return the exit code: 1 if any change is a regression (`Change.regression`), else 0."""
    return DISAGREES if any(change.regression for change in changes) else AGREES


def changes_as_json(changes: Sequence[Change]) -> dict[str, Any]:
    """Return all changes as a JSON object: a list `changes`, and the number of `regressions`.

    `error_factor` and `cost_factor` are the factors by which errors and costs must differ to count
    as changed.
    """
    return {
        "regressions": sum(change.regression for change in changes),
        "error_factor": ERROR_FACTOR,
        "cost_factor": COST_FACTOR,
        "changes": [asdict(change) for change in changes],
    }


def print_changes(changes: Sequence[Change]) -> None:
    """Print the changes as a table, and below it how many there are.

    For each method on each scene, all errors that grew share one line, and all that shrank another.
    Such a line shows the largest change.
    """
    if not changes:
        print("nothing changed")
        return
    table([_line(group) for group in _grouped(changes)])
    regressions = sum(change.regression for change in changes)
    print(f"{plural(len(changes), 'change')}, of which {plural(regressions, 'regression')}")


def _grouped(changes: Sequence[Change]) -> list[list[Change]]:
    """Return the changes in groups, each of which is printed as one line.

    For each method on each scene, all errors that grew are one group, and all that shrank another.
    Any other change is a group of its own.
    """
    groups: dict[object, list[Change]] = {}
    for number, change in enumerate(changes):
        errors = (change.direction, change.scenario, change.engine, change.method)
        groups.setdefault(errors if change.kind == "error" else number, []).append(change)
    return list(groups.values())


def _line(group: Sequence[Change]) -> dict[str, object]:
    """Return a table row, by the columns' headings, that shows the largest change of a group."""
    most = max(group, key=_ratio)
    what = most.name
    if most.kind == "error":
        others = f", the most of {len(group)}" if len(group) > 1 else ""
        what = f"{most.name} error at {most.timestep:.3g} s{others}"
    elif most.timestep is not None:
        what = f"{most.name} at {most.timestep:.3g} s"
    direction = "regression" if most.regression else most.direction
    return {
        "": "" if direction == "other" else direction,
        "scene": most.scenario,
        "method": " ".join(name for name in (most.engine, most.method) if name),
        "what": what,
        "was": most.old if most.old is not None else "not there",
        "is": most.new if most.new is not None else "not there",
    }


def _ratio(change: Change) -> float:
    """Return the larger of a change's two values over the smaller, inf if the smaller is zero.

    It is 0 if the values are not both numbers, for example if one is missing.
    """
    if not isinstance(change.old, float) or not isinstance(change.new, float):
        return 0.0
    low, high = sorted((change.old, change.new))
    return high / low if low else float("inf")
