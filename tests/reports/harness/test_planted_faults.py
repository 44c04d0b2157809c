"""Planted faults of an engine are reported by cause in its own rows, and in no other engine's."""

import planted
import pytest
from box import BOX
from case_loops import each_case
from faulty_mujoco import HeavierOnceLoaded, UpsideDown
from library_scenes import library_scene
from planted import HeunSession
from planted import planted as engine
from spincheck.reports.harness.choice import Choice
from spincheck.scenarios import loads
from studies import study

pytestmark = pytest.mark.slow

#: Steps of a ladder.
BUDGET = 1 << 11
#: s; the faults are told of a run by itself, no ladder.
TIMESTEP = 2.0**-7

#: By session class: the outcome, the cause, and words of the reason.
DETECTED = {
    planted.RaisingSession: ("failed", "bug", "ZeroDivisionError"),
    planted.LyingAboutBodySession: ("failed", "read-back", "'mass' must read back"),
    planted.LyingAboutStartSession: ("failed", "read-back", "'omega_body' must read back"),
    planted.DampedOpenlySession: ("failed", "model", "damping"),
    planted.NotANumberSession: ("diverged", "not-finite", "no longer finite"),
    planted.ResetSession: ("diverged", "warning", "the clock went back"),
    planted.ExplodingSession: ("diverged", "energy", "the energy exceeds 10 times its base"),
    planted.XyzwSession: ("ok", "law", "as if the quaternion were read as x, y, z, w"),
    planted.DampedInSecretSession: ("ok", "law", "as if L were slowed by 0.001 /s"),
    planted.SwappedMomentsSession: ("ok", "law", "I dω/dt, N m in body axes, is"),
    planted.WorldOmegaSession: ("ok", "law", "as if ω were read along the world's axes"),
    planted.NegatedSession: ("ok", "law", "after a step, however short it is"),
    planted.SlowClockSession: ("ok", "law", "as if a step took 0.99 timesteps"),
    planted.SpunUpInSecretSession: ("ok", "law", "as if L were sped up by 0.001 /s"),
    planted.LateSession: ("ok", "law", "as if the state were read as it was before the step"),
    planted.AnotherStartSession: ("ok", "law", "after a step, however short it is"),
    planted.BarelyDampedSession: ("ok", "law", "as if L were slowed by 1e-09 /s"),
}
#: What comes of such a row.
VERDICTS = {"failed": "failed", "diverged": "diverges", "ok": "disagrees"}
#: By its row alone none of these can be told from an honest engine.
UNDETECTED = (planted.TwiceTheMassSession, planted.LaggingSession)
#: Nor these: their runs are not what they are from their own states, which their replays show.
LATER = (
    planted.SpunUpFromHalfwaySession,
    planted.ResetInSecretSession,
    planted.FrozenSession,
)


def study_of(tmp_path, engines, scene, timestep):
    choice = Choice(tuple(engines), (), (timestep,), timed=False)
    return study(tmp_path / "results.sqlite", [scene], choice)


def rows_of(*studied):
    """The row of each engine, by its name."""
    return {row.key.engine: row for row in study_of(*studied).rows}


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    kinds = [HeunSession, *DETECTED, *UNDETECTED, *LATER]
    folder = tmp_path_factory.mktemp("together")
    return study_of(folder, map(engine, kinds), loads(BOX, "box"), TIMESTEP)


@pytest.fixture(scope="module")
def rows(together):
    return {row.key.engine: row for row in together.rows}


@each_case("kind", [*DETECTED])
def test_a_planted_fault_is_reported_by_name(together, rows, kind):
    row = rows[engine(kind).name]
    outcome, cause, words = DETECTED[kind]
    assert (row.outcome, row.cause) == (outcome, cause)
    assert words in row.reason
    (verdict,) = (one for one in together.verdicts if one.key == row.key)
    assert verdict.verdict == VERDICTS[outcome]
    assert not (row.survived and row.outcome != "ok")


def test_the_faultless_engine_is_as_if_it_were_alone_or_twice_as_heavy(rows, tmp_path):
    """Euler's equations are the same: this is no fault that a motion could give away."""
    (alone,) = rows_of(tmp_path, [engine(HeunSession)], loads(BOX, "box"), TIMESTEP).values()
    for row in (rows[alone.key.engine], rows["TwiceTheMass"]):
        assert (row.outcome, row.cause, row.reason, row.errors) == ("ok", "", "", alone.errors)


@each_case("kind", LATER)
def test_a_planted_fault_that_begins_later_shows_in_replays(rows, tmp_path, kind):
    row = rows[engine(kind).name]
    assert (row.outcome, row.cause) in (("ok", ""), ("ok", "lost"))
    choice = Choice((engine(kind),), max_steps=BUDGET, timed=False)
    (verdict,) = study(tmp_path / f"{kind.__name__}.sqlite", [loads(BOX, "box")], choice).verdicts
    assert verdict.verdict == "disagrees"
    assert "a step depends on more than the state" in verdict.reason


def test_turns_that_are_clamped_with_long_timesteps_are_remarked(path):
    choice = Choice((engine(planted.LaggingSession),), max_steps=BUDGET, timed=False)
    (verdict,) = study(path, [loads(BOX, "box")], choice).verdicts
    assert verdict.verdict == "converges"
    assert "what acts depends on the timestep" in verdict.reason


@pytest.mark.parametrize("name", ["nutation-loops", "hammer"])
def test_gravity_turned_round_is_reported_of_tops_and_of_what_is_thrown(tmp_path, name):
    (row,) = rows_of(tmp_path, [UpsideDown()], library_scene(name), 1e-3).values()
    assert row.cause == "law"
    assert "as if gravity were turned round" in row.reason


def test_a_mass_that_changes_once_it_was_read_back_is_reported_of_a_heavy_top(tmp_path):
    top = library_scene("nutation-loops")
    (row,) = rows_of(tmp_path, [HeavierOnceLoaded()], top, 1e-3).values()
    assert (row.outcome, row.cause) == ("ok", "law")
    assert "I dω/dt" in row.reason
