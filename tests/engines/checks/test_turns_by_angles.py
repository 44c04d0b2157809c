"""A first-order rule that steps roll, pitch and yaw passes; other faults are still detected."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.engines import State
from spincheck.engines.checks.bounds import Bounds
from spincheck.engines.checks.faults import faults
from spincheck.engines.checks.turn_faults import Reading

TIMESTEP = 1e-3
EPS = float(np.finfo(float).eps)
OMEGA_WORLD = np.array([30.0, -10.0, 20.0])
ROLL, YAW = 0.4, -1.1


def rates(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Of roll, pitch and yaw, from ω in world axes (Diebel 2006, §5.6.12)."""
    x, y, z = OMEGA_WORLD
    along = x * np.cos(yaw) + y * np.sin(yaw)
    roll_rate = along / np.cos(pitch)
    return np.array([roll_rate, y * np.cos(yaw) - x * np.sin(yaw), z + roll_rate * np.sin(pitch)])


def one_step(pitch: float, omega_world: np.ndarray = OMEGA_WORLD) -> Reading:
    """Of a sphere that nothing acts on, ω read as told."""
    angles = np.array([ROLL, pitch, YAW])
    stepped = angles + TIMESTEP * rates(*angles)
    turned = Rotation.from_euler("xyz", [angles, stepped])
    zeros = np.zeros((2, 3))
    q = turned.as_quat(scalar_first=True)
    state = State(q, turned.inv().apply(omega_world), zeros, zeros)
    none = State(q[:0], zeros[:0], zeros[:0], zeros[:0])
    return Reading(state, np.array([1, 2]), none)


def causes(reading: Reading, by_angles: bool) -> list[str]:
    return [
        fault.cause
        for fault in faults(reading, Bounds(TIMESTEP, np.inf, EPS, 0.0, None, by_angles))
    ]


@pytest.mark.parametrize("pitch", [0.0, 0.6, 1.2, 1.5])
def test_a_step_of_angles_is_within_the_bound_that_follows_from_their_pitch(pitch: float) -> None:
    assert causes(one_step(pitch), by_angles=True) == []


def test_of_a_rule_that_steps_no_angles_the_same_turn_is_a_fault() -> None:
    assert causes(one_step(1.2), by_angles=False) != []


@pytest.mark.parametrize("pitch", [0.0, 0.6])
def test_omega_in_another_order_is_a_fault_of_either(pitch: float) -> None:
    assert causes(one_step(pitch, OMEGA_WORLD[[1, 0, 2]]), by_angles=True) == ["frames"]
