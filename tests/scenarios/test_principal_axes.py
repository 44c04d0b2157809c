"""Principal axes: a right-handed frame in which the tensor is diagonal."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation
from spincheck.scenarios.exact import DIGITS
from spincheck.scenarios.principal import IDENTITY, from_matrix, principal_axes

TINY = mpf(10) ** (3 - DIGITS)


def tensor(rows):
    return tuple(tuple(mpf(entry) for entry in row) for row in rows)


FULL = tensor([[1.4, 0.2, -0.1], [0.2, 1.1, 0.3], [-0.1, 0.3, 0.9]])


def test_a_diagonal_tensor_keeps_its_axes_and_its_order():
    moments, axes = principal_axes(tensor([[3.0, 0, 0], [0, 1.0, 0], [0, 0, 2.5]]))
    assert moments == (3, 1, 2.5)
    assert axes == IDENTITY


def test_the_axes_make_the_tensor_diagonal():
    moments, axes = principal_axes(FULL)
    with mp.workdps(DIGITS):
        R, inertia = mp.matrix(axes), mp.matrix(FULL)
        rest = R.T * inertia * R - mp.diag(moments)
        assert mp.mnorm(rest) < TINY
        assert mp.mnorm(R * inertia * R.T - mp.diag(moments)) > 0.1


def test_the_axes_are_right_handed_and_orthonormal():
    _, axes = principal_axes(FULL)
    with mp.workdps(DIGITS):
        R = mp.matrix(axes)
        assert mp.mnorm(R.T * R - mp.eye(3)) < TINY
        assert abs(mp.det(R) - 1) < TINY


#: Nine times a rotation of diag(1, 1, 2): the moments are 9, 9 and 18.
SYMMETRIC = tensor([[10, 2, 2], [2, 13, 4], [2, 4, 13]])


def test_equal_moments_of_a_full_tensor_are_exactly_equal():
    moments, _ = principal_axes(SYMMETRIC)
    assert moments[0] == moments[1]
    assert abs(moments[0] - 9) < TINY
    assert abs(moments[2] - 18) < TINY


def test_moments_an_ulp_apart_stay_apart():
    ulp = float(np.spacing(10.0))
    almost = tensor([[10.0 + ulp, 2, 2], [2, 13, 4], [2, 4, 13]])
    moments, _ = principal_axes(almost)
    assert ulp / 10 < moments[1] - moments[0] < 2 * ulp


@pytest.mark.parametrize(
    "vector", [(0, 0, 0), (170, 0, 0), (0, 180, 0), (0, 0, -179), (60, 70, 80)], ids=str
)
def test_a_matrix_gives_the_quaternion_of_its_rotation(vector):
    here = Rotation.from_rotvec(vector, degrees=True)
    q = [float(c) for c in from_matrix(tensor(here.as_matrix()))]
    again = Rotation.from_quat(q, scalar_first=True)
    assert (again.inv() * here).magnitude() < 16 * np.finfo(float).eps
