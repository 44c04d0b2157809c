"""Attitudes and tensors in extended precision, against identities."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation
from spincheck.scenarios.exact import (
    DIGITS,
    add,
    conjugate,
    cross,
    dot,
    exact,
    from_euler_zyz_deg,
    from_rotation_vector_deg,
    normalised,
    omega_body_from_zyz_rates,
    product,
    rotate,
    steiner,
)

#: A few roundings of numbers of order one at the working precision.
TINY = mpf(10) ** (2 - DIGITS)
EPS = np.finfo(float).eps
V = exact((0.3, -1.2, 2.5))


@pytest.fixture(autouse=True)
def _working_precision():
    with mp.workdps(DIGITS):
        yield


def apart(a, b):
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


def as_rotation(q):
    return Rotation.from_quat([float(c) for c in q], scalar_first=True)


P, Q = normalised((1, 2, -3, 4)), normalised((5, -1, 2, 0.5))


def test_doubles_are_taken_as_they_are():
    """0.1 is not a tenth."""
    (tenth,) = exact([0.1])
    assert tenth == mpf("0.1000000000000000055511151231257827021181583404541015625")
    assert tenth != mpf(1) / 10


def test_a_product_turns_by_the_second_and_then_by_the_first():
    assert apart(rotate(product(P, Q), V), rotate(P, rotate(Q, V))) < TINY
    assert apart(rotate(product(Q, P), V), rotate(P, rotate(Q, V))) > 1


def test_the_conjugate_turns_back():
    assert apart(rotate(conjugate(P), rotate(P, V)), V) < TINY


def test_turning_keeps_lengths_and_handedness():
    W = exact((1.5, 0.2, -0.7))
    assert abs(dot(rotate(P, V), rotate(P, W)) - dot(V, W)) < 10 * TINY
    assert apart(cross(rotate(P, V), rotate(P, W)), rotate(P, cross(V, W))) < 10 * TINY


def test_normalised_has_norm_one_to_working_precision():
    assert abs(dot(P, P) - 1) < TINY


ANGLES = [(10.0, 30.0, 20.0), (-170.0, 95.0, 400.0), (0.0, 180.0, 0.0), (45.0, 0.0, 45.0)]


@pytest.mark.parametrize("angles", ANGLES, ids=str)
def test_euler_angles_turn_about_z_y_z(angles):
    by_scipy = Rotation.from_euler("ZYZ", angles, degrees=True)
    apart_by = (as_rotation(from_euler_zyz_deg(angles)).inv() * by_scipy).magnitude()
    assert apart_by < 8 * EPS


def test_another_order_of_the_angles_is_another_attitude():
    by_scipy = Rotation.from_euler("ZYZ", ANGLES[0][::-1], degrees=True)
    apart_by = (as_rotation(from_euler_zyz_deg(ANGLES[0])).inv() * by_scipy).magnitude()
    assert apart_by > 1e6 * 8 * EPS


def test_right_angles_are_exact():
    """Body z along world x after β = 90 deg: no 6e-17 left over."""
    assert apart(rotate(from_euler_zyz_deg((0.0, 90.0, 0.0)), exact((0, 0, 1))), (1, 0, 0)) < TINY
    assert from_euler_zyz_deg((0.0, 180.0, 0.0)) == (0, 0, 1, 0)


@pytest.mark.parametrize("vector", [(20.0, -50.0, 35.0), (0.0, 0.0, 270.0), (1e-9, 0.0, 0.0)])
def test_a_rotation_vector_turns_by_its_length_about_itself(vector):
    by_scipy = Rotation.from_rotvec(vector, degrees=True)
    here = as_rotation(from_rotation_vector_deg(vector))
    assert (here.inv() * by_scipy).magnitude() < 8 * EPS
    assert here.magnitude() > 0


def test_a_rotation_vector_of_zero_does_not_turn():
    assert from_rotation_vector_deg((0.0, 0.0, 0.0)) == (1, 0, 0, 0)


def test_rates_are_those_of_the_attitude():
    """2 q* q̇ by a difference so small that its error is below half the digits."""
    angles, rates, step = (25.0, 130.0, -70.0), (1.5, -2.0, 30.0), mpf(10) ** -20

    def at(time):
        return from_euler_zyz_deg(
            [a + mp.degrees(r * time) for a, r in zip(angles, rates, strict=True)]
        )

    difference = tuple((b - a) / (2 * step) for a, b in zip(at(-step), at(step), strict=True))
    omega = [2 * c for c in product(conjugate(at(0)), difference)[1:]]
    bound = 40**3 * step**2  # |rates|³ step²/6, and a margin for the six
    computed = omega_body_from_zyz_rates(angles, rates)
    assert apart(omega, computed) < bound
    assert apart(omega, omega_body_from_zyz_rates(angles, (1.5, 2.0, 30.0))) > 1


def test_steiner_of_a_mass_on_an_axis_is_m_r_squared_across_it():
    assert steiner(mpf(2), exact((0, 0, 3))) == ((18, 0, 0), (0, 18, 0), (0, 0, 0))


def test_steiner_has_the_tensors_sign_off_the_diagonal():
    assert steiner(mpf(1), exact((1, 2, 0)))[0][1] == -2


def test_what_is_added_can_be_taken_away():
    tensor, arm = steiner(mpf(3), V), steiner(mpf(0.1), exact((0.7, 0.1, 0.2)))
    again = add(add(tensor, arm), arm, sign=-1)
    assert max(apart(a, b) for a, b in zip(again, tensor, strict=True)) < 100 * TINY
