"""Rates and limits that theory gives for a scene and a timestep, against values by hand."""

import math

import numpy as np
import pytest
from spincheck.reference import solve
from spincheck.reference.stability import perturbation_rate_squared
from spincheck.reference.stability_bounds import (
    RK4_LIMIT,
    RK4_STRONGEST,
    UPRIGHT,
    euler_folds,
    euler_log_amplification,
    rk4_folds,
    rk4_log_amplification,
    stability_numbers,
)
from top_scenes import ASYMMETRIC, PIVOT, scene

EPS = np.finfo(float).eps
#: A few roundings in a formula of a few terms.
ROUNDED = 16 * EPS
#: A general eigenvalue problem 3 × 3, whose matrix has entries of the size of its eigenvalues.
EIGENVALUES = 64 * EPS
WOBBLING = "mass = 1.0\ninertia = [2.0, 2.0, 3.0]"


def numbers(body=WOBBLING, start=(0.0, 0.0, 8.0), effects="", tilt=0.0):
    turns = f"euler_zyz_deg = [0.0, {tilt}, 0.0]\nomega_body = {list(start)}"
    return stability_numbers(scene(body, turns, effects))


def top(omega3, tilt=0.0):
    """I1 = 2, I3 = 1 kg m², M g l = 10 N m; upright or not."""
    return scene(start=f"euler_zyz_deg = [0.0, {tilt}, 0.0]\nomega_body = [0.0, 0.0, {omega3}]")


def test_a_symmetric_body_s_rate_is_that_of_its_body_cone():
    """(I3 − I1)/I1 ω3 = (3 − 2)/2 · 8 rad/s."""
    computed = numbers()
    assert computed.gyration == pytest.approx(4.0, rel=EIGENVALUES)
    assert computed.turning == 8.0


def test_the_rate_does_not_depend_on_the_axes():
    turned = numbers("mass = 1.0\ninertia = [3.0, 2.0, 2.0]", (8.0, 0.0, 0.0))
    assert turned.gyration == pytest.approx(4.0, rel=EIGENVALUES)


@pytest.mark.parametrize("axis", [0, 2], ids=["smallest", "largest"])
def test_about_an_extreme_axis_the_rate_is_that_of_the_wobble(axis):
    omega = [0.0, 0.0, 0.0]
    omega[axis] = 2.0
    by_hand = math.sqrt(-perturbation_rate_squared((3.0, 4.0, 6.0), axis, 2.0))
    assert numbers(ASYMMETRIC, omega).gyration == pytest.approx(by_hand, rel=EIGENVALUES)


def test_about_the_middle_axis_the_rate_is_that_of_the_flip():
    """There 3 ω1² + 6 ω3² = 16 and 9 ω1² + 36 ω3² = 64, so ω1² = 32/9 and ω3² = 8/9.

    λ² = ω3² (6 − 4)(6 − 3)/(3 · 4) + ω1² (6 − 3)(4 − 3)/(4 · 6) = 4/9 + 4/9.
    """
    gyration = numbers(ASYMMETRIC, (0.0, 2.0, 0.0)).gyration
    assert gyration == pytest.approx(math.sqrt(8 / 9), rel=EIGENVALUES)
    # Faster than small deviations grow about the axis itself, at 2 √(1 · 2/(3 · 6)) = 2/3 a second.
    assert gyration > 2 * math.sqrt(perturbation_rate_squared((3.0, 4.0, 6.0), 1, 1.0))


def test_the_rate_of_a_free_body_is_the_same_all_along_its_motion():
    """What is conserved decides, as soon as the plane is where it is fastest."""
    scenario = scene(ASYMMETRIC, "euler_zyz_deg = [0, 0, 0]\nomega_body = [0.1, 2.0, 0.1]", "")
    states = solve(scenario, np.linspace(0.0, 2.0, 5)).trajectory.omega_body
    gyrations = [numbers(ASYMMETRIC, state).gyration for state in states.tolist()]
    assert gyrations == pytest.approx([gyrations[0]] * len(gyrations), rel=64 * EPS)


def test_a_sphere_has_no_rate_of_its_own():
    assert numbers("mass = 1.0\ninertia = [2.0, 2.0, 2.0]").gyration == 0.0


def test_swings_are_those_of_the_hanging_pendulum():
    """√(M g l/I1) = √(10/2)."""
    assert stability_numbers(top(0.0)).swinging == pytest.approx(math.sqrt(5), rel=ROUNDED)


@pytest.mark.parametrize("effects", ["", PIVOT])
def test_nothing_swings_without_gravity_about_a_pivot(effects):
    assert (
        numbers("mass = 1.0\ninertia = [2, 2, 3]\ncom = [0, 0, 1]", effects=effects).swinging == 0
    )


def test_the_sleeping_ratio_is_one_at_the_threshold():
    """p_γ² = 4 M g l I1 is (1 · ω3)² = 4 · 10 · 2."""
    assert stability_numbers(top(math.sqrt(80))).sleeping == pytest.approx(1.0, rel=ROUNDED)
    assert stability_numbers(top(2 * math.sqrt(80))).sleeping == pytest.approx(4.0, rel=ROUNDED)


@pytest.mark.parametrize(("tilt_deg", "sleeps"), [(0.0, True), (5.0, True), (6.0, False)])
def test_only_an_upright_top_sleeps(tilt_deg, sleeps):
    assert (math.radians(tilt_deg) <= UPRIGHT) is sleeps
    assert (stability_numbers(top(8.0, tilt_deg)).sleeping is not None) is sleeps


def test_a_hanging_top_does_not_sleep():
    assert stability_numbers(top(8.0, 180.0)).sleeping is None


def test_the_separatrix_is_where_twice_the_kinetic_energy_times_the_middle_moment_is_l_squared():
    """Σ I (I − I2) ω² = 0: 3 · (−1) ω1² + 6 · 2 ω3², so ω1 = 2 ω3."""
    assert numbers(ASYMMETRIC, (2.0, 1.0, 1.0)).separatrix == 0.0
    assert numbers(ASYMMETRIC, (2.1, 1.0, 1.0)).separatrix < 0
    assert numbers(ASYMMETRIC, (1.9, 1.0, 1.0)).separatrix > 0


def test_there_is_no_separatrix_with_equal_moments_or_with_a_torque():
    assert numbers().separatrix is None
    driven = "[effects.torque]\nbody = [0.0, 0.0, 1.0]"
    assert numbers(ASYMMETRIC, effects=driven).separatrix is None


def test_runge_kutta_neither_damps_nor_amplifies_at_its_limit():
    """y² = 8 makes y⁶/72 = y⁸/576 = 64/9, of which a few ulp remain."""
    assert abs(rk4_log_amplification(RK4_LIMIT)) < 8 * 64 / 9 * EPS
    assert rk4_log_amplification(0.99 * RK4_LIMIT) < 0 < rk4_log_amplification(1.01 * RK4_LIMIT)


@pytest.mark.parametrize("y", [0.1, 1.0, 2.0, 2.9, 4.0])
def test_amplifications_are_those_of_the_stability_functions(y):
    z = 1j * y
    series = 1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24
    # The product of |R|² and its logarithm's error, of terms up to y⁸/576.
    rounding = 8 * EPS * (1 + y**8 / 576) / min(1, abs(series)) ** 2
    assert rk4_log_amplification(y) == pytest.approx(math.log(abs(series)), abs=rounding)
    assert euler_log_amplification(y) == pytest.approx(math.log(abs(1 + z)), abs=rounding)


def test_runge_kutta_damps_most_where_it_is_said_to():
    beside = [rk4_log_amplification(factor * RK4_STRONGEST) for factor in (0.999, 1.0, 1.001)]
    assert beside[1] == min(beside)
    assert beside[1] == pytest.approx(math.log(1 / 2), rel=ROUNDED)  # 1 − 216/72 + 1296/576 = ¼


def test_folds_are_those_of_small_steps():
    """½ λ² h T = ½ · 9 · 10⁻⁶ · 10 and λ⁶ h⁵/144 · T; what is left out is of the order (λh)²."""
    rate, timestep, duration = 3.0, 1e-6, 10.0
    left_out = (rate * timestep) ** 2 + ROUNDED
    assert euler_folds(rate, timestep, duration) == pytest.approx(4.5e-5, rel=left_out)
    coarse = 1e-3
    by_hand = rate**6 * coarse**5 / 144 * duration
    left_out = (rate * coarse) ** 2
    assert rk4_folds(rate, coarse, duration) == pytest.approx(by_hand, rel=left_out)


def test_beyond_the_strongest_damping_it_is_counted_as_strongest():
    steps = 10.0
    assert rk4_folds(1.0, 2.8, 28.0) == pytest.approx(steps * math.log(2), rel=ROUNDED)
