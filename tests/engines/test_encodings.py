"""Encodings mean the same: in the exact motion, and in engines but for known exceptions."""

from dataclasses import replace

import numpy as np
import pytest
import top_scenes
from case_loops import each_case
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.checks.read_back import State
from spincheck.engines.encodings import ENCODINGS, SAME_BODY, EncodedEngine, SceneChange
from spincheck.reference import solve
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of, run_and_judge
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS
from spincheck.scenarios import errors_between
from spincheck.scenarios.scenario import started_at
from spincheck.suite.contract_scenes import SCENES

#: A body of half a kilogram tumbles as it flies.
TUMBLING = top_scenes.scene(
    "mass = 0.5\ninertia = [1e-3, 2e-3, 2.5e-3]\ncom = [0.01, 0.02, -0.01]",
    "rotation_vector_deg = [24, 0, 32]\nomega_body = [0.3, 12, 0.5]\nvelocity = [0.1, 0.2, 0.3]",
    "[effects.gravity]\nacceleration = [0.0, 1.0, -9.81]\n"
    "[effects.drag]\nrotational = 1e-4\n[effects.torque]\nbody = [1e-3, 2e-3, -1e-3]",
    "duration = 0.5\nsamples = 51",
)
OTHERS = SCENES["free-rotors"], SCENES["free-torque-world"]
EPS = float(np.finfo(float).eps)


def state_of(motion):
    place = motion.com_world, motion.velocity_world
    return State(motion.q_world_body_wxyz, motion.omega_body, *place, motion.spins)


def back(change, scenario, exact):
    """The exact motion of the changed scene, turned back."""
    changed = change.scene(scenario)
    motion = solve(changed, changed.times).trajectory
    return replace(exact, **vars(change.state_back(state_of(motion))))


def bounds(solution):
    """Uncertainty of both motions, and `SAME_BODY` ulp, which the start's conditioning carries."""
    ulps = {name: SAME_BODY * max(one, EPS) for name, one in solution.conditioning}
    return {name: 2 * own + ulps[name] for name, own in solution.uncertainty}


@each_case("scene", [TUMBLING, library_scene("lopsided-egg"), *OTHERS])
def test_the_exact_motion_of_a_changed_scene_is_that_of_the_scene(scene):
    solution = solve(scene, scene.times)
    exact, within = solution.trajectory, bounds(solution)
    able = [one for one in ENCODINGS.values() if scene.called_for <= one.effects]
    assert len(able) > 5
    for one in able:
        apart = errors_between(scene, back(one.change(scene), scene, exact), exact)
        assert all(apart[name] <= bound for name, bound in within.items()), (one.name, apart)


@each_case(
    ("encoding", "fault"),
    [
        # An axis that does not turn with the body, or is mirrored as an arrow; a place that stays;
        # a spin in the old unit of time.
        ("turned", lambda rotor, own: replace(rotor, axis=own.axis)),
        ("mirrored", lambda rotor, own: replace(rotor, axis=(-own.axis[0], *own.axis[1:]))),
        ("mm-g", lambda rotor, own: replace(rotor, position=own.position)),
        ("ms", lambda rotor, own: replace(rotor, spin=own.spin)),
    ],
)
def test_rotors_that_are_carried_along_wrongly_are_another_motion(encoding, fault, monkeypatch):
    scene, right, one = SCENES["free-rotors"], SceneChange._rotor, ENCODINGS[encoding]
    solution = solve(scene, scene.times)
    with monkeypatch.context() as patch:
        patch.setattr(SceneChange, "_rotor", lambda self, own: fault(right(self, own), own))
        made = back(one.change(scene), scene, solution.trajectory)
    apart = errors_between(scene, made, solution.trajectory)
    assert apart.omega > bounds(solution)["omega"], encoding


@each_case(
    "change",
    {
        "a mirror that forgets ω": lambda c: replace(c, is_mirrored=False),
        "another unit of time": lambda c: replace(c, time=2.0),
    },
)
def test_a_motion_that_is_turned_back_wrongly_is_another_motion(change):
    """Planted: the motion is turned back by another change than the scene."""
    mirrored = SceneChange(is_mirrored=True)
    solution = solve(TUMBLING, TUMBLING.times)
    changed = mirrored.scene(TUMBLING)
    motion = solve(change(mirrored).scene(TUMBLING), changed.times).trajectory
    got = mirrored.state_back(state_of(motion))
    apart = errors_between(TUMBLING, replace(solution.trajectory, **vars(got)), solution.trajectory)
    assert apart.omega > bounds(solution)["omega"]


@each_case("encoding", [*ENCODINGS])
def test_a_session_that_is_restarted_reads_back_the_state_in_the_scene_s_units(encoding):
    scenario, base = SCENES["free-tilted"], engines()["mujoco"]
    engine = EncodedEngine(base, encoding)
    if not engine.applies_to(scenario):
        return
    other = state_of(solve(scenario, scenario.times[[0, -1]]).trajectory).rows(1)
    with engine.open(scenario, engine.method("RK4"), 0.01) as session:
        session.restart(other, 0.02)
        read = session.read_state()
        # q and -q are one attitude.
        sign = np.sign(read.q_world_body_wxyz @ other.q_world_body_wxyz)
        read = replace(read, q_world_body_wxyz=sign * read.q_world_body_wxyz)
        for name, wanted in vars(other).items():
            size = max(1.0, float(np.abs(wanted).max(initial=0.0)))
            np.testing.assert_allclose(getattr(read, name), wanted, atol=SAME_BODY * EPS * size)
        session.advance(1)
        turned = session.read_state()
    with engine.open(started_at(scenario, **vars(other)), engine.method("RK4"), 0.02) as session:
        session.advance(1)
        np.testing.assert_allclose(session.read_state().omega_body, turned.omega_body, rtol=1e-11)


def verdict(engine, method, encoding, scenario):
    """The verdict on the engine in the encoding, by a short ladder."""
    encoded = EncodedEngine(engines()[engine], encoding)
    prepared = prepare(scenario, (), QUICK_STEPS).for_verdicts()
    study = convergence_study_of(scenario, encoded, encoded.method(method), prepared)
    return run_and_judge(study, InProcess())


@pytest.mark.needs_pybullet
@pytest.mark.slow
@each_case(
    ("name", "encodings"),
    [("free-tilted", tuple(ENCODINGS)), ("pivot-rotors", ("turned", "halves", "mm-g"))],
)
def test_engines_converge_in_all_descriptions_that_mean_the_same(name, encodings):
    scenario = SCENES[name]
    for engine, method in (("mujoco", "RK4"), ("pybullet", "multibody")):
        # It holds another body.
        known = ("welded", "nested", "full-tensor", "shape") if engine == "pybullet" else ()
        for encoding in encodings:
            one = EncodedEngine(engines()[engine], encoding)
            if one.applies_to(scenario) and encoding not in known:
                made = verdict(engine, method, encoding, scenario)
                assert made.verdict == "converges", (engine, encoding, made.reason)


@pytest.mark.needs_pybullet
@each_case(
    ("method", "encoding", "words"),
    [
        ("multibody", "welded", "No inertial data for link, using mass=1"),
        ("maximal", "halves", "'mass' must read back as"),
    ],
)
def test_what_pybullet_makes_of_welded_bodies(method, encoding, words):
    made = verdict("pybullet", method, encoding, SCENES["free-tilted"])
    assert made.verdict == "failed", made.reason
    assert words in made.reason


def test_a_motion_that_depends_on_its_description_disagrees(monkeypatch):
    """Planted: ω is read along axes that are 1e-6 rad off those of the encoding."""
    right = SceneChange.state_back

    def turned_too_far(change, states):
        back = right(change, states)
        x, y, z = back.omega_body.T
        return replace(back, omega_body=np.stack([x - 1e-6 * y, y + 1e-6 * x, z], axis=1))

    assert verdict("mujoco", "RK4", "turned", TUMBLING).verdict == "converges"
    monkeypatch.setattr(SceneChange, "state_back", turned_too_far)
    assert verdict("mujoco", "RK4", "turned", TUMBLING).verdict == "disagrees"


def test_an_engine_in_an_encoding_is_not_recommended_and_is_called_by_both_names():
    encoded = EncodedEngine(engines()["mujoco"], "welded")
    assert encoded.name == "mujoco as welded"
    assert {one.name for one in encoded.methods} < {one.name for one in encoded.base.methods}
    assert not any(one.is_recommendable for one in encoded.methods)
    assert encoded.version == encoded.base.version
