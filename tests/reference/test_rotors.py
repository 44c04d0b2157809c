"""Scenes with rotors against the second derivation: all that the library has.

Verified: ω, attitude and spins over the first turns, to 1e-15 and to the uncertainty stated. Over
long times conservation laws are all that is verified.
"""

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library
from mpmath import mp
from scipy.spatial.transform import Rotation
from second_derivation import DIGITS, State, of_scene
from spincheck.reference import solve
from spincheck.scenarios import FloatArray, Scenario, Trajectory
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.scenarios.rotation import norms, rotation_vectors
from spincheck.scenarios.scenario import with_tables

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
