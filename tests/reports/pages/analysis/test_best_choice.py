"""What is recommended: a choice an engine, at timesteps people type; nothing if all would do."""

from dataclasses import replace

from case_loops import each_case
from ladders import TOP
from library_scenes import library_scene
from made_up import results
from spincheck.reference import solve
from spincheck.reports.pages.analysis.best_choice import BOUNDS, TELLING, best_choices, steady
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.analysis.wording import rounded_down, typed
from spincheck.reports.results.results import Results, SceneResult


def solved(name: str) -> SceneResult:
    scenario = library_scene(name)
    return SceneResult(scenario, solve(scenario, scenario.times))


@each_case(
    ("name", "is_steady"),
    [("sphere", True), ("earth-wobble", True), ("hanging-top", True), ("book-middle-axis", False)],
)
def test_a_motion_that_a_constant_rate_would_do_for_recommends_nothing(name, is_steady) -> None:
    scene = solved(name)
    assert bool(steady(scene, BOUNDS)) == is_steady
    finer = {signal: bound * 1e-30 for signal, bound in BOUNDS.items()}
    if is_steady and name == "earth-wobble":
        assert not steady(scene, finer)


def test_the_errors_of_a_constant_rate_are_what_it_is_compared_with() -> None:
    scene = solved("earth-wobble")
    words = steady(scene, BOUNDS)
    off = float(words.partition("would be off by ")[2].partition(" in ω")[0])
    assert 0 < off < TELLING * BOUNDS["omega"]
    just_finer = {"omega": off / TELLING * 0.9}
    assert not steady(scene, just_finer)


@each_case(
    ("name", "is_steady"),
    [("tennis-racket", True), ("fast-top", False)],
)
def test_a_com_that_moves_uniformly_recommends_nothing_within_bounds_on_it(name, is_steady) -> None:
    scene = solved(name)
    assert bool(steady(scene, {"com": 1e-6})) == is_steady
    if name == "tennis-racket":
        assert not steady(scene, {"com": 1e-6, "attitude": 1e-3})
        assert " in velocity at worst" in steady(scene, {"velocity": 1e-6})


def choices(stored: Results) -> list[str]:
    scene = next(scene for scene in report_data(stored).scenes if scene.name == TOP)
    return [choice.runs.engine for choice in best_choices(scene)]


def renamed(stored: Results, engine: str, **declared: bool) -> Results:
    """The results, and all of them again as of another engine."""

    def other(record):
        return replace(record, key=replace(record.key, engine=engine))

    methods = {
        (engine, method): replace(record, **declared)
        for (_, method), record in stored.methods.items()
    }
    return replace(
        stored,
        rows=[*stored.rows, *map(other, stored.rows)],
        verdicts=[*stored.verdicts, *map(other, stored.verdicts)],
        methods=stored.methods | methods,
    )


def test_each_engine_has_a_choice_but_another_reader_of_models_has_none() -> None:
    stored = results()
    assert choices(stored) == ["mujoco"]
    assert choices(renamed(stored, "another")) == ["mujoco", "another"]
    assert choices(renamed(stored, "another", reader=True)) == ["mujoco"]


@each_case(
    ("timestep", "shorter", "text"),
    [
        (0.00390625, 0.0039, "0.0039"),
        (0.002, 0.002, "0.002"),
        (6.510416666666667e-05, 6.5e-05, "6.5e-05"),
        (0.1, 0.1, "0.1"),
        (0.999, 0.99, "0.99"),
    ],
)
def test_timesteps_are_rounded_down_to_what_people_type(timestep, shorter, text) -> None:
    assert rounded_down(timestep) == shorter
    assert typed(shorter) == text
    assert typed(1 / 240) == "1/240"
