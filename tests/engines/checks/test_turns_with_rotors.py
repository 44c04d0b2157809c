"""ω that a rotor turns within a step may be far from that at its ends; in other axes it is told."""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.engines import State
from spincheck.engines.checks.bounds import Bounds
from spincheck.engines.checks.faults import faults
from spincheck.engines.checks.turn_faults import Reading
from spincheck.reference import solve
from spincheck.scenarios.fastest_rate import parts_rate
from spincheck.scenarios.rotation import matrices

SCENE = library_scene("gyroscope-in-its-frame")
#: rad that ω is turned in a step: nearly once around, and a small part.
COARSE, FINE = 5.9, 0.05
STEPS = 8
EPS = float(np.finfo(float).eps)


def exact_states(turn: float) -> tuple[State, float]:
    """States of the exact motion, a step apart; and the timestep, s."""
    timestep = turn / parts_rate(SCENE)
    motion = solve(SCENE, timestep * np.arange(STEPS)).trajectory
    held = motion.q_world_body_wxyz, motion.omega_body, motion.com_world, motion.velocity_world
    return State(*held), timestep


def causes(states: State, timestep: float, rate: float) -> list[str]:
    none = states.rows(slice(0, 0))
    reading = Reading(states, np.arange(STEPS), none)
    return [one.cause for one in faults(reading, Bounds(timestep, np.inf, EPS, rate))]


@pytest.mark.parametrize("turn", [COARSE, FINE])
def test_omega_may_go_round_within_a_step(turn: float) -> None:
    assert causes(*exact_states(turn), parts_rate(SCENE)) == []


def test_without_the_rate_of_rotors_that_is_a_fault() -> None:
    assert causes(*exact_states(COARSE), 0.0) != []


def test_omega_in_axes_of_space_is_told() -> None:
    states, timestep = exact_states(FINE)
    R_world_body = matrices(states.q_world_body_wxyz)
    omega_world = np.einsum("nij,nj->ni", R_world_body, states.omega_body)
    read = replace(states, omega_body=omega_world)
    assert causes(read, timestep, parts_rate(SCENE)) == ["frames"]
