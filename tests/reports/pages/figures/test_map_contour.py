"""Lines where a function on a grid is zero."""

import numpy as np
import pytest
from spincheck.reports.pages.figures.map_contour import zero_lines

EPS = float(np.finfo(float).eps)
X, Y = np.linspace(-2.0, 2.0, 9), np.linspace(-1.0, 1.0, 6)


def test_a_plane_s_line_is_straight_and_exact():
    """2x − 3y + 0.1 is linear, and so is the interpolation."""
    (curve,) = zero_lines(X, Y, 2 * X - 3 * Y[:, None] + 0.1)
    distance = 2 * curve[:, 0] - 3 * curve[:, 1] + 0.1
    assert np.abs(distance).max() < 16 * EPS * 8  # of terms up to 8
    assert np.abs(2 * curve[:, 0] + 3 * curve[:, 1]).max() > 1


def test_a_line_runs_from_edge_to_edge_without_a_jump():
    (curve,) = zero_lines(X, Y, X - 0.1 + 0 * Y[:, None])
    assert {curve[0, 1], curve[-1, 1]} == {-1.0, 1.0}
    cell = np.hypot(X[1] - X[0], Y[1] - Y[0])
    assert np.hypot(*np.diff(curve, axis=0).T).max() <= cell


def test_a_circle_is_closed_and_within_a_cell_s_curvature():
    x = np.linspace(-1.5, 1.5, 61)
    (curve,) = zero_lines(x, x, x**2 + x[:, None] ** 2 - 1)
    np.testing.assert_array_equal(curve[0], curve[-1])
    # Linear interpolation of r² − 1 over h is off by h²/8 times its second derivative, 2; half
    # of it in r.
    step = x[1] - x[0]
    assert np.abs(np.hypot(*curve.T) - 1).max() < step**2 / 8


def test_two_curves_are_two():
    assert len(zero_lines(X, Y, (X - 1.1) * (X + 1.1) + 0 * Y[:, None])) == 2


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_saddle_is_cut_twice_and_the_cuts_do_not_cross(sign):
    """(x − 0.1)(y − 0.1) on one cell: the middle has the sign of −−, so these corners hang on."""
    corners = np.array([-1.0, 1.0])
    lines = zero_lines(corners, corners, sign * ((corners - 0.1) * (corners[:, None] - 0.1)))
    assert len(lines) == 2
    for curve in lines:
        # Each cuts off a corner where one coordinate is positive and the other negative.
        assert np.sign(curve.mean(axis=0)).prod() == -1


def test_where_nothing_is_known_there_is_no_line():
    values = 2 * X - 3 * Y[:, None]
    values[2] = np.nan
    for curve in zero_lines(X, Y, values):
        assert not ((Y[1] < curve[:, 1]) & (curve[:, 1] < Y[3])).any()


def test_one_sign_throughout_has_no_line():
    assert zero_lines(X, Y, 1 + 0 * X + 0 * Y[:, None]) == []
