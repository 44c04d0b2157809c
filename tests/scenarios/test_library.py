"""The library as a whole: every file is sound, the format is used to the full, docs agree."""

from pathlib import Path

import numpy as np
from case_loops import each_case
from library_scenes import library
from spincheck.scenarios import EFFECTS, LIBRARY, Scenario
from spincheck.scenarios.document import BodyTable
from spincheck.scenarios.effects.effect import DRIVEN
from spincheck.scenarios.start import StartTable

SCENES = library()
KINDS = ("free", "thrown", "heavy", "driven", "rotors", "table")
#: Scenes of any kind that are hard to get right.
HARD = "hard"
#: Scenes whose length is what is hard about them.
LONG = "long"
PAGE = Path(__file__).parents[2] / "docs/reference/scenes.md"
EPS = np.finfo(float).eps

#: What the library set out to hold at the least.
FEWEST_SCENES = 24
#: A first-order method off by half a step's turn settles within a million steps below this.
LARGEST_TURN_RAD = 1000.0
SAMPLES = range(100, 402)


every_scene = each_case("scenario", SCENES)


def folder(scenario: Scenario) -> str:
    assert scenario.path is not None
    return scenario.path.relative_to(LIBRARY).parts[0]


def test_every_file_of_the_library_is_a_scene_and_there_are_enough() -> None:
    assert {scenario.path for scenario in SCENES} == set(LIBRARY.rglob("*.toml"))
    assert len(SCENES) >= FEWEST_SCENES


def test_names_and_titles_are_unique() -> None:
    assert len({scenario.name for scenario in SCENES}) == len(SCENES)
    assert len({scenario.title for scenario in SCENES}) == len(SCENES)


@every_scene
def test_scene_says_what_to_look_at_and_where_it_comes_from(scenario: Scenario) -> None:
    document = scenario.document
    assert len(document.description.split()) > len(document.title.split())
    assert document.source.strip()
    assert document.tags


@every_scene
def test_scene_lies_in_the_folder_of_its_kind(scenario: Scenario) -> None:
    called_for = scenario.called_for
    if any(effect.group == DRIVEN for effect in scenario.acting):
        kind = "driven"
    elif "table" in called_for:
        kind = "table"
    elif "gravity" in called_for:
        kind = "heavy" if scenario.constraint.is_pivot else "thrown"
    else:
        kind = "free"
    parts = "rotors" if scenario.rotors else "table" if "table" in called_for else kind
    assert folder(scenario) in (parts, HARD)
    assert {kind, parts} <= set(scenario.document.tags)
    assert folder(scenario) != HARD or HARD in scenario.document.tags


@every_scene
def test_scene_is_symmetric_where_its_tags_say_so(scenario: Scenario) -> None:
    shapes = {"symmetric", "asymmetric", "spherical"} & set(scenario.document.tags)
    assert shapes == {shape_about_fixed_point(scenario)}


def shape_about_fixed_point(scenario: Scenario) -> str:
    """Symmetric: two moments equal about the fixed point, and the com on the third axis.

    Where all three are, about a pivot, any axis is the third.
    """
    body = scenario.body
    if not scenario.constraint.is_pivot:
        return shape(np.linalg.eigvalsh(body.inertia_com))
    moments, axes = np.linalg.eigh(body.inertia_origin)
    if shape(moments) != "symmetric":
        return "asymmetric" if shape(moments) == "asymmetric" else "symmetric"
    odd = 0 if np.isclose(moments[1], moments[2], rtol=8 * EPS, atol=0) else 2
    off_axis = body.com - axes[:, odd] * (axes[:, odd] @ body.com)
    on_axis = np.linalg.norm(off_axis) <= 8 * EPS * np.linalg.norm(body.com)
    return "symmetric" if on_axis else "asymmetric"


def shape(moments: np.ndarray) -> str:
    low, middle, high = moments
    equal = [bool(np.isclose(low, middle, rtol=8 * EPS, atol=0))]
    equal.append(bool(np.isclose(middle, high, rtol=8 * EPS, atol=0)))
    return ("asymmetric", "symmetric", "spherical")[sum(equal)]


@every_scene
def test_window_is_short_enough_for_first_order_methods(scenario: Scenario) -> None:
    speed = np.linalg.norm(scenario.start.omega_body)
    assert speed * scenario.window.duration <= LARGEST_TURN_RAD or LONG in scenario.document.tags
    assert scenario.window.samples in SAMPLES


@every_scene
def test_scene_expects_nothing_of_engines_but_known_blow_ups(scenario: Scenario) -> None:
    assert {expected.outcome for expected in scenario.expect} <= {"diverges"}


@every_scene
def test_published_tolerances_are_coarser_than_doubles_and_finer_than_the_values(
    scenario: Scenario,
) -> None:
    for published in scenario.document.published:
        for value in published.values().values():
            largest = np.abs(value).max()
            assert EPS * largest < published.tolerance < largest


#: Of a body that was taken from somebody's model file, which the library has none of.
OF_A_MODEL = {"model", "link", "welded", "sha256"}


def test_the_format_is_used_to_the_full() -> None:
    """Every key, an inertia in both forms and about both points, effects alone and mixed."""
    bodies, starts = zip(*((s.document.body, s.document.start) for s in SCENES), strict=True)
    used = set().union(*(table.model_fields_set for table in (*bodies, *starts)))
    assert used >= {*StartTable.model_fields, *BodyTable.model_fields} - OF_A_MODEL
    stated = [body for body in bodies if "inertia_about" in body.model_fields_set]
    assert {body.inertia_about for body in stated} == {"com", "origin"}
    assert {type(body.inertia[0]) for body in bodies if body.inertia} == {float, tuple}
    called_for = {scenario.called_for for scenario in SCENES}
    for effect in EFFECTS:
        # Without gravity nothing presses a body on a table.
        least = {"gravity", "table"} if effect == "table" else {effect}
        assert least in called_for, effect
        assert any(several > {effect} for several in called_for), effect


def test_gravity_also_pulls_along_another_axis_than_z_and_on_another_body_than_earth() -> None:
    pulls = [scenario.gravity_world for scenario in SCENES if "gravity" in scenario.called_for]
    assert any(pull[:2].any() for pull in pulls)
    assert any(0 < np.linalg.norm(pull) < 2 for pull in pulls)


@each_case("kind", [*KINDS, HARD])
def test_the_page_lists_the_scenes_of_each_folder(kind: str) -> None:
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {kind}/\n")[1].split("\n## ")[0]
    listed = [line for line in section.splitlines() if line.startswith("| `")]
    assert listed == [row(scenario) for scenario in SCENES if folder(scenario) == kind]


def row(scenario: Scenario) -> str:
    effects = ", ".join(name for name in EFFECTS if name in scenario.called_for) or "none"
    window = f"{scenario.window.duration:g} s"
    return f"| `{scenario.name}` | {scenario.title} | {effects} | {window} |"
