"""Recommendations: cautious where curves bend, in whole steps, checked, honest on failure."""

import json
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from made_up import METHODS, TIMESTEPS, MadeUp, results
from spincheck.reports import recommend as recommend_module
from spincheck.reports import running
from spincheck.reports.candidates import Candidate, above_the_ladder, as_cheap, candidates
from spincheck.reports.cost_to_reach import reach
from spincheck.reports.gather import SceneRuns, gather
from spincheck.reports.recommend import CHECKS, exit_code, recommend
from spincheck.reports.records import Key, Row
from spincheck.reports.store import Results
from spincheck.reports.terminal import Complaint
from spincheck.reports.work_precision import EPS, curve_of
from spincheck.scenarios import Errors

TOP = "made-up-top"
ALONE = (MadeUp("mujoco", "Euler", 1), MadeUp("mujoco", "RK4", 4))
#: s, between two samples of the made-up scenes.
INTERVAL = 2.0 / 100
#: Of ω; between two rungs of a first-order method, and below its finest.
BETWEEN, BELOW = 1e-3, 1e-5
#: Quotients of times and powers of them.
ROUNDING = 64 * EPS

Law = Callable[[float], float]


def only_top(found: Results) -> Results:
    """The made-up results of one scene, as a study of it alone would store them."""
    return replace(
        found,
        scenes={TOP: found.scenes[TOP]},
        rows=[row for row in found.rows if row.key.scenario == TOP],
        verdicts=[verdict for verdict in found.verdicts if verdict.key.scenario == TOP],
    )


def with_law(law: Law, method: str = "Euler") -> Results:
    """The same, with the errors of one method in ω and attitude by a law of the timestep."""
    found = only_top(results(methods=ALONE))
    rows = [
        replace(row, errors=errors_of(law, row.timestep)) if row.key.method == method else row
        for row in found.rows
    ]
    return replace(found, rows=rows)


def errors_of(law: Law, timestep: float) -> Errors:
    return Errors(*[law(timestep)] * 4)


def scene_of(found: Results) -> SceneRuns:
    (scene,) = gather(found).scenes
    return scene


def chosen(found: Results, method: str, **bounds: float) -> Candidate:
    tried = candidates(scene_of(found), bounds)
    return next(candidate for candidate in tried if candidate.key.method == method)


def straight(timestep: float) -> float:
    return 0.1 * timestep / TIMESTEPS[0]


def bending_up(timestep: float) -> float:
    """Steeper at coarse timesteps."""
    return straight(timestep) * (1 + timestep / TIMESTEPS[0])


def bending_down(timestep: float) -> float:
    """Flatter at coarse timesteps, as errors that saturate are."""
    return straight(timestep) / (1 + timestep / TIMESTEPS[0])


LAWS = [straight, bending_up, bending_down]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("bound", [2.3e-2, 7e-3, BELOW], ids=["between", "lower", "below"])
def test_a_curve_that_bends_does_not_break_the_bound(law: Law, bound: float) -> None:
    best = chosen(with_law(law), "Euler", omega=bound)
    assert law(best.timestep) <= bound * (1 + ROUNDING)


def test_plain_interpolation_would_break_it() -> None:
    scene = scene_of(with_law(bending_down))
    euler = next(runs for runs in scene.methods if runs.method == "Euler")
    plain = reach(curve_of(scene, euler, "omega"), 2.3e-2)
    assert bending_down(plain.timestep) > 2.3e-2 * (1 + ROUNDING)


@pytest.mark.parametrize("bound", [2e-2, 7e-3, BELOW])
def test_the_interval_between_samples_is_a_whole_number_of_steps(bound: float) -> None:
    steps = INTERVAL / chosen(with_law(straight), "Euler", omega=bound).timestep
    assert steps == pytest.approx(round(steps), rel=ROUNDING)


@pytest.mark.parametrize(
    ("steps", "wanted"), [(1, []), (2, [1]), (3, [2, 1]), (16, [8, 4, 2, 1]), (13, [7, 4, 2, 1])]
)
def test_the_ladder_is_continued_upwards_to_one_step_a_sample(
    steps: int, wanted: list[int]
) -> None:
    scenario = scene_of(with_law(straight)).found.scenario
    found = above_the_ladder(scenario, INTERVAL / steps)
    assert [INTERVAL / timestep for timestep in found] == pytest.approx(wanted, rel=ROUNDING)


def test_a_rung_that_fits_is_not_cut() -> None:
    """Rounding down must not take a step off a quotient that is whole but for its last bits."""
    found = with_law(straight)
    assert chosen(found, "Euler", omega=1.0).timestep == pytest.approx(TIMESTEPS[0], rel=ROUNDING)


def test_the_tightest_of_several_bounds_decides() -> None:
    found = with_law(straight)
    both = chosen(found, "Euler", omega=1e-2, energy=1e-3)
    assert both == replace(chosen(found, "Euler", energy=1e-3), decided_by="energy")
    assert both.timestep < chosen(found, "Euler", omega=1e-2).timestep


def test_the_cheapest_comes_first_and_what_is_out_of_reach_last() -> None:
    found = candidates(scene_of(only_top(results())), {"omega": BETWEEN})
    costs = [candidate.cost or math.inf for candidate in found]
    assert costs == sorted(costs)
    assert found[0].key.method == "RK4"
    assert {candidate.word for candidate in found} > {"diverges", "failed", "unsupported"}
    assert len(found) == len(METHODS)


def test_the_largest_stable_timestep_is_below_the_last_blow_up() -> None:
    found = with_law(straight)
    rows = [
        replace(row, outcome="diverged")
        if row.key.method == "Euler" and row.timestep == TIMESTEPS[1]
        else row
        for row in found.rows
    ]
    assert chosen(found, "Euler", omega=BETWEEN).largest_stable == TIMESTEPS[0]
    after = chosen(replace(found, rows=rows), "Euler", omega=BETWEEN)
    assert after.largest_stable == TIMESTEPS[2]


def test_costs_within_the_spread_of_the_timings_are_called_alike() -> None:
    key = Key(TOP, "e", "m")
    best = Candidate(key, "measured", "", "omega", None, 1e-3, cost=1.0, spread=0.1)
    near, far = replace(best, cost=1.05), replace(best, cost=1.2)
    lost = replace(best, timestep=None, cost=None)
    assert as_cheap([best, near, far, lost]) == [near]
    assert as_cheap([lost, lost]) == []


def recommended(
    monkeypatch: pytest.MonkeyPatch, ladder: Results, true_law: Law, **bounds: float
) -> Any:
    """A recommendation on made-up ladders, its checks answered by a law."""

    def check(scenario: object, key: Key, timestep: float, out: Path) -> Row:
        return Row(key, "1.0", timestep, "ok", errors=errors_of(true_law, timestep))

    monkeypatch.setattr(running, "run", lambda *arguments: ladder)
    monkeypatch.setattr(recommend_module, "_run_again", check)
    monkeypatch.setattr(recommend_module, "_coarser_runs", lambda *arguments: [])
    return recommend(TOP, bounds, [], 1)


def euler_alone(law: Law) -> Results:
    found = with_law(law)
    return replace(
        found,
        rows=[row for row in found.rows if row.key.method == "Euler"],
        verdicts=[verdict for verdict in found.verdicts if verdict.key.method == "Euler"],
    )


def test_a_check_that_keeps_the_bounds_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = recommended(monkeypatch, euler_alone(straight), straight, omega=BETWEEN)
    assert (len(found.checks), found.verified, exit_code(found)) == (1, True, 0)
    assert found.checks[0].timestep == found.best.timestep
    assert f"--timestep {found.best.timestep!r}" in found.command


def test_a_check_that_misses_is_one_more_run_to_interpolate_between(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Below the ladder the errors turn out larger than the order promised."""
    worse = 1.1
    found = recommended(
        monkeypatch, euler_alone(straight), lambda dt: worse * straight(dt), omega=BELOW
    )
    assert not recommend_module.within(found.checks[0], found.bounds)
    assert found.verified
    assert found.best.timestep < found.checks[0].timestep


def test_what_misses_again_and_again_is_not_verified(monkeypatch: pytest.MonkeyPatch) -> None:
    found = recommended(monkeypatch, euler_alone(straight), lambda dt: 1.0, omega=BELOW)
    assert (found.verified, exit_code(found)) == (False, 1)
    assert len(found.checks) <= CHECKS


def test_a_run_that_would_last_too_long_is_not_started(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recommend_module, "TIME_LIMIT", 1e-6)
    found = recommended(monkeypatch, euler_alone(straight), straight, omega=BETWEEN)
    assert (found.checks, found.verified) == ((), False)
    assert "it would take" in found.unchecked


def test_what_no_method_reaches_is_said_and_exits_with_1(monkeypatch: pytest.MonkeyPatch) -> None:
    found = recommended(monkeypatch, euler_alone(straight), straight, omega=1e-300)
    assert (found.best, found.command, exit_code(found)) == (None, "", 1)


def test_a_bound_broken_by_any_error_is_broken() -> None:
    row = Row(Key(TOP, "e", "m"), "1", 1e-3, "ok", errors=Errors(1e-3, 1e-2, 1e-4, 1e-5))
    within = recommend_module.within
    assert within(row, {"omega": 1e-3, "attitude": 1e-2})
    assert not within(row, {"omega": 1e-3, "attitude": 9e-3})
    assert not within(replace(row, errors=Errors(math.nan, 0, 0, 0)), {"omega": 1.0})
    assert not within(replace(row, outcome="diverged"), {"omega": 1.0})


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({}, "takes a bound"),
        ({"omega": 0.0}, "'--omega' must be positive, got 0"),
        ({"angular_momentum": -1.0}, "'--angular-momentum' must be positive, got -1"),
        ({"energy": math.nan}, "'--energy' must be positive, got nan"),
    ],
)
def test_bad_bounds_are_refused_before_anything_runs(
    bounds: dict[Any, float], message: str
) -> None:
    with pytest.raises(Complaint, match=message) as complaint:
        recommend("no scene", bounds, [], 1)
    assert complaint.value.exit_code == 2


BOX = """
spincheck = 1
title = "A tumbling box"
source = "made up"
[body]
mass = 2.0
inertia = [1.0, 2.0, 2.5]
[start]
euler_zyz_deg = [10.0, 40.0, 70.0]
omega_body = [1.0, 2.0, 0.5]
[window]
duration = 1.0
samples = 11
"""


@pytest.fixture(scope="module")
def spincheck(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., tuple[int, str, str]]:
    """Run the command beside a scene of its own; returns exit code, stdout and stderr."""
    folder = tmp_path_factory.mktemp("recommend")
    (folder / "box.toml").write_text(BOX)
    command = Path(sys.executable).with_name("spincheck")

    def run(*arguments: object) -> tuple[int, str, str]:
        done = subprocess.run(
            [command, *map(str, arguments)], cwd=folder, capture_output=True, text=True
        )
        return done.returncode, done.stdout, done.stderr

    return run


def test_from_outside_it_chooses_checks_and_its_command_repeats_it(
    spincheck: Callable[..., tuple[int, str, str]],
) -> None:
    asked = ["--omega", 1e-7, "--energy", 1e-6, "--engine", "mujoco", "--json"]
    code, out, err = spincheck("recommend", "box.toml", *asked)
    found = json.loads(out)
    assert (code, found["verified"]) == (0, True), err
    assert found["recommended"]["method"] == "RK4"
    assert found["recommended"]["known"] == "measured"
    assert found["checks"][-1]["omega"] <= 1e-7
    code, out, _ = spincheck(*found["command"].split()[1:])
    (row,) = json.loads(out)["rows"]
    assert row["timestep"] == found["recommended"]["timestep"]
    assert row["omega_error"] == found["checks"][-1]["omega"]


def test_from_outside_bad_input_is_one_message_and_exit_code_2(
    spincheck: Callable[..., tuple[int, str, str]],
) -> None:
    code, out, err = spincheck("recommend", "box.toml")
    assert (code, out) == (2, "")
    assert err.startswith("spincheck: takes a bound")
    assert len(err.splitlines()) == 1
