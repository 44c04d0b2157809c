"""Euler angles: conversions are inverses, exact to rounding, at the poles too."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.reference.euler_angles import (
    euler_zyz_from_quaternion,
    rates_from_omega_body,
)
from spincheck.scenarios.exact import from_euler_zyz_deg, omega_body_from_zyz_rates

EPS = np.finfo(float).eps
#: A conversion there and back takes some ten roundings of numbers of order one.
ROUND_TRIP = 10 * EPS
RANDOM = np.random.default_rng(29)
ATTITUDES = Rotation.random(1000, rng=RANDOM).as_quat(scalar_first=True)
ANGLES = np.column_stack(
    [RANDOM.uniform(-3, 3, 1000), RANDOM.uniform(0.1, 3.0, 1000), RANDOM.uniform(-3, 3, 1000)]
)


def attitudes(angles):
    """Unit quaternions of intrinsic turns about z, y, z, by scipy; angles in rad."""
    return Rotation.from_euler("ZYZ", angles).as_quat(scalar_first=True)


def turn_between(p, q):
    """Angle between attitudes, whatever the signs of the quaternions."""
    difference = Rotation.from_quat(p, scalar_first=True).inv() * Rotation.from_quat(
        q, scalar_first=True
    )
    return difference.magnitude().max()


def test_angles_give_back_the_attitude_they_came_from_and_in_another_order_do_not():
    angles = euler_zyz_from_quaternion(ATTITUDES)
    assert turn_between(attitudes(angles), ATTITUDES) < ROUND_TRIP
    assert turn_between(attitudes(angles[:, [2, 1, 0]]), ATTITUDES) > 1
    # Neither sign of a quaternion nor depth of a shape matters; α may differ by a whole turn.
    negative = euler_zyz_from_quaternion(-ATTITUDES.reshape(10, 100, 4)).reshape(-1, 3)
    assert np.abs(np.sin((angles - negative) / 2)).max() < ROUND_TRIP


def test_an_attitude_gives_back_the_angles_it_came_from():
    again = euler_zyz_from_quaternion(attitudes(ANGLES))
    # α and γ are found to rounding over sin β/2 or cos β/2, here at least sin 0.05.
    assert np.abs(again - ANGLES).max() < ROUND_TRIP / np.sin(0.05)


def test_angles_are_those_of_the_scenario_file():
    degrees = [25.0, 130.0, -70.0]
    from_file = np.array(from_euler_zyz_deg(degrees), dtype=float)
    assert euler_zyz_from_quaternion(from_file) == pytest.approx(
        np.radians(degrees), abs=ROUND_TRIP
    )


@pytest.mark.parametrize("beta", [1e-12, 1e-5, 0.1])
def test_a_small_tilt_keeps_its_digits(beta):
    q = attitudes([0.3, beta, 0.4])
    assert euler_zyz_from_quaternion(q)[1] == pytest.approx(beta, rel=ROUND_TRIP, abs=0)


@pytest.mark.parametrize(("beta", "places"), [(0.0, [0, 3]), (np.pi, [2, 1])], ids=["up", "down"])
def test_at_a_pole_gamma_is_zero_alpha_carries_the_turn_and_there_are_no_rates(beta, places):
    half = 0.35
    q = np.zeros(4)
    q[places] = np.cos(half), np.sin(half) * (1 - 2 * (beta > 0))
    assert euler_zyz_from_quaternion(q) == pytest.approx([2 * half, beta, 0], abs=EPS)
    rates = rates_from_omega_body(np.array([0.3, beta, 0.0]), np.array([1.0, 2.0, 3.0]))
    assert np.isnan(rates).all()


RATES = RANDOM.uniform(-5, 5, (1000, 3))


def test_rates_are_those_of_the_scenario_file():
    degrees = np.degrees(ANGLES)
    pairs = zip(degrees[:100], RATES[:100], strict=True)
    omega = np.array([omega_body_from_zyz_rates(*pair) for pair in pairs], dtype=float)
    error = np.abs(rates_from_omega_body(np.radians(degrees[:100]), omega) - RATES[:100])
    assert (error.max(axis=1) * np.sin(ANGLES[:100, 1])).max() < 5 * ROUND_TRIP


def omega_by_differences(angles, rates, step):
    """ω in body axes from the rotation between two nearby times, centred."""
    before, after = (Rotation.from_euler("ZYZ", angles + s * step * rates) for s in (-0.5, 0.5))
    here = Rotation.from_euler("ZYZ", angles)
    return here.inv().apply((after * before.inv()).as_rotvec()) / step


def test_the_body_turns_by_them_at_its_angular_velocity():
    step = 1e-4
    # A centred difference of ω errs by the third derivative, |rates|³ ≤ 15³, times step²/24;
    # rates are off by that over sin β.
    bound = 15**3 * step**2
    omega = omega_by_differences(ANGLES, RATES, step)
    sin_beta = np.sin(ANGLES[:, 1:2])
    assert (np.abs(rates_from_omega_body(ANGLES, omega) - RATES) * sin_beta).max() < bound
    assert (np.abs(rates_from_omega_body(ANGLES, -omega) - RATES) * sin_beta).max() > 1e3 * bound
