"""Finds and reads the scenes that a user named, and collects errors in their files."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ...scenarios import (
    LIBRARY,
    Scenario,
    ScenarioError,
    find,
    hiding_the_library,
    load_each,
    printable,
)
from .terminal import Complaint, as_complaint, say

#: Revolutions per minute in 1 rad/s.
RPM = 30 / math.pi


def one_scene(name: str) -> Scenario:
    """Return the scene that a file's path or the name of a library scene stands for.

    A `Complaint` is raised if there is no such scene, if the name is that of a folder with several
    scenes, or if the file is no valid scene.
    """
    scenes = scenes_to_run([name], expectations=False)
    if len(scenes) != 1:
        raise Complaint(f"{printable(name)}: takes one scene, this is {len(scenes)}")
    return scenes[0]


def scenes_to_run(names: Sequence[str], *, expectations: bool = True) -> list[Scenario]:
    """Return the scenes named, or all scenes of the library if none is named.

    Parameters
    ----------
    names : files, folders or names of library scenes
    expectations : whether to check that expectations name engines and methods that exist

    Raises
    ------
    Complaint
        If there is no scene of some name, if a file is no valid scene, or if an expectation names
        an engine or method that does not exist.
    """
    scenarios, wrong = load_each(_files(names))
    complain(wrong)
    if expectations:
        from ..harness.scene_checks.expectations import unknown_expectations

        complain(unknown_expectations(scenarios))
    return scenarios


def listed(names: Sequence[str]) -> tuple[list[dict[str, object]], list[str]]:
    """Return a table row for each scene, and a message for each file that is no valid scene.

    A row has the scene's name, kind (the library's folder that it is in), effects and title. A
    `Complaint` is raised for a name that no scene has.

    Parameters
    ----------
    names : files, folders or names of library scenes; the whole library if empty
    """
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


@dataclass(frozen=True)
class Checked:
    """The result of a check of scene files, in sentences.

    Attributes
    ----------
    lines : one for each file without an error in its format, with title, mass, tilt and speeds
    wrong : one for each error in a file
    unsolved : one for each motion that cannot be solved
    untrue : one for each published value that differs from the exact motion
    powerless : one for each effect whose absence would not be noticed in the scene's motion
    """

    lines: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    unsolved: list[str] = field(default_factory=list)
    untrue: list[str] = field(default_factory=list)
    powerless: list[str] = field(default_factory=list)


def checked(names: Iterable[str]) -> Checked:
    """Check scenes and return what was found.

    Parameters
    ----------
    names : files, folders or names of library scenes
    """
    from ..harness.scene_checks.expectations import unknown_expectations

    result = Checked()
    for name in names:
        try:
            scenarios, complaints = load_each(_found([name]))
        except ScenarioError as error:
            # No scene has that name, or two have it.
            scenarios, complaints = [], [str(error)]
        result.wrong.extend(complaints)
        for scenario in scenarios:
            if unknown := unknown_expectations([scenario]):
                result.wrong.extend(unknown)
                continue
            path = printable(str(scenario.path))
            is_unchecked = not (scenario.document.published or scenario.acting)
            ok = "ok: " if is_unchecked or _check_motion(scenario, result) else ""
            result.lines.append(f"{path}: {ok}{scenario.title}: {_in_short(scenario)}")
    return result


def _in_short(scenario: Scenario) -> str:
    """Return a scene's mass, tilt and angular speeds in words, to make wrong units noticeable."""
    w, x, y, z = scenario.start.q_world_body_wxyz.tolist()
    tilt = math.degrees(2 * math.atan2(math.hypot(x, y), math.hypot(w, z)))
    speeds = [math.hypot(*scenario.start.omega_body), *map(float, scenario.start_spins)]
    words = ", a part at ".join(f"{one:.4g} rad/s ({one * RPM:.4g} rpm)" for one in speeds)
    return f"{scenario.body.mass:g} kg, z axis {tilt:.3g}° from the world's, {words}"


def _check_motion(scenario: Scenario, result: Checked) -> bool:
    """Check a scene's published values and effects; return whether all published values hold.

    Sentences on what is wrong are added to `result`. False is returned, too, if the motion cannot
    be solved.
    """
    from ...reference import IntegrationError
    from ..harness.scene_checks.power import powerless
    from ..harness.scene_checks.published import published_that_do_not_hold
    from .choosing import compile_first

    compile_first()
    try:
        untrue = list(published_that_do_not_hold(scenario))
        result.untrue.extend(untrue)
        result.powerless.extend(powerless(scenario))
    except IntegrationError as error:
        result.unsolved.append(f"{scenario.name}: no exact motion: {error}")
        return False
    return not untrue


def complain(wrong: Sequence[str]) -> None:
    """Raise one `Complaint` with all messages on what is wrong, if there are any."""
    if wrong:
        raise Complaint("\n".join(wrong))


def _files(names: Sequence[str]) -> list[Path]:
    """Return the files of the scenes named; raise a `Complaint` for a name that no scene has."""
    with as_complaint(ScenarioError):
        return _found(names)


def _found(names: Sequence[str]) -> list[Path]:
    """Return the files of the scenes named, and print which of them hide scenes of the library.

    `ScenarioError` is raised for a name that no scene has.
    """
    paths = find(names)
    for sentence in hiding_the_library(names):
        say(sentence)
    return paths
