"""Encodings mean the same: in the exact motion, and in engines but for known exceptions."""

from dataclasses import replace

import numpy as np
import pytest
import top_scenes
from case_loops import each_case
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.checks.read_back import State
from spincheck.engines.encodings import ENCODINGS, EncodedEngine, SceneChange
from spincheck.reference import solve
from spincheck.reports.harness.varied.encodings.bounds import rounding_bounds
from spincheck.scenarios import errors_between
from spincheck.scenarios.scenario import with_tables
from spincheck.suite.contract_scenes import SCENES

#: A body of half a kilogram tumbles as it flies.
TUMBLING = top_scenes.scene(
    "mass = 0.5\ninertia = [1e-3, 2e-3, 2.5e-3]\ncom = [0.01, 0.02, -0.01]",
    "rotation_vector_deg = [24, 0, 32]\nomega_body = [0.3, 12, 0.5]\nvelocity = [0.1, 0.2, 0.3]",
    "[effects.gravity]\nacceleration = [0.0, 1.0, -9.81]\n"
    "[effects.drag]\nrotational = 1e-4\n[effects.torque]\nbody = [1e-3, 2e-3, -1e-3]",
    "duration = 0.5\nsamples = 51",
)
TIMESTEP = 1e-3


def state_of(motion):
    place = motion.com_world, motion.velocity_world
    return State(motion.q_world_body_wxyz, motion.omega_body, *place, motion.spins)


def back(change, scenario, exact):
    """The exact motion of the changed scene, turned back."""
    changed = change.scene(scenario)
    motion = solve(changed, changed.times).trajectory
    return replace(exact, **vars(change.state_back(state_of(motion), changed.times)))


@each_case("scene", [TUMBLING, library_scene("lopsided-egg"), SCENES["free-rotors"]])
def test_the_exact_motion_of_a_changed_scene_is_that_of_the_scene(scene):
    solution = solve(scene, scene.times)
    exact, own = solution.trajectory, solution.uncertainty
    able = [one for one in ENCODINGS.values() if scene.called_for <= one.effects]
    assert len(able) > 5
    for one in able:
        bounds = rounding_bounds(scene, one, solution, 1, engines()["mujoco"])
        apart = errors_between(scene, back(one.change(scene), scene, exact), exact)
        within = (apart[name] <= bound + 2 * own[name] for name, bound in bounds.items())
        assert all(within), (one.name, apart)


@each_case(
    ("encoding", "fault"),
    {
        "an axis that does not turn with the body": (
            "turned",
            lambda rotor, own: replace(rotor, axis=own.axis),
        ),
        "a place that stays": ("mm-g", lambda rotor, own: replace(rotor, position=own.position)),
        "a spin in the old unit of time": ("ms", lambda rotor, own: replace(rotor, spin=own.spin)),
        "an axis that is mirrored as an arrow": (
            "mirrored",
            lambda rotor, own: replace(rotor, axis=(-own.axis[0], *own.axis[1:])),
        ),
    },
)
def test_rotors_that_are_carried_along_wrongly_are_another_motion(encoding, fault, monkeypatch):
    scene, right, one = SCENES["free-rotors"], SceneChange._rotor, ENCODINGS[encoding]
    solution = solve(scene, scene.times)
    bounds = rounding_bounds(scene, one, solution, 1, engines()["mujoco"])
    with monkeypatch.context() as patch:
        patch.setattr(SceneChange, "_rotor", lambda self, own: fault(right(self, own), own))
        made = back(one.change(scene), scene, solution.trajectory)
    apart = errors_between(scene, made, solution.trajectory)
    assert apart.omega > 1e6 * bounds["omega"], encoding


def test_a_moment_that_is_off_by_1e_8_is_beyond_what_rounding_explains():
    moments = (1e-3 * (1 + 1e-8), 2e-3, 2.5e-3)
    body = TUMBLING.document.body.model_copy(update={"inertia": moments})
    solution = solve(TUMBLING, TUMBLING.times)
    other = solve(with_tables(TUMBLING, body=body), TUMBLING.times).trajectory
    apart = errors_between(TUMBLING, other, solution.trajectory)
    bounds = rounding_bounds(TUMBLING, ENCODINGS["turned"], solution, 500, engines()["mujoco"])
    assert all(apart[name] > bounds[name] for name in ("omega", "attitude"))


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
    got = mirrored.state_back(state_of(motion), changed.times)
    apart = errors_between(TUMBLING, replace(solution.trajectory, **vars(got)), solution.trajectory)
    assert apart.omega > 1e-6


def run(engine, scenario, encoding, method, steps=100):
    encoded = EncodedEngine(engines()[engine], encoding)
    samples = np.arange(0, steps + 1, steps // 5)
    one = encoded.method(method)
    return encoded.run(scenario, one, TIMESTEP, samples, fails_if_unlike=False)


@pytest.mark.needs_pybullet
@each_case("name", ["free-tilted", "heavy-tilted", "free-rotors", "pivot-rotors"])
def test_engines_move_alike_in_all_descriptions_that_mean_the_same(name):
    scenario = SCENES[name]
    for engine, method in (("mujoco", "RK4"), ("mujoco", "Euler"), ("pybullet", "multibody")):
        plain = run(engine, scenario, "plain", method)
        assert plain.outcome == "ok", plain.reason
        for one in ENCODINGS.values():
            # On three slides, hinges, or off the com, motions differ by the timestep's error.
            known = one.name in ("offset", "aligned", "hinges", "halves", "thirds") or (
                # It holds another body.
                engine == "pybullet" and one.name in ("welded", "nested", "full-tensor", "shape")
            )
            if known or one.why_not(engines()[engine], scenario):
                continue
            made = run(engine, scenario, one.name, method)
            assert (made.outcome, made.reason) == ("ok", ""), (engine, one.name)
            solution = solve(scenario, made.trajectory.t)
            bounds = rounding_bounds(scenario, one, solution, made.steps, engines()[engine])
            apart = errors_between(scenario, made.trajectory, plain.trajectory)
            assert all(apart[s] <= bound for s, bound in bounds.items()), (engine, one.name, apart)


@pytest.mark.needs_pybullet
@each_case(
    ("engine", "method", "encoding", "outcome", "words"),
    [
        ("pybullet", "multibody", "welded", "failed", "No inertial data for link, using mass=1"),
        ("pybullet", "maximal", "halves", "ok", "'mass' is off by 5.0e-01"),
        ("mujoco", "RK4", "halves", "ok", ""),
        # Its com is read to an ulp of 100 km.
        ("pybullet", "maximal", "far", "ok", ""),
    ],
)
def test_what_an_engine_makes_of_welded_bodies(engine, method, encoding, outcome, words):
    made = run(engine, SCENES["free-tilted"], encoding, method)
    assert made.outcome == outcome
    assert words in made.reason
    assert bool(words) == bool(made.reason)
