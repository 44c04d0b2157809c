"""Scenes with rotors against the second derivation: all that the library has.

Verified: ω, attitude and spins over the first turns, to 1e-15 and to the uncertainty stated. Over
long times a free symmetric gyrostat has a closed form; of others conservation laws are all that is
verified there.
"""

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation
from second_derivation import DIGITS, State, of_scene
from spincheck.reference import solve
from spincheck.scenarios import FloatArray, Scenario, Trajectory, loads
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.scenarios.rotation import norms, rotation_vectors
from spincheck.scenarios.scenario import with_tables
from two_turns import two_turns
from varied_scenes import varied

pytestmark = pytest.mark.slow

#: Those on a table are among the scenes of `test_table`.
SCENES = [scene for scene in library() if scene.rotors and "table" not in scene.called_for]
#: rad, of the fastest rate, that are followed.
REACH = 4
#: What the reference set out to be.
GOAL = 1e-15


def first_turns(scenario: Scenario) -> tuple[float, float]:
    """s that are followed, and the fastest rate, 1/s."""
    motion = solve(scenario, scenario.times).trajectory
    speed = float(norms(motion.omega_body).max())
    rate = fastest_rate(scenario, motion.omega_body) + speed
    return min(scenario.window.duration, REACH / rate), rate


def apart(motion: Trajectory, state: State) -> dict[str, float]:
    """Distances of the last sample from a state, in the norms of the signals."""
    speed = float(norms(motion.omega_body).max())
    fastest = np.abs(motion.spins).max(axis=0) + speed
    R = state.R.astype(float)
    return {
        "omega": float(np.linalg.norm((motion.omega_body[-1] - state.omega).astype(float))) / speed,
        "attitude": float(norms(turn_between(motion.q_world_body_wxyz[-1], R))[0]),
        "spins": float((np.abs((motion.spins[-1] - state.spins).astype(float)) / fastest).max()),
    }


def turn_between(q_wxyz: FloatArray, R: FloatArray) -> FloatArray:
    other = Rotation.from_matrix(R).as_quat(scalar_first=True)
    return rotation_vectors(q_wxyz[None], other[None])


@each_case("scenario", SCENES)
def test_the_motion_is_that_of_coupled_bodies(scenario: Scenario) -> None:
    time, rate = first_turns(scenario)
    times = np.linspace(0.0, time, 9)
    solution = solve(scenario, times)
    with mp.workdps(DIGITS):
        (state,) = of_scene(scenario).motion([time], rate)
        off = apart(solution.trajectory, state)
        assert max(off.values()) <= GOAL, off
        assert off["omega"] <= solution.uncertainty.omega
        assert off["attitude"] <= solution.uncertainty.attitude
        if scenario.rotors.is_free.any() and "symmetric" not in scenario.document.tags:
            # Teeth: free rotors that are taken for driven ones, unless u·ω stays by symmetry.
            wrong = solve(all_driven(scenario), times).trajectory
            assert max(apart(wrong, state).values()) > GOAL


def all_driven(scenario: Scenario) -> Scenario:
    rotors = tuple(
        one.model_copy(update={"hinge": "driven"}) if one.hinge == "free" else one
        for one in scenario.document.rotors or ()
    )
    return with_tables(scenario, rotors=rotors)


#: A symmetric body with rotors about its axis, one off it; some 600 turns.
GYROSTAT = """spincheck = 1
title = "A symmetric body with two rotors along its axis"
source = "made up"
[body]
mass = 1.0
inertia = [0.002, 0.002, 0.003]
[start]
rotation_vector_deg = [20.0, -40.0, 70.0]
omega_body = [3.0, -1.0, 2.0]
[[rotors]]
axis = [0.0, 0.0, 1.0]
position = [0.0, 0.0, 0.05]
mass = 0.1
inertia = [2e-5, 3e-5]
spin = 300.0
hinge = "free"
[[rotors]]
axis = [0.0, 0.0, -1.0]
position = [0.0, 0.0, -0.08]
mass = 0.2
inertia = [5e-5, 4e-5]
spin = {spin}
hinge = "driven"
[window]
duration = 400.0
samples = 41
"""
#: Relative, of a rotor's spin: a fault that must show.
PLANTED = 1e-12


def closed_form(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """The attitude's quaternion and ω in body axes of a free symmetric gyrostat, at its times.

    By symmetry ω₃ stays, and so does L₃ = I₃ ω₃ + Σ C s u₃.
    """
    start, inertia = scenario.start, scenario.body.inertia_com_exact
    with mp.workdps(DIGITS):
        across, along, (w1, w2, w3) = inertia[0][0], inertia[2][2], start.omega_body_exact
        L3 = along * w3 + sum(one.along * one.spin * one.axis[2] for one in scenario.rotors.each)
        L = across * w1, across * w2, L3
        begun = across, L, start.q_exact, start.omega_body_exact, 2
        states = [two_turns(*begun, t) for t in map(mpf, scenario.times.tolist())]
        return tuple(np.array([s[k] for s in states], dtype=float) for k in range(2))


def off_closed_form(scenario: Scenario, told: Scenario) -> float:
    """By how much the exact motion of one scene is off another's, in what it may be off."""
    solution = solve(scenario, scenario.times)
    motion, own = solution.trajectory, solution.uncertainty
    attitude, omega = closed_form(told)
    turned = norms(rotation_vectors(motion.q_world_body_wxyz, attitude))
    off = norms(motion.omega_body - omega) / norms(omega).max()
    spins = np.abs(motion.spins - told.rotors.start_spins) / np.abs(motion.spins).max()
    largest = turned.max() / own.attitude, off.max() / own.omega, spins.max() / own.omega
    return float(max(largest))


@each_case("spin", [0.0, 150.0, -450.0])
def test_a_free_symmetric_gyrostat_is_its_closed_form(spin: float) -> None:
    scenario = loads(GYROSTAT.format(spin=spin), "gyrostat")
    assert off_closed_form(scenario, scenario) <= 1
    faster = varied(scenario, {"rotors[0].spin": 300.0 * (1 + PLANTED)})
    assert off_closed_form(scenario, faster) > 1
