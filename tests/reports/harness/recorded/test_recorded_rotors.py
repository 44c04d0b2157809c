"""Recordings of bodies with rotors, whose spins they do not have."""

from pathlib import Path

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.reference import solve
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.recording import Recording

pytestmark = pytest.mark.slow

SCENE = library_scene("wheel-in-a-box")
EPS = float(np.finfo(float).eps)


def judged(factor: float) -> JudgedMotion:
    motion = solve(SCENE, SCENE.times[:51]).trajectory
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": factor * motion.omega_body}
    return judged_motion(SCENE, Recording(Path("wheel.csv"), arrays))


def test_a_wrong_omega_is_seen_in_L_too_and_nothing_is_said_of_spins_that_are_not_there() -> None:
    exact, wrong = judged(1.0), judged(1.001)
    assert exact.errors["omega"] == 0.0
    assert exact.errors["attitude"] <= 4 * EPS
    assert "rotors_momentum" not in exact.drifts
    assert wrong.errors["omega"] > 1e-4
    assert wrong.errors["angular_momentum"] > 1e-4
