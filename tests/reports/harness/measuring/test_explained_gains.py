"""Changes of equations that no planted engine has are found in gains that are given as formulas."""

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library_scene
from spincheck.engines.checks.equations import Equations
from spincheck.reference import ExactMotion
from spincheck.reports.harness.explaining.hypothesis import as_it_is
from spincheck.reports.harness.measuring.explained_gains import Gains, explanations
from spincheck.reports.harness.measuring.places import places


@each_case("name", ["football-spiral", "book-with-drag", "fast-top"])
def test_dry_friction_is_named_with_its_torque(name: str) -> None:
    """A torque of one size against ω, as of MuJoCo's `frictionloss`, in place of drag."""
    scenario, size = library_scene(name), 1e-3
    states = places(scenario, ExactMotion(scenario).outline(scenario.times), None).states
    omega = states.omega_body
    excess = np.zeros((len(omega), 4, 3))
    excess[:, 1] = scenario.pushed["drag"] * omega
    excess[:, 1] -= size * omega / np.linalg.norm(omega, axis=1, keepdims=True)
    noise = np.full((len(omega), 4), 1e-9 * np.abs(excess).max())
    (found,) = explanations(Gains(as_it_is(scenario), Equations(scenario), states, excess, noise))
    assert found.kind == "drag's law"
    assert found.numbers == pytest.approx((size, 0.0), abs=1e-9)


@each_case("name", ["gyrocompass", "wheel-in-a-box"])
def test_spins_of_free_rotors_that_are_left_out_of_the_torque_are_named(name: str) -> None:
    """The torque ω × h is then short by ω × C s u, with the axial moment C and the axle u."""
    scenario = library_scene(name)
    states = places(scenario, ExactMotion(scenario).outline(scenario.times), None).states
    spinning = states.spins @ scenario.rotors.axial_body
    excess = np.zeros((len(spinning), 4, 3))
    excess[:, 1] = np.cross(states.omega_body, spinning)
    noise = np.full((len(spinning), 4), 1e-9 * np.abs(excess).max())
    gains = Gains(as_it_is(scenario), Equations(scenario), states, excess, noise)
    assert [one.kind for one in explanations(gains)] == ["spins left out"]
