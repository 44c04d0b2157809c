"""The solid ellipsoid of a tensor: by hand, turned, and where there is none."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.engines import BodyReading
from spincheck.reports.pages.analysis.trace_style import TraceStyle
from spincheck.reports.users_models.ellipsoid import (
    MARGIN,
    SIZE,
    Solid,
    solid_squares,
    views,
)

EPS = float(np.finfo(float).eps)
AXES = np.array([0.3, 0.2, 0.1])
TURN = Rotation.from_euler("zyx", [40, 30, 20], degrees=True).as_matrix()


def tensor(axes, mass=2.0):
    """Of a uniform ellipsoid: m (b² + c²) / 5 and so on (Goldstein, §5.3)."""
    a, b, c = np.square(axes)
    return mass / 5 * np.diag([b + c, a + c, a + b])


def drawn(inertia, com=(0.0, 0.0, 0.0), mass=2.0):
    return Solid("x", TraceStyle("black", "solid", ""), BodyReading(mass, np.array(com), inertia))


@pytest.mark.parametrize("R", [np.eye(3), TURN], ids=["along the axes", "turned"])
def test_an_ellipsoids_own_semi_axes_come_back(R):
    squares = solid_squares(2.0, R @ tensor(AXES) @ R.T)
    assert np.abs(squares - R @ np.diag(AXES**2) @ R.T).max() <= 8 * EPS * AXES.max() ** 2


def test_what_no_body_has_is_none_and_a_flat_body_has_one_without_thickness():
    assert solid_squares(2.0, np.diag([0.1, 0.3, 0.9])) is None
    assert solid_squares(2.0, np.zeros((3, 3))) is None
    assert solid_squares(0.0, np.eye(3)) is None
    squares = solid_squares(1.0, np.diag([1.0, 2.0, 3.0]))
    assert np.linalg.eigvalsh(squares)[0] == pytest.approx(0.0, abs=16 * EPS * 10)


def test_each_view_shows_the_two_axes_that_it_names_and_a_bar_as_long_as_it_says():
    for view in views([drawn(tensor(AXES))]):
        (ellipse,) = view["ellipses"]
        right, up = (AXES["xyz".index(name)] for name in (view["right"], view["up"]))
        across = ellipse["rx"] if round(ellipse["turn"]) % 180 == 0 else ellipse["ry"]
        other = ellipse["ry"] if across == ellipse["rx"] else ellipse["rx"]
        assert across / other == pytest.approx(right / up)
    first, *_ = views([drawn(tensor(AXES))])
    # 0.6 m wide.
    assert first["bar_text"] == "0.2 m"
    assert first["bar"] == pytest.approx((SIZE - 2 * MARGIN) * 0.2 / 0.6)


def test_a_turn_about_the_axis_looked_along_is_the_ellipses_turn():
    R = Rotation.from_euler("z", 25, degrees=True).as_matrix()
    above = views([drawn(R @ tensor(AXES) @ R.T)])[0]
    # Pictures count downwards: what turns to the left has a negative angle.
    assert above["ellipses"][0]["turn"] % 180 == pytest.approx(-25 % 180)


def test_solids_and_the_frames_origin_fit_every_view():
    solids = [drawn(TURN @ tensor(AXES) @ TURN.T, (1.0, -2.0, 0.5)), drawn(tensor(AXES / 50))]
    for view in views(solids):
        points = [view["origin"], *((e["x"], e["y"]) for e in view["ellipses"])]
        assert np.min(points) >= MARGIN - 1
        assert np.max(points) <= SIZE - MARGIN + 1
