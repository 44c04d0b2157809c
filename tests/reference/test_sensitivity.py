"""What conservation, a closed form and the flow's being one say of the derivatives of a motion."""

from collections.abc import Callable

import numpy as np
import pytest
import top_scenes
from library_scenes import library_scene
from scene_texts import scene
from scipy.spatial.transform import Rotation
from spincheck.reference import ExactMotion, IntegrationError, Sensitivity, sensitivity
from spincheck.reference.parameter_changes import ENTRIES
from spincheck.reference.solve import ROUNDING
from spincheck.scenarios import Scenario, Trajectory
from spincheck.scenarios.rotation import across
from spincheck.scenarios.scenario import started_at

EPS = float(np.finfo(float).eps)
TIMES = np.linspace(0.0, 4.0, 9)
#: Sums of some dozens of products of rounded numbers each.
SUMS = 64 * EPS

FREE = scene(
    ("inertia = [1.0, 2.0, 2.5]", "inertia = [[2.0, 0.3, 0.1], [0.3, 2.5, 0.2], [0.1, 0.2, 3.0]]")
)
HEAVY = library_scene("lopsided-body")
#: What is wrong with a transition, to see that a test notices.
FAULTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "transposed": lambda phi: phi.swapaxes(1, 2),
    "turned the other way": lambda phi: phi * np.repeat([-1.0, 1.0], 3)[:, None],
    "as if nothing turned": lambda phi: np.broadcast_to(np.eye(6), phi.shape),
}


def motion_of(scenario: Scenario, times: np.ndarray = TIMES) -> tuple[Trajectory, Sensitivity]:
    motion = ExactMotion(scenario).outline(times)
    return motion, sensitivity(scenario, motion)


def apart(ones: np.ndarray, others: np.ndarray) -> float:
    return float(np.abs(ones - others).max() / np.abs(others).max())


def gradient_of_momentum(scenario: Scenario, motion: Trajectory) -> np.ndarray:
    """δL of a free body by attitude and ω, world axes, (n, 3, 6): R (δθ × Iω + I δω)."""
    momenta = motion.omega_body @ scenario.inertia
    blocks = [np.hstack([across(L).T, scenario.inertia]) for L in momenta]
    return motion.R_world_body.as_matrix() @ np.array(blocks)


def gradient_of_energy(scenario: Scenario, motion: Trajectory) -> np.ndarray:
    """δE of a body on a pivot by attitude and ω, (n, 1, 6)."""
    pull = scenario.gravity_world @ motion.R_world_body.as_matrix()
    weight = -scenario.body.mass * np.cross(scenario.body.com, pull)
    return np.hstack([weight, motion.omega_body @ scenario.inertia])[:, None, :]


def kept(gradient: np.ndarray, transition: np.ndarray) -> float:
    """How far a gradient's change along a transition is from that at the start."""
    return apart(gradient @ transition, np.broadcast_to(gradient[:1], gradient.shape))


@pytest.mark.parametrize(
    ("scenario", "gradient"),
    [(FREE, gradient_of_momentum), (HEAVY, gradient_of_energy)],
    ids=["L of a free body", "energy of a heavy one"],
)
def test_what_is_kept_is_changed_by_the_start_alone(scenario, gradient) -> None:
    motion, found = motion_of(scenario)
    bound = SUMS * found.conditioning.max()
    phi = found.state_transition
    assert kept(gradient(scenario, motion), phi) < bound
    for name, fault in FAULTS.items():
        assert kept(gradient(scenario, motion), fault(phi)) > 1e3 * bound, name


def test_L_is_changed_by_the_inertia_as_at_the_start() -> None:
    motion, found = motion_of(FREE)
    gradient = gradient_of_momentum(FREE, motion)
    for column, (i, j) in enumerate(ENTRIES):
        entry = np.zeros((3, 3))
        entry[i, j] = entry[j, i] = 1.0
        own = motion.R_world_body.apply(motion.omega_body @ entry)
        change = (gradient @ found.inertia[:, :, column, None])[..., 0] + own
        assert apart(change, np.broadcast_to(own[0], own.shape)) < SUMS * found.conditioning.max()
        assert apart(change - own, np.broadcast_to(own[0], own.shape)) > 0.1, "and not by chance"


def test_energy_is_changed_by_the_mass_as_at_the_start() -> None:
    motion, found = motion_of(HEAVY)
    com = HEAVY.body.com
    swing = np.cross(motion.omega_body, com)
    own = (swing**2).sum(1) / 2 - motion.R_world_body.as_matrix() @ com @ HEAVY.gravity_world
    change = (gradient_of_energy(HEAVY, motion) @ found.mass[..., None])[:, 0, 0] + own
    assert apart(change, np.full(len(own), own[0])) < SUMS * found.conditioning.max()
    assert apart(own, np.full(len(own), own[0])) > 1e-3


@pytest.mark.parametrize("name", ["book-in-skew-axes", "lopsided-body", "gliding-top"])
def test_transitions_one_after_the_other_are_one(name: str) -> None:
    scenario = library_scene(name)
    ends = np.array([0.5, 1.25]) * min(1.0, scenario.window.duration / 2)
    motion, whole = motion_of(scenario, ends)
    states = motion.q_world_body_wxyz, motion.omega_body, motion.com_world, motion.velocity_world
    _, after = motion_of(started_at(scenario, *(x[0] for x in states)), np.diff(ends))
    early, late = whole.state_transition
    bound = SUMS * np.prod([*whole.conditioning, *after.conditioning])
    assert apart(after.state_transition[0] @ early, late) < bound
    assert apart(early @ after.state_transition[0], late) > 1e3 * bound
    assert apart(after.state_transition[0].T @ early, late) > 1e3 * bound


A, C, OMEGA = 2.0, 3.0, np.array([0.4, -0.3, 1.5])
SYMMETRIC = scene(
    ("inertia = [1.0, 2.0, 2.5]", f"inertia = [{A}, {A}, {C}]"),
    ("omega_body = [0.5, 1.0, -2.0]", f"omega_body = {OMEGA.tolist()}"),
)
AXIS = np.array([0.0, 0.0, 1.0])


def right_jacobian(turn: np.ndarray) -> np.ndarray:
    """J of Exp(φ + δ) = Exp(φ) Exp(J δ) (Sola, Deray & Atchuthan, arXiv:1812.01537, eq. 143)."""
    angle, cross = float(np.linalg.norm(turn)), across(turn)
    if not angle:
        return np.eye(3)
    first, second = (1 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    return np.eye(3) - first * cross + second * cross @ cross


def of_symmetric_top(t: float, of_p: np.ndarray, of_s: np.ndarray) -> np.ndarray:
    """Derivatives, (6, k), of R₀ Exp(p t) Exp(s ẑ t) and of Exp(−s ẑ t) ω₀, given those of p, s.

    p = (ω₁, ω₂, C ω₃/A) at the start, s = (1 − C/A) ω₃ (Landau & Lifshitz, Mechanics, §35-36).
    """
    p, s = OMEGA * [1, 1, C / A], (1 - C / A) * OMEGA[2]
    back = Rotation.from_rotvec(-s * t * AXIS).as_matrix()
    turn = back @ right_jacobian(p * t) @ of_p * t + np.outer(AXIS, of_s) * t
    return np.vstack([turn, -back @ np.outer(np.cross(AXIS, OMEGA), of_s) * t])


def test_a_free_symmetric_top_has_the_derivatives_of_its_closed_form() -> None:
    _, found = motion_of(SYMMETRIC)
    of_moments = found.moments @ [[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    for k, t in enumerate(TIMES):
        p, s = OMEGA * [1, 1, C / A], (1 - C / A) * OMEGA[2]
        back = Rotation.from_rotvec(-s * t * AXIS)
        on = (Rotation.from_rotvec(p * t) * back.inv()).inv().as_matrix()
        by_omega = of_symmetric_top(t, np.diag([1, 1, C / A]), (1 - C / A) * AXIS)
        by_omega[3:] += back.as_matrix()
        by_attitude = np.vstack([on, np.zeros((3, 3))])
        transition = np.hstack([by_attitude, by_omega])
        w = OMEGA[2]
        slopes = np.outer(AXIS, [-C * w / A**2, w / A]), np.array([C * w / A**2, -w / A])
        by_moments = of_symmetric_top(t, *slopes)
        turned = 1 + t * float(np.linalg.norm(p))
        assert apart(found.state_transition[k], transition) < SUMS * turned
        assert np.abs(of_moments[k] - by_moments).max() < SUMS * turned**2
        # A and C swapped: the body turns the other way in itself.
        assert not t or np.abs(of_moments[k, :, ::-1] - by_moments).max() > 0.1


def test_a_body_at_rest_has_the_oscillation_of_its_derivatives() -> None:
    """A pendulum that hangs still: its series is a constant, that of its derivative a cosine."""
    still = top_scenes.scene(
        "mass = 1.0\ninertia = [1.0, 1.0, 1.0]\ncom = [0.0, 0.0, -1.0]",
        "euler_zyz_deg = [0.0, 0.0, 0.0]\nomega_body = [0.0, 0.0, 0.0]",
        "[effects.pivot]\n[effects.gravity]\nacceleration = [0.0, 0.0, -8.0]",
    )
    _, found = motion_of(still)
    cosine = np.cos(2 * TIMES)
    for axis in range(2):
        assert found.state_transition[:, axis, axis] == pytest.approx(cosine, abs=SUMS * 8)
    assert found.state_transition[:, 2, 2] == pytest.approx(1.0, abs=SUMS)


def test_what_a_scene_lacks_has_no_derivatives_and_all_that_it_has_do() -> None:
    _, free = motion_of(FREE)
    assert set(free.parameters) == {"inertia", "moments", "mass", "com"}
    with pytest.raises(
        AttributeError, match="'drag' must be a parameter of the scene, which has in"
    ):
        _ = free.drag
    assert not free.mass.any()
    assert not free.com.any()
    assert free.translation["state_transition"].shape == (len(TIMES), 6, 12)
    flight = free.translation["state_transition"][-1]
    np.testing.assert_array_equal(flight[:3, 9:], TIMES[-1] * np.eye(3))
    _, heavy = motion_of(HEAVY)
    assert heavy.translation is None
    assert heavy.gravity.shape == (len(TIMES), 6, 3)
    _, wheels = motion_of(library_scene("wheels-in-syrup"), TIMES[:2])
    assert wheels.spins.shape == (2, 6, len(library_scene("wheels-in-syrup").rotors.each))
    assert wheels.drag.shape == (2, 6)


def test_arrays_are_read_only_and_as_exact_as_stated() -> None:
    _, found = motion_of(HEAVY)
    arrays = [found.t, found.state_transition, *found.parameters.values(), found.conditioning]
    assert not any(array.flags.writeable for array in arrays)
    assert all(ROUNDING <= value < 1e-14 for value in found.uncertainty.values())
    assert found.conditioning[0] == pytest.approx(1.0, abs=SUMS)


def test_a_span_of_too_many_steps_is_refused() -> None:
    scenario = library_scene("million-turns")
    with pytest.raises(
        IntegrationError, match=r"take more than .* steps beyond .* Ask for earlier times"
    ):
        motion_of(scenario, np.array([scenario.window.duration]))
