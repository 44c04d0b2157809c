"""Properties of MuJoCo's integrators, measured."""

import numpy as np
import pytest
from mujoco_sessions import TIMESTEP, planted
from scipy.spatial.transform import Rotation
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


def attitude_order(attitudes: list[Rotation]) -> float:
    """Signed order from three runs, each with half the timestep of the last."""
    coarse, medium, fine = attitudes
    difference = (coarse.inv() * medium).magnitude() / (medium.inv() * fine).magnitude()
    return float(np.log2(difference))


def uncorrected_rk4(steps: int) -> Rotation:
    """RK4 as MuJoCo had it up to 3.17: the stages' ω averaged as if rotations commuted."""
    body, start = SCENES["free"].body, SCENES["free"].start
    inertia = body.inertia_com
    q, w = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True), start.omega_body

    def alpha(omega: np.ndarray) -> np.ndarray:
        return np.linalg.solve(inertia, -np.cross(omega, inertia @ omega))

    h = 0.5 / steps
    for _ in range(steps):
        stages = [w]
        for fraction in (0.5, 0.5, 1.0):
            stages.append(w + fraction * h * alpha(stages[-1]))
        weights = np.array([1, 2, 2, 1]) / 6
        q = q * Rotation.from_rotvec(h * weights @ np.array(stages))
        w = w + h * weights @ np.array([alpha(stage) for stage in stages])
    return q


def test_attitude_is_of_fourth_order_and_would_be_of_second_without_the_correction() -> None:
    ladder = (32, 64, 128)
    runs = [motion(SCENES["free"], "RK4", np.array([0, n]), 0.5 / n) for n in ladder]
    by_mujoco = attitude_order([run.R_world_body[-1] for run in runs])
    without = attitude_order([uncorrected_rk4(n) for n in ladder])
    assert (round(by_mujoco), round(without)) == (4, 2)


def test_free_drag_leaves_the_translation_alone() -> None:
    """Damping of the free joint itself would brake it too."""
    dragged, undragged = (
        motion(SCENES[name], "RK4", np.array([0, 100]), TIMESTEP)
        for name in ("free-drag", "free-tilted")
    )
    slack = 100 * ROUNDOFF
    assert np.abs(dragged.velocity_world[-1] - undragged.velocity_world[-1]).max() < slack
    assert np.abs(dragged.omega_body[-1] - undragged.omega_body[-1]).max() > 1e9 * slack
    damped = planted(
        SCENES["free-tilted"],
        ('damper="disable"', 'damper="enable"'),
        ('<freejoint name="joint" align="false" />', '<joint type="free" damping="0.3"/>'),
    )
    damped.advance(100)
    braked = damped.read_state().velocity_world - undragged.velocity_world[-1]
    assert np.abs(braked).max() > 1e9 * slack
