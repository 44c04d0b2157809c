"""Rotations of many vectors agree with scipy's, and pass NaN on."""

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.scenarios.rotation import (
    across,
    matrices,
    matrix,
    rotation_vectors,
    times,
    turned,
    turned_back,
)

EPS = float(np.finfo(float).eps)
#: Sums of a few products of numbers up to one.
ROUND_OFF = 16 * EPS

RANDOM = np.random.default_rng(5)
ROTATIONS = Rotation.random(50, random_state=RANDOM)
Q = ROTATIONS.as_quat(scalar_first=True)
V = RANDOM.normal(size=(50, 3))
V /= np.linalg.norm(V, axis=1, keepdims=True)


def misfit(attitude: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(attitude - wanted).max())


def test_matrices_are_scipys() -> None:
    assert misfit(matrices(Q), ROTATIONS.as_matrix()) <= ROUND_OFF
    assert misfit(matrices(np.roll(Q, 1, axis=1)), ROTATIONS.as_matrix()) > 0.1


def test_the_matrix_of_one_is_the_same_to_the_last_bit() -> None:
    assert all(np.array_equal(matrix(q), R) for q, R in zip(Q, matrices(Q), strict=True))


def test_vectors_are_turned_as_scipy_turns_them() -> None:
    assert misfit(turned(matrices(Q), V), ROTATIONS.apply(V)) <= ROUND_OFF
    assert misfit(turned_back(matrices(Q), V), ROTATIONS.apply(V)) > 0.1


def test_turning_back_undoes_turning() -> None:
    assert misfit(turned_back(matrices(Q), turned(matrices(Q), V)), V) <= ROUND_OFF


def test_a_product_with_a_quaternion_is_one_with_a_matrix() -> None:
    other = ROTATIONS[0]
    product = matrices(Q @ times(other.as_quat(scalar_first=True)))
    assert misfit(product, (ROTATIONS * other).as_matrix()) <= ROUND_OFF
    assert misfit(product, (other * ROTATIONS).as_matrix()) > 0.1


def test_a_cross_product_with_a_vector_is_a_product_with_a_matrix() -> None:
    assert misfit(V @ across(V[0]), np.cross(V, V[0])) <= ROUND_OFF
    assert misfit(V @ across(V[0]), np.cross(V[0], V)) > 0.1


def test_what_is_no_number_spoils_its_own_row_only() -> None:
    q = Q.copy()
    q[3] = np.nan
    finite = np.isfinite(turned(matrices(q), V)).all(axis=1)
    assert finite.tolist() == [row != 3 for row in range(len(Q))]


def test_a_turn_from_one_attitude_to_another_is_scipys() -> None:
    scipys = (Rotation.from_quat(Q[:-1], scalar_first=True).inv() * ROTATIONS[1:]).as_rotvec()
    assert misfit(rotation_vectors(Q[:-1], Q[1:]), scipys) <= ROUND_OFF
    assert misfit(rotation_vectors(Q[1:], Q[:-1]), scipys) > 0.1


def test_an_attitude_is_not_turned_by_its_negative() -> None:
    assert not rotation_vectors(Q, -Q).any()
