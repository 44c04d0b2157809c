"""Recommendations: checked by a run; failures are reported; one message for bad input."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from box import BOX
from clockwork import METHOD, Works
from command_line import ended
from ladders import BELOW, BETWEEN, TOP, Law, errors_of, only, straight, with_law
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reports.cli import choosing
from spincheck.reports.cli.run import recommend as recommend_module
from spincheck.reports.cli.run import running
from spincheck.reports.cli.run.recommend import CHECKS, Recommendation, exit_code, recommend
from spincheck.reports.cli.run.recommendation_words import (
    print_recommendation,
    recommendation_as_json,
)
from spincheck.reports.cli.terminal import NOT_RUN, Complaint
from spincheck.reports.results.cost_records import MethodCost, Ratio, StepCost
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store
from spincheck.scenarios import Errors

pytestmark = pytest.mark.slow

NO_FILE = Path("there-is-none.sqlite")


@pytest.fixture(autouse=True)
def _made_up_top(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the name of the made-up ladders' scene stand for a heavy top."""
    found = recommend_module.one_scene
    top = library_scene("fast-top")
    monkeypatch.setattr(
        recommend_module, "one_scene", lambda name: top if name == TOP else found(name)
    )


def recommended(
    monkeypatch: pytest.MonkeyPatch, ladder: Results, true_law: Law, **bounds: float
) -> Any:
    """A recommendation on made-up ladders, its checks answered by a law."""

    def check(scenario: object, key: Key, timestep: float, out: Path) -> Row:
        return Row(key, "1.0", timestep, "ok", errors=errors_of(true_law, timestep))

    monkeypatch.setattr(running, "run", lambda *arguments: ladder)
    monkeypatch.setattr(recommend_module, "_run_again", check)
    return recommend(TOP, bounds, [], 1, NO_FILE)


def euler_alone(law: Law) -> Results:
    ladder = with_law(law)
    return replace(
        ladder,
        rows=[row for row in ladder.rows if row.key.method == "Euler"],
        verdicts=[verdict for verdict in ladder.verdicts if verdict.key.method == "Euler"],
    )


STRAIGHT = euler_alone(straight)


def test_a_check_that_keeps_the_bounds_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    recommendation = recommended(monkeypatch, STRAIGHT, straight, omega=BETWEEN)
    (check,) = recommendation.checks
    assert (recommendation.verified, exit_code(recommendation)) == (True, 0)
    assert check.timestep == recommendation.best.timestep
    assert f"--timestep {recommendation.best.timestep!r}" in recommendation.command


def test_what_a_script_pays_for_what_the_adapter_leaves_out_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    key = STRAIGHT.rows[0].key
    cost = StepCost(1e-6, 0.0, 1e-6, ratio=Ratio(2.5, 0.1))
    whole = MethodCost(key, "", cost, '{"left_in": ["contact", "clock"]}', 0.0, 1.0)
    other = replace(whole, key=replace(key, method="RK4"), cost=replace(cost, ratio=Ratio(9, 0)))
    for costs, ratio in (([other, whole], 2.5), ([other], None), ([], None)):
        ladder = replace(STRAIGHT, costs=costs)
        recommendation = recommended(monkeypatch, ladder, straight, omega=BETWEEN)
        assert recommendation_as_json(recommendation)["left_in_ratio"] == ratio
        print_recommendation(replace(recommendation, setup="a line"))
        words = "2.5 times as long: what the adapter leaves out runs, too (contact, clock)."
        assert (words in capsys.readouterr().out) == (ratio is not None)


def test_a_cost_is_said_with_how_it_is_known_and_the_timestep_below_which_errors_grow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    recommendation = recommended(monkeypatch, STRAIGHT, straight, omega=BELOW)
    best, *others = recommendation.candidates
    floor = "(extrapolated; finer than 0.0002 s makes it worse)."
    for finest, words in ((None, "(extrapolated)."), (2e-4, floor)):
        known = (replace(best, finest_useful=finest), *others)
        print_recommendation(replace(recommendation, candidates=known))
        (line,) = (n for n in capsys.readouterr().out.splitlines() if n.startswith("Cheapest: "))
        assert line.endswith(words)


@pytest.mark.parametrize(
    ("found", "finest", "typed"),
    [
        (0.00838, 1 / 120, 1 / 120),  # 0.0083 is shorter
        (1 / 120, 1 / 120, 1 / 120),
        (0.00848, 1 / 120, 0.0084),
        (0.00838, None, 0.0083),
    ],
)
def test_what_is_typed_is_not_below_the_timestep_from_which_on_errors_grow(
    monkeypatch: pytest.MonkeyPatch, found: float, finest: float | None, typed: float
) -> None:
    best = recommended(monkeypatch, STRAIGHT, straight, omega=BETWEEN).best
    cost = best.cost * best.timestep / found
    candidate = recommend_module._as_typed(
        replace(best, timestep=found, finest_useful=finest, cost=cost)
    )
    assert candidate.timestep == typed
    assert candidate.cost * typed == pytest.approx(best.cost * best.timestep)


def test_a_check_that_misses_is_one_more_run_to_interpolate_between(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Below the ladder the errors turn out larger than the order promised."""
    worse = 1.1
    recommendation = recommended(
        monkeypatch, STRAIGHT, lambda dt: worse * straight(dt), omega=BELOW
    )
    assert not recommend_module.within(recommendation.checks[0], recommendation.bounds)
    assert recommendation.verified
    assert recommendation.best.timestep < recommendation.checks[0].timestep
    # What misses again and again is not verified.
    recommendation = recommended(monkeypatch, STRAIGHT, lambda dt: 1.0, omega=BELOW)
    assert (recommendation.verified, exit_code(recommendation)) == (False, 1)
    assert len(recommendation.checks) <= CHECKS


def test_a_run_that_would_last_too_long_is_not_started(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recommend_module, "TIME_LIMIT", 1e-6)
    recommendation = recommended(monkeypatch, STRAIGHT, straight, omega=BETWEEN)
    assert (recommendation.checks, recommendation.verified) == ((), False)
    assert "it would take" in recommendation.unchecked
    # Nor is one of what no method reaches.
    recommendation = recommended(monkeypatch, STRAIGHT, straight, omega=1e-300)
    assert (recommendation.best, recommendation.command, exit_code(recommendation)) == (None, "", 1)


def test_engines_as_shipped_are_not_even_run(monkeypatch: pytest.MonkeyPatch) -> None:
    methods_asked: list[list[str]] = []

    def run(scenes: object, engines: object, methods: list[str], *others: object) -> Results:
        methods_asked.append(methods)
        return STRAIGHT

    monkeypatch.setattr(running, "run", run)
    recommend(TOP, {"omega": 1e-300}, [], 1, NO_FILE)
    scene = library_scene("fast-top")
    chosen = choosing.choose([], methods_asked[0], [], scenarios=[scene]).engines
    every = [method for engine in chosen for method in engine.methods_for(scene)]
    assert any(method.as_shipped for method in every)
    assert not [name for name in methods_asked[0] if name.startswith("contact")]
    assert set(methods_asked[0]) == {method.name for method in every if method.is_recommendable}


@pytest.mark.parametrize(
    ("of_the_file", "runs", "is_taken"),
    [
        ({}, 3, True),
        ({}, 2, False),
        ({"engine_version": "0.1"}, 3, False),
        ({"seconds_per_step": None}, 3, False),
    ],
    ids=["timed", "timesteps that are no ladder", "of another version", "untimed"],
)
def test_timed_runs_of_the_engine_that_is_here_are_taken_from_the_file(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    of_the_file: dict[str, Any],
    runs: int,
    is_taken: bool,
) -> None:
    here = {"engine_version": engines()["mujoco"].version}
    rows = [replace(row, **(here | of_the_file)) for row in STRAIGHT.rows[:runs]]
    stored = tmp_path / "stored.sqlite"
    stored.touch()
    monkeypatch.setattr(running, "contents", lambda _: replace(STRAIGHT, rows=rows))
    scenario = STRAIGHT.scenes[TOP].scenario
    monkeypatch.setattr(recommend_module, "one_scene", lambda _: scenario)
    monkeypatch.setattr(running, "run", lambda *_: STRAIGHT)
    recommendation = recommend(TOP, {"omega": 1e-300}, [], 1, stored)
    assert recommendation.source == (str(stored) if is_taken else "")


@pytest.mark.parametrize(
    ("names", "is_taken", "others"),
    [
        ([], True, {"pybullet"}),
        (["mujoco"], True, set()),
        (["pybullet"], False, None),
        (["mujoco", "pybullet"], False, None),
    ],
)
def test_methods_that_the_file_lacks_are_named_and_an_engine_that_it_lacks_is_run(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    names: list[str],
    is_taken: bool,
    others: set[str] | None,
) -> None:
    rows = [replace(row, engine_version=engines()["mujoco"].version) for row in STRAIGHT.rows]
    stored = tmp_path / "stored.sqlite"
    stored.touch()
    monkeypatch.setattr(running, "contents", lambda _: replace(STRAIGHT, rows=rows))
    monkeypatch.setattr(recommend_module, "one_scene", lambda _: STRAIGHT.scenes[TOP].scenario)
    monkeypatch.setattr(running, "run", lambda *_: STRAIGHT)
    recommendation = recommend(TOP, {"omega": 1e-300}, names, 1, stored)
    print_recommendation(recommendation)
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("Not in ")]
    assert recommendation.source == (str(stored) if is_taken else "")
    assert len(said) == is_taken
    if others is None:
        return
    named = "".join(f" --engine {name}" for name in names)
    assert said[0].endswith(f"; 'spincheck run {TOP}{named} --out {stored}' adds them.")
    labels = said[0].partition(": ")[2].partition("; ")[0].split(", ")
    assert {label.partition(" ")[0] for label in labels} == {"mujoco"} | others & {*engines()}
    # Neither what the file has, nor what is never recommended.
    assert not {"mujoco Euler", "mujoco contact"} & {*labels}
    assert "mujoco RK4" in labels


def test_a_file_of_a_run_that_was_stopped_before_its_first_verdict_is_as_none(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    stored = tmp_path / "stored.sqlite"
    with open_store(stored, create=True):
        pass
    monkeypatch.setattr(running, "run", lambda *_: STRAIGHT)
    assert recommend(TOP, {"omega": 1e-300}, [], 1, stored).source == ""
    stored.write_text("no result file")
    with pytest.raises(Complaint, match="not a usable result file"):
        recommend(TOP, {"omega": 1e-300}, [], 1, stored)


def test_an_engine_that_is_there_as_shipped_only_is_one_message(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    raw = type("Raw", (Works,), {"name": "raw", "methods": (replace(METHOD, as_shipped=True),)})
    for module in (recommend_module, choosing):
        monkeypatch.setattr(module, "engines", lambda: {"raw": raw(lambda _: None)})
    with pytest.raises(Complaint, match="raw: has no method that is recommended"):
        recommend(TOP, {"omega": BETWEEN}, ["raw"], 1, NO_FILE)


def test_a_bound_broken_by_any_error_is_broken() -> None:
    row = replace(STRAIGHT.rows[0], errors=Errors(1e-3, 1e-2, 1e-4, 1e-5, 1e-3, 1e-3))
    within = recommend_module.within
    assert within(row, {"omega": 1e-3, "attitude": 1e-2})
    assert not within(row, {"omega": 1e-3, "attitude": 9e-3})
    assert not within(replace(row, errors=Errors(math.nan, 0, 0, 0, 0, 0)), {"omega": 1.0})
    assert not within(replace(row, outcome="diverged", errors=None), {"omega": 1.0})


Command = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize(("signal", "is_used"), [("omega", True), ("spins", False)])
def test_runs_are_used_whose_errors_in_what_is_bounded_are_known(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, signal: str, is_used: bool
) -> None:
    """Older files know no spins of a scene with rotors."""
    ladder = only(euler_alone(straight))
    version = ladder.rows[0].engine_version
    installed = SimpleNamespace(engines=[SimpleNamespace(name="mujoco", version=version)])
    monkeypatch.setattr(recommend_module, "one_scene", lambda _: ladder.scenes[TOP].scenario)
    monkeypatch.setattr(recommend_module, "choose", lambda *_, **__: installed)
    monkeypatch.setattr(running, "contents", lambda _: ladder)
    found = recommend_module._timed_runs(TOP, {signal: BETWEEN}, [], tmp_path)
    assert (found is not None) == is_used


@pytest.fixture(scope="module")
def spincheck(tmp_path_factory: pytest.TempPathFactory) -> Command:
    """Run the command beside a scene of its own."""
    folder = tmp_path_factory.mktemp("recommend")
    (folder / "box.toml").write_text(BOX)
    return partial(ended, cwd=folder)


def test_from_outside_it_chooses_checks_and_its_command_repeats_it(spincheck: Command) -> None:
    options = ["--omega", 1e-7, "--energy", 1e-6, "--engine", "mujoco", "--json"]
    code, out, err = spincheck("recommend", "box.toml", *options)
    printed = json.loads(out)
    assert (code, printed["verified"]) == (0, True), err
    assert printed["recommended"]["method"] == "RK4"
    assert printed["recommended"]["known"] == "measured"
    assert printed["checks"][-1]["omega"] <= 1e-7
    code, out, _ = spincheck(*printed["command"].split()[1:])
    (row,) = json.loads(out)["rows"]
    assert row["timestep"] == printed["recommended"]["timestep"]
    assert row["omega_error"] == printed["checks"][-1]["omega"]


def test_without_bounds_those_of_a_report_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = {"attitude": math.radians(0.1), "omega": 1e-3}
    assert recommended(monkeypatch, STRAIGHT, straight).bounds == kept


@pytest.mark.parametrize(("words", "bound"), [("2deg", math.radians(2)), ("0.5", 0.5)])
def test_a_bound_of_an_angle_may_be_in_degrees(
    spincheck: Command, monkeypatch: pytest.MonkeyPatch, words: str, bound: float
) -> None:
    found: list[object] = []

    def refuse(scene: str, bounds: object, *_: object) -> Recommendation:
        found.append(bounds)
        raise Complaint("seen", NOT_RUN)

    monkeypatch.setattr(recommend_module, "recommend", refuse)
    assert spincheck("recommend", "box.toml", "--attitude", words)[0] == NOT_RUN
    assert found == [{"attitude": bound}]
