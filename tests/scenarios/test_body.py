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
RANDOM = np.random.default_rng(3)
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


def test_masses_have_the_tensor_of_its_definition_wherever_they_are():
    """Σ m (r² 1 − r rᵀ), r from their com; and of a cube's eight corners exactly."""
    masses, places = RANDOM.uniform(0.1, 2, 7), RANDOM.uniform(-3, 3, (7, 3))
    body = body_of_particles([(m, *r) for m, r in zip(masses, places, strict=True)])
    com = masses @ places / masses.sum()
    r = places - com
    by_hand = np.einsum("n,ni,nj->ij", masses, r, r)
    by_hand = np.trace(by_hand) * np.eye(3) - by_hand
    assert body.mass == pytest.approx(masses.sum(), rel=8 * EPS)
    assert np.array(body.com) == pytest.approx(com, abs=16 * EPS)
    assert np.abs(body.inertia_com - by_hand).max() < 64 * EPS * np.abs(by_hand).max()
    ends = itertools.product((2.5, 3.5), (-1.5, -0.5), (-0.25, 0.75))
    cube = body_of_particles([(1.0, *corner) for corner in ends])
    assert np.array_equal(cube.inertia_com, 4 * np.eye(3))
    assert (cube.mass, *cube.com) == (8, 3.0, -1.0, 0.25)


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
