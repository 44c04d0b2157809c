"""From exact states along a motion small faults are told at first order, and no honest method is.

Verified is what single steps and pieces show; what ladders show is in `test_false_passes.py`.
"""

import numpy as np
import pytest
import stepped_faults as planted
from faulty_mujoco import FaultyMuJoCo, PlantedFault, applies
from held_by_impulses import HeldByImpulses, ReadsOmegaOffWhereHeld
from kinds_of_engines import why_missing
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.checks import equation_residuals, steps
from spincheck.engines.checks.equations import Equations
from spincheck.reports.cli.run.summary import verdict_record
from spincheck.reports.harness.judging import judge
from spincheck.reports.harness.judging.local import CONSISTENT, SEEN, LocalJudgement
from spincheck.reports.harness.measuring.local import examine
from spincheck.reports.harness.measuring.places import PIECE_STEPS, SAMPLE_EVERY, states_of
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from stepped import Stepped, SteppedEngine
from studies import verdict_of
from top_scenes import GRAVITY, scene

pytestmark = pytest.mark.slow

#: Steps of a ladder, which is not run.
FEW = 1 << 8
PLAIN, BOOK = "nutation-loops", "book-middle-axis"
HARD = [
    "chaos-beyond-the-horizon",
    "middle-axis-exactly",
    "pendulum-just-over",
    "separatrix-within-1e-10",
    "toutatis",
]
#: Rounding of the pendulum's moments to 24 bits changes its angular acceleration by 5e-3.
HELD_IN_24_BITS = [name for name in HARD if name != "pendulum-just-over"]


def examined(engine, method, name):
    scene = library_scene(name)
    return examine(engine, scene, method, prepare(scene, (), FEW).places)


def in_single(kind=Stepped, size=0.0, **as_if):
    """An engine of that fault, with 24 bits."""
    return SteppedEngine(planted.in_single(kind), size, single_precision=True, **as_if)


@pytest.mark.parametrize("name", [PLAIN, *HARD])
def test_an_honest_method_of_first_order_is_consistent_and_converges_in_pieces(name):
    local = examined(FaultyMuJoCo(), "Euler", name)
    assert local.finding == ""
    assert LocalJudgement(local).converges


@pytest.mark.parametrize("kind", ["moment", "com", "gravity", "clock"])
@pytest.mark.parametrize("name", [PLAIN, *HARD])
def test_a_fault_of_a_ten_millionth_is_told_at_first_order(name, kind):
    fault = PlantedFault(kind, 1e-7)
    if not applies(fault, library_scene(name)):
        pytest.skip(f"'{name}' has no {kind} that acts")
    assert examined(FaultyMuJoCo(fault), "Euler", name).finding


@pytest.mark.needs_pybullet
@pytest.mark.parametrize("method", ["multibody-p2p", "maximal"])
def test_a_body_that_a_constraint_holds_is_given_time_to_settle(method, monkeypatch):
    assert LocalJudgement(examined(engines()["pybullet"], method, PLAIN)).converges
    monkeypatch.setattr(equation_residuals, "SETTLING", 0)
    assert not LocalJudgement(examined(engines()["pybullet"], method, PLAIN)).converges


def test_a_body_that_no_engine_holds_is_not_known_well_enough():
    local = examined(engines()["mujoco"], "RK4", "rod-1e-12")
    assert local.finding == ""
    assert not LocalJudgement(local).converges


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_a_fault_at_the_stock_timestep_alone_is_told(method):
    kind, as_if = planted.AtExactlyTwoMilliseconds, {"stock_timestep": 2e-3}
    for name, faulty in (
        (BOOK, SteppedEngine(kind, 1e-3, **as_if)),
        (BOOK, in_single(kind, 1e-3, **as_if)),
        (PLAIN, in_single(kind, 1e-3, **as_if)),
    ):
        assert "with a timestep of 0.002 s" in examined(faulty, method, name).finding
    assert not examined(SteppedEngine(Stepped, 1e-3, **as_if), method, BOOK).finding


@pytest.mark.parametrize("method", ["Euler", "RK4"])
@pytest.mark.parametrize("name", [BOOK, PLAIN, *HELD_IN_24_BITS])
def test_rounding_to_24_bits_does_not_hide_that_steps_are_consistent(name, method):
    local = examined(in_single(), method, name)
    assert local.finding == ""
    assert LocalJudgement(local).converges


@pytest.mark.parametrize("method", ["Euler", "RK4"])
@pytest.mark.parametrize(
    "kind", [planted.Pushed, planted.AnotherMoment, planted.AnotherClock, planted.TurnsTooFar]
)
@pytest.mark.parametrize("name", [BOOK, PLAIN])
def test_a_small_fault_is_told_in_24_bits(name, kind, method):
    assert examined(in_single(kind, 5e-4), method, name).finding


@pytest.mark.parametrize("name", ["fast-top", PLAIN])
def test_a_body_that_impulses_hold_in_24_bits_settles_in_the_same_states_at_each_timestep(
    name, monkeypatch
):
    engine = in_single(HeldByImpulses)
    local = examined(engine, "Euler", name)
    assert LocalJudgement(local).converges
    monkeypatch.setattr(steps, "_earlier", lambda equations, states, *_: states)
    assert examined(engine, "Euler", name).tolerance > local.tolerance


@pytest.mark.parametrize("size", [1e-3, -3e-4])
@pytest.mark.parametrize("name", ["fast-top", PLAIN])
def test_a_small_misreading_of_omega_is_told_in_24_bits_where_impulses_hold_the_body(name, size):
    finding = examined(in_single(ReadsOmegaOffWhereHeld, size), "Euler", name).finding
    assert f"as if ω were read multiplied by {1 + size:.4g}"[:-1] in finding


@pytest.mark.parametrize("size", [1e-3, 1.0])
def test_to_how_much_of_the_weakest_effect_steps_are_known_is_said(size):
    """A com that is off by 1e-3 changes 2e-5 of the largest terms: what is stated allows for it."""
    local = examined(in_single(planted.AnotherLever, size), "Euler", PLAIN)
    assert local.finding or size <= local.of_an_effect <= SEEN
    assert bool(local.finding) is (size == 1.0)


def test_where_a_missing_effect_could_not_be_seen_steps_are_not_consistent():
    """The weight of a gyroscope at 24 000 rpm is a 10⁻⁶th of the largest terms."""
    name = "gyroscope-at-24000-rpm"
    local = examined(in_single(planted.AnotherLever, -1.0), "Euler", name)
    assert local.tolerance <= CONSISTENT
    assert local.finding or not LocalJudgement(local).is_consistent
    honest = examined(SteppedEngine(), "RK4", name)
    assert LocalJudgement(honest).is_consistent


@pytest.mark.parametrize("name", ["tennis-racket", "drag-until-rest", "pendulum-just-over"])
def test_steps_that_are_computed_otherwise_below_some_length_are_a_remark(name):
    """What they do there vanishes with the timestep, too: the method converges.

    Of the last two only the finest steps are that short, or by more than a step's own gain.
    """
    engine = SteppedEngine(planted.TurnsByATruncatedSeries)
    local = examined(engine, "Euler", name)
    assert local.finding == ""
    assert LocalJudgement(local).converges
    assert "vanishes with the timestep" in local.remark
    assert not examined(SteppedEngine(), "Euler", name).remark


@pytest.mark.parametrize(
    ("name", "engine", "method"),
    [
        ("tennis-racket", "dartpy", "semi-implicit"),
        ("sphere-in-syrup", "dartpy", "semi-implicit"),
        ("pendulum-on-the-separatrix", "dartpy", "semi-implicit"),
        ("goryachev-chaplygin", "drake", "runge_kutta3"),
        ("planar-pendulum", "exudyn", "RK33"),
    ],
)
def test_an_honest_method_whose_steps_have_branches_or_poles_is_not_accused(name, engine, method):
    """DART turns by a truncated series in short steps; Drake's angles have a pole near the way.

    Of Exudyn's, one estimate of its error, at one state and timestep, is far too small.
    """
    if reason := why_missing(engine):
        pytest.skip(reason)
    local = examined(engines()[engine], method, name)
    assert local.finding == ""
    assert LocalJudgement(local).converges


def test_no_piece_goes_on_where_the_table_would_have_to_pull():
    """An egg that jumps at 37 ms, in a window of 2 s: a contact lets it go."""
    jumping = scene(
        "mass = 0.3\ninertia = [0.0025, 0.0035, 0.001]\ncom = [0.01, 0.0, 0.05]",
        "euler_zyz_deg = [0.0, 40.0, 0.0]\nomega_body = [1.0, 3.0, 60.0]",
        f"{GRAVITY}\n[effects.table]\nheight = 0.0\ntip = [0.0, 0.0, 0.02]\nradius = 0.02",
        "duration = 2.0\nsamples = 101",
    )
    at = prepare(jumping, (), FEW).places
    assert Equations(jumping).bears(states_of(at.pieces.trajectory)).all()
    assert len(at.starts) * (PIECE_STEPS // SAMPLE_EVERY + 1) == len(at.pieces.trajectory.t)


def test_what_is_left_of_a_body_near_rest_may_add_up_and_decides_nothing():
    """MuJoCo's `discrete` creeps on at a millionth of the first speed: 2e-4 rad over the window."""
    local = examined(engines()["mujoco"], "discrete", "drag-until-rest")
    assert local.is_open
    assert not LocalJudgement(local).converges
    assert not examined(engines()["mujoco"], "Euler", "drag-until-rest").is_open


def study_of(name, engine, method):
    scene = library_scene(name)
    return convergence_study_of(scene, engine, engine.method(method), prepare(scene, (), 1 << 12))


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_a_verdict_by_pieces_says_so_and_does_not_contradict_itself(method):
    study = study_of("chaos-beyond-the-horizon", SteppedEngine(), method)
    verdict = verdict_of(study)
    assert verdict.verdict == "converges"
    assert "would resolve" not in verdict.reason
    assert "pieces" in verdict_record(verdict)["ground"]
    study.memory = 2.0
    remembering = judge(study.records)
    assert remembering.verdict == "unresolved"
    assert not remembering.ground
    assert "otherwise than if restarted from its own states" in remembering.reason


@pytest.mark.needs_pybullet
@pytest.mark.parametrize("arm", [1e-16, 1e-40, 1e-160])
@pytest.mark.parametrize("method", ["multibody-p2p", "maximal"])
def test_a_place_that_rounding_hides_accuses_no_method(method, arm):
    pinned = scene(
        f"mass = 0.3\ninertia = [0.0025, 0.0035, 0.002]\ncom = [{arm}, 0.0, 0.0]",
        "euler_zyz_deg = [0.0, 40.0, 0.0]\nomega_body = [1.0, 3.0, 6.0]",
    )
    engine, places = engines()["pybullet"], prepare(pinned, (), FEW).places
    assert examine(engine, pinned, method, places).finding == ""
    run = engine.run(pinned, engine.method(method), 2.0**-7, np.arange(0, 65, 8))
    assert run.outcome == "ok", run.reason


@pytest.mark.needs_pybullet
def test_where_coarse_timesteps_are_refused_finer_ones_are_taken_and_rounding_is_no_memory():
    local = examined(engines()["pybullet"], "maximal", "ship-stabiliser")
    assert LocalJudgement(local).converges
    study = study_of("needle-in-skew-axes", engines()["pybullet"], "maximal")
    assert verdict_of(study).verdict == "converges"
    assert study.memory <= 1


@pytest.mark.parametrize("can_restart", [True, False])
def test_every_session_that_is_opened_is_closed(can_restart, monkeypatch):
    """A world of Bullet's that is left open takes 30 MB, and a contact is opened anew 450 times."""
    engine = SteppedEngine()
    opened, closed = [], []
    monkeypatch.setattr(Stepped, "can_restart", property(lambda _: can_restart))
    monkeypatch.setattr(Stepped, "close", lambda one: closed.append(one))
    monkeypatch.setattr(
        engine,
        "open",
        lambda *given: opened.append(SteppedEngine.open(engine, *given)) or opened[-1],
    )
    assert LocalJudgement(examined(engine, engine.methods[0].name, PLAIN)).converges
    assert (len(opened) > 100) is not can_restart
    assert {*map(id, closed)} == {*map(id, opened)}


@pytest.mark.needs_pybullet
def test_what_a_rod_does_that_no_engine_holds_is_not_explained():
    """Its rate is 10¹² times that of its spin: a step of it would take 10⁹ to be followed."""
    finding = examined(engines()["pybullet"], "default", "rod-1e-12").finding
    assert finding
    assert "behaves as if" not in finding


def test_steps_that_overflow_are_not_judged():
    """Jolt's on a body of 1e38 kg m²: their runs tell."""
    assert examined(SteppedEngine(planted.Overflows), "Euler", "tennis-racket") is None
