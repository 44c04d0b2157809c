"""Bodies: valid if they exist, exact in their numbers, the same about any point."""

import itertools

import numpy as np
import pytest
from mpmath import mpf
from spincheck.scenarios.body import (
    TRIANGLE_SLACK,
    body_about_com,
    body_about_origin,
    body_of_particles,
)

EPS = np.finfo(float).eps
COM = (0.1, -0.2, 0.3)
TENSOR = ((1.4, 0.2, -0.1), (0.2, 1.1, 0.3), (-0.1, 0.3, 0.9))


def diagonal(*moments):
    return tuple(tuple(m if i == j else 0.0 for j in range(3)) for i, m in enumerate(moments))


def test_the_tensor_about_the_origin_is_that_of_the_parallel_axis_theorem():
    body = body_about_com(2.0, COM, TENSOR)
    r = np.array(COM)
    by_hand = np.array(TENSOR) + 2.0 * (r @ r * np.eye(3) - np.outer(r, r))
    assert np.abs(body.inertia_origin - by_hand).max() < 2 * EPS
    away = np.array(TENSOR) - 2.0 * (r @ r * np.eye(3) - np.outer(r, r))
    assert np.abs(body.inertia_origin - away).max() > 0.1


def test_a_tensor_about_the_origin_is_kept_to_the_last_digit():
    about_com = body_about_com(2.0, COM, TENSOR)
    again = body_about_origin(2.0, COM, about_com.inertia_origin.tolist())
    assert np.array_equal(again.inertia_origin, about_com.inertia_origin)
    assert np.abs(again.inertia_com - np.array(TENSOR)).max() < 2 * EPS


def test_equal_moments_stay_equal_after_a_shift_along_the_axis():
    tensor = body_about_com(0.3, (0.0, 0.0, 0.7), diagonal(0.1, 0.1, 0.05)).inertia_origin_exact
    assert tensor[0][0] == tensor[1][1]


def test_numbers_are_the_doubles_of_the_file_exactly():
    body = body_about_com(0.1, COM, TENSOR)
    assert body.mass_exact == mpf(0.1)
    assert body.com_exact == tuple(mpf(c) for c in COM)
    assert body.inertia_com_exact[0][1] == mpf(0.2)


CUBE_CORNERS = [(1.0, *corner) for corner in itertools.product((-0.5, 0.5), repeat=3)]


def test_eight_masses_at_the_corners_of_a_cube():
    """Each is √½ from every axis: 8 · 1 · ½."""
    body = body_of_particles(CUBE_CORNERS)
    assert body.mass == 8
    assert np.array_equal(body.com, [0, 0, 0])
    assert np.array_equal(body.inertia_com, 4 * np.eye(3))


def test_masses_moved_together_have_the_same_tensor_about_their_com():
    moved = [(m, x + 3.0, y - 1.0, z + 0.25) for m, x, y, z in CUBE_CORNERS]
    body = body_of_particles(moved)
    assert np.array_equal(body.com, [3.0, -1.0, 0.25])
    assert np.array_equal(body.inertia_com, 4 * np.eye(3))


def test_six_masses_on_the_axes():
    """Pairs at ±1, ±2, ±3 on x, y, z: I_xx = 2 (4 + 9) and so on."""
    arms = [(1.0, 0, 0), (0, 2.0, 0), (0, 0, 3.0)]
    pairs = [(1.0, s * x, s * y, s * z) for x, y, z in arms for s in (1, -1)]
    assert np.array_equal(body_of_particles(pairs).inertia_com, np.diag([26.0, 20.0, 10.0]))


def test_products_of_inertia_have_the_sign_of_the_tensor():
    """I_xy = −Σ m x y: two masses on the diagonal x = y, one on the axis to give it width."""
    body = body_of_particles([(1.0, 1, 1, 0), (1.0, -1, -1, 0), (1.0, 0, 0, 1), (1.0, 0, 0, -1)])
    assert np.array_equal(body.inertia_com, [[4, -2, 0], [-2, 4, 0], [0, 0, 4]])


def test_a_fine_grid_of_masses_is_a_solid_box():
    """n³ equal masses in a box: M (b² + c²)/12 less the cells' own, a part 1/n² of it."""
    n, sides = 6, (1.0, 2.0, 3.0)
    ticks = [side * ((np.arange(n) + 0.5) / n - 0.5) for side in sides]
    grid = [(1 / n**3, *point) for point in itertools.product(*ticks)]
    solid = np.array([13.0, 10.0, 5.0]) / 12
    moments = np.diag(body_of_particles(grid).inertia_com)
    assert moments == pytest.approx(solid * (1 - 1 / n**2), rel=4 * EPS)
    assert moments != pytest.approx(solid, rel=1e-3)


def test_principal_moments_are_ascending():
    assert list(body_about_com(1.0, COM, diagonal(3.0, 1.0, 2.5)).principal_moments) == [1, 2.5, 3]


def test_principal_moments_of_a_full_tensor_are_its_eigenvalues():
    """[[3, 1], [1, 3]] has 2 and 4."""
    tensor = ((3.0, 1.0, 0.0), (1.0, 3.0, 0.0), (0.0, 0.0, 3.5))
    assert list(body_about_com(1.0, COM, tensor).principal_moments) == [2.0, 3.5, 4.0]


@pytest.mark.parametrize("moments", [(0.0, 1.0, 1.0), (-1.0, 1.0, 1.0)], ids=["zero", "negative"])
def test_moments_are_positive(moments):
    with pytest.raises(ValueError, match="principal moments about the com must be positive"):
        body_about_com(1.0, COM, diagonal(*moments))


def test_a_tensor_about_the_origin_may_be_too_small_for_the_arm():
    with pytest.raises(ValueError, match="principal moments about the com must be positive"):
        body_about_origin(1.0, (0.0, 0.0, 2.0), diagonal(1.0, 1.0, 1.0))


@pytest.mark.parametrize("mass", [0.0, -1.0])
def test_the_mass_is_positive(mass):
    with pytest.raises(ValueError, match="positive"):
        body_about_com(mass, COM, TENSOR)


@pytest.mark.parametrize("moments", [(1.0, 2.0, 3.1), (3.1, 1.0, 2.0)])
def test_no_moment_exceeds_the_sum_of_the_others(moments):
    with pytest.raises(ValueError, match=r"sum of the other two, got 1, 2, 3\.1 kg m²"):
        body_about_com(1.0, COM, diagonal(*moments))


def test_a_flat_plate_typed_in_decimals_is_a_body():
    """0.1 + 0.2 is not 0.3 in doubles, and a plate's moments are such a sum."""
    assert 0.1 + 0.7 < 0.8
    body_about_com(1.0, COM, diagonal(0.1, 0.7, 0.8))
    with pytest.raises(ValueError, match="sum of the other two"):
        body_about_com(1.0, COM, diagonal(0.1, 0.7, 0.8 * (1 + 2 * TRIANGLE_SLACK)))


def test_the_largest_doubles_do_not_overflow():
    body_about_com(1.0, (0.0, 0.0, 0.0), diagonal(1e308, 1e308, 1e308))


def test_what_overflows_is_refused():
    with pytest.raises(ValueError, match="the tensor overflows"):
        body_about_com(1e300, (1e10, 0.0, 0.0), TENSOR)


@pytest.mark.parametrize("name", ["com", "inertia_com", "inertia_origin", "principal_moments"])
def test_arrays_are_read_only(name):
    with pytest.raises(ValueError, match="read-only"):
        getattr(body_about_com(1.0, COM, TENSOR), name)[0] = 5.0
