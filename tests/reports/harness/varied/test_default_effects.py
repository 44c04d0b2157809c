"""The effect of each default of PyBullet on a motion is measured, one default at a time."""

from dataclasses import replace
from pathlib import Path

import pytest
from spincheck.engines import Engine
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.pybullet.engine import PyBullet
from spincheck.engines.adapters.pybullet.world import CLAMP, DAMPING, INERTIA, JOINT_MOTOR
from spincheck.reference import solve
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.comparison.rows import row_of
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.timesteps.ladder import single
from spincheck.reports.harness.varied.defaults import runs_with_defaults
from spincheck.reports.results.default_records import DefaultEffects, default_effects
from spincheck.reports.results.records import Key, Row, variation
from spincheck.scenarios import Scenario, loads
from spincheck.suite.contract_scenes import GRAVITY, PIVOT, SPUN_UP, TOP, scene
from studies import study

ENGINE = PyBullet()
TIMESTEP = ENGINE.stock_timestep
AXISYMMETRIC = scene("top", body=TOP, start=SPUN_UP, effects=PIVOT + GRAVITY, duration=0.5)


def effects_on(scenario: Scenario, engine: Engine = ENGINE) -> DefaultEffects | None:
    rung, method = single(TIMESTEP, scenario.times), engine.method("default")
    solution = solve(scenario, rung.sample_steps * TIMESTEP)
    at = prepare(scenario, (), 1 << 10).places
    rows = runs_with_defaults(scenario, engine, method.name, rung, solution, at)
    run = engine.run(scenario, method, TIMESTEP, rung.sample_steps)
    key = Key(scenario.name, engine.name, method.name)
    as_shipped = row_of(scenario, key, engine.version, rung, run, solution)
    (effects,) = default_effects([as_shipped], rows)
    return effects


@pytest.fixture(scope="module")
def of_a_top() -> DefaultEffects:
    return effects_on(AXISYMMETRIC)


def test_every_default_is_taken_away_once_of_a_free_body_no_motor(of_a_top: DefaultEffects) -> None:
    assert [one.name for one in of_a_top.each] == [INERTIA, DAMPING, JOINT_MOTOR, CLAMP]
    names = ENGINE.defaults(scene("free"), ENGINE.method("default"))
    assert names == (INERTIA, DAMPING, CLAMP)


def test_it_is_the_motor_that_stops_a_top(of_a_top: DefaultEffects) -> None:
    """Alone it takes all of L; with all others but it, the top spins on."""
    motor = next(one for one in of_a_top.each if one.name == JOINT_MOTOR)
    assert of_a_top.all is not None
    assert motor.alone is not None
    assert motor.without is not None
    assert motor.alone.angular_momentum > 0.9
    assert of_a_top.all.angular_momentum > 0.9
    assert motor.without.angular_momentum < 0.5


def test_motor_and_damping_act_in_steps_however_short_and_a_clamp_out_of_reach_does_not(
    of_a_top: DefaultEffects,
) -> None:
    _, damping, motor, clamp = of_a_top.each
    assert (damping.acts, motor.acts, clamp.acts) == (True, True, False)
    assert clamp.alone == of_a_top.none
    assert clamp.without == of_a_top.all
    assert damping.alone != of_a_top.none


@pytest.mark.parametrize(("without_any", "blamed"), [(False, True), (None, True), (True, None)])
def test_a_default_is_not_blamed_where_steps_are_wrong_without_any(
    without_any: bool | None, blamed: bool | None
) -> None:
    run = Row(Key("top", "pybullet", "default"), "1.0", TIMESTEP, "ok")
    acting = {(): without_any, (DAMPING,): True}
    rows = [
        replace(run, variation=variation({"defaults": list(some)}), acts=acts)
        for some, acts in acting.items()
    ]
    (effects,) = default_effects([run], rows)
    assert [one.acts for one in effects.each] == [blamed]


def test_a_default_of_which_a_run_is_missing_has_no_effect_of_another_run() -> None:
    """So it is where a study was stopped between two runs."""
    run = Row(Key("top", "pybullet", "default"), "1.0", TIMESTEP, "ok")
    some = [(), (DAMPING,), (CLAMP,), (INERTIA,), (DAMPING, CLAMP)]
    rows = [replace(run, variation=variation({"defaults": list(names)})) for names in some]
    (effects,) = default_effects([run], rows)
    assert [one.name for one in effects.each] == [INERTIA]


def test_a_run_that_ends_at_the_clamp_has_no_errors() -> None:
    fast = scene("fast", start=SPUN_UP.replace("40.0", "140.0"), duration=0.1)
    effects = effects_on(fast)
    clamp = next(one for one in effects.each if one.name == CLAMP)
    assert effects.all is None
    assert clamp.alone is None
    assert clamp.without is not None


def test_runs_with_some_defaults_are_no_runs_of_the_engine_as_it_is(path: Path) -> None:
    choice = Choice((ENGINE, MuJoCo()), ("default",), max_steps=1 << 10, timed=False)
    found = study(path, [AXISYMMETRIC], choice)
    assert {row.key.engine for row in found.varied} == {"pybullet"}, "MuJoCo's alter no motion"
    names = ENGINE.defaults(AXISYMMETRIC, ENGINE.method("default"))
    assert len(found.varied) == 1 + 2 * len(names)
    assert not any(row.variation for row in found.rows)


@pytest.mark.parametrize(("tags", "acting"), [("", True), ('tags = ["hard"]\n', None)])
def test_a_study_stores_what_acts_on_plain_scenes(path: Path, tags: str, acting: bool) -> None:
    text = AXISYMMETRIC.text.replace("\n[body]", f"\n{tags}[body]", 1)
    choice = Choice((ENGINE,), ("default",), max_steps=1 << 10, timed=False)
    (stored,) = study(path, [loads(text, "top")], choice).defaults
    assert {one.name: one.acts for one in stored.each}[JOINT_MOTOR] is acting
