"""The scenes that a user named: found, read and complained of."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from ...scenarios import (
    LIBRARY,
    Scenario,
    ScenarioError,
    find,
    load_each,
    printable,
    scenario_files,
)
from ..harness.expectations import unknown_expectations
from .terminal import BAD_INPUT, Complaint


def one_scene(name: str) -> Scenario:
    """The scene of that name.

    Raises
    ------
    Complaint
        If there is none or several, or its file is wrong.
    """
    found = scenes_to_run([name], promises=False)
    if len(found) != 1:
        raise Complaint(f"{printable(name)}: takes one scene, this is {len(found)}", BAD_INPUT)
    return found[0]


def scenes_to_run(names: Sequence[str], *, promises: bool = True) -> list[Scenario]:
    """All the scenes named (nothing named: the library), or none: a study is not begun in part.

    Parameters
    ----------
    promises : whether those about an engine or method that there is not are complained of

    Raises
    ------
    Complaint
        If there is no such scene, or any of the files is wrong: what is wrong with every one.
    """
    scenarios, wrong = load_each(_files(names))
    complain(wrong)
    if promises:
        complain(unknown_expectations(scenarios))
    return scenarios


def listed(names: Sequence[str]) -> tuple[list[dict[str, object]], list[str]]:
    """A record for each of the scenes named, and what is wrong with files that give none."""
    rows: list[dict[str, object]] = []
    scenarios, wrong = load_each(_files(names))
    for scenario in scenarios:
        folder = scenario.path.parent if scenario.path else Path()
        kind = folder.relative_to(LIBRARY) if folder.is_relative_to(LIBRARY) else folder
        effects = ", ".join(sorted(scenario.called_for)) or "none"
        rows.append(
            {
                "scene": scenario.name,
                "kind": printable(str(kind)),
                "effects": effects,
                "title": scenario.title,
            }
        )
    return rows, wrong


def checked(files: Iterable[Path]) -> tuple[list[str], list[str]]:
    """A line for each file that is right, folders gone through; and what is wrong with others."""
    lines, wrong = [], []
    for file in files:
        try:
            scenarios, complaints = load_each(_in_it(file))
        except ScenarioError as error:
            # Two of one name.
            scenarios, complaints = [], [str(error)]
        wrong += complaints
        for scenario in scenarios:
            if promised := unknown_expectations([scenario]):
                wrong += promised
            else:
                lines.append(f"{printable(str(scenario.path))}: {scenario.title}")
    return lines, wrong


def _in_it(file: Path) -> list[Path]:
    try:
        return scenario_files(file) if file.is_dir() else [file]
    except OSError:  # such as a name that is too long, which the reader complains of
        return [file]


def complain(wrong: Sequence[str]) -> None:
    """Raise a `Complaint` if anything is wrong, with all that is."""
    if wrong:
        raise Complaint("\n".join(wrong), BAD_INPUT)


def _files(names: Sequence[str]) -> list[Path]:
    try:
        return find(names)
    except ScenarioError as error:
        raise Complaint(str(error), BAD_INPUT) from None
