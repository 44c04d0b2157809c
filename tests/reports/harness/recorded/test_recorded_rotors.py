"""Recordings of bodies with rotors, whose spins they do not have."""

from pathlib import Path

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.reference import solve
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.recording import Recording

pytestmark = pytest.mark.slow

SCENE = library_scene("wheel-in-a-box")
EPS = float(np.finfo(float).eps)


def recording(factor: float) -> Recording:
    motion = solve(SCENE, SCENE.times[:51]).trajectory
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": factor * motion.omega_body}
    return Recording(Path("wheel.csv"), arrays)


def test_the_exact_motion_is_right_and_nothing_is_said_of_what_it_does_not_have() -> None:
    judged = judged_motion(SCENE, recording(1.0))
    assert judged.errors["omega"] == 0.0
    assert judged.errors["attitude"] <= 4 * EPS
    assert "rotors_momentum" not in judged.drifts


def test_a_wrong_angular_velocity_is_seen_in_the_angular_momentum_too() -> None:
    judged = judged_motion(SCENE, recording(1.001))
    assert judged.errors["omega"] > 1e-4
    assert judged.errors["angular_momentum"] > 1e-4
