"""Properties of MuJoCo's integrators, measured."""

import numpy as np
import pytest
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.scenarios import Scenario, Trajectory, energy
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps
#: A dozen products of rotations and vectors.
ROUNDOFF = 64 * EPS
COARSE_TIMESTEP = 1e-2
MUJOCO = MuJoCo()


def motion(scene: Scenario, integrator: str, steps: np.ndarray, timestep: float) -> Trajectory:
    run = MUJOCO.run(scene, MUJOCO.method(integrator), timestep, steps)
    assert run.trajectory is not None
    return run.trajectory


def omega(name: str, integrator: str) -> np.ndarray:
    return motion(SCENES[name], integrator, np.arange(0, 101, 10), COARSE_TIMESTEP).omega_body


@pytest.mark.parametrize("name", ["pivot", "pivot-drag", "heavy-tilted"])
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_on_a_pivot_implicitfast_and_discrete_are_euler(name: str, integrator: str) -> None:
    assert np.array_equal(omega(name, integrator), omega(name, "Euler"))
    assert not np.array_equal(omega(name, "implicit"), omega(name, "Euler"))


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_on_a_free_body_implicitfast_and_discrete_are_implicit(integrator: str) -> None:
    assert np.array_equal(omega("free", integrator), omega("free", "implicit"))
    assert not np.array_equal(omega("free", integrator), omega("free", "Euler"))


def energy_changes(integrator: str) -> np.ndarray:
    """Relative change of energy from sample to sample of a free tumble."""
    free = SCENES["free"]
    energies = energy(free, motion(free, integrator, np.arange(0, 101, 10), COARSE_TIMESTEP))
    return np.diff(energies) / energies[0]


def test_implicit_drains_a_tumble_steadily_and_rk4_does_not() -> None:
    # By about (h |ω|)² a step: 1.4e-3 at |ω| = 3.7 rad/s and h = 10 ms.
    per_sample = 10 * (COARSE_TIMESTEP * np.linalg.norm(SCENES["free"].start.omega_body)) ** 2
    drained = energy_changes("implicit")
    assert (drained < 0).all()
    assert -drained.sum() > per_sample / 10
    assert np.abs(energy_changes("RK4")).max() < 1e-3 * per_sample
