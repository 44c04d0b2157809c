"""Statements in the scenes' descriptions, checked by simple formulas."""

import numpy as np
import pytest
from library_scenes import library_scene as scene
from spincheck.scenarios import (
    FloatArray,
    Scenario,
    Trajectory,
    angular_momentum_world,
    energy,
)

EPS = np.finfo(float).eps
#: A planted fault in a rate: far below what anybody would see, far above rounding.
NUDGE = 1e-9


def equal(a: float, b: float) -> bool:
    """Equal but for the rounding of a few products; a nudge is noticed."""
    nudged_too = bool(np.isclose(a * (1 + NUDGE), b, rtol=8 * EPS, atol=0))
    return bool(np.isclose(a, b, rtol=8 * EPS, atol=0)) and not nudged_too


def at_start(scenario: Scenario) -> Trajectory:
    """The state at t = 0 as a motion of one sample."""
    q, omega = scenario.start.q_world_body_wxyz, scenario.start.omega_body
    position, velocity = scenario.start.position_world, scenario.start.velocity_world
    still = Trajectory(np.zeros(1), q[None], omega[None], position[None], velocity[None])
    if not scenario.constraint.is_pivot:
        return still
    R = still.R_world_body.as_matrix()[0]
    com, velocity = R @ scenario.body.com, R @ np.cross(omega, scenario.body.com)
    return Trajectory(still.t, q[None], omega[None], com[None], velocity[None])


def test_kovalevskaya_ratio_is_exact_about_the_pivot() -> None:
    body = scene("kovalevskaya").body
    inertia = body.inertia_origin_exact
    assert inertia[0][0] == inertia[1][1] == 2 * inertia[2][2]
    assert body.com[2] == 0
    assert body.inertia_com[0, 0] != body.inertia_com[1, 1]


def test_goryachev_chaplygin_ratio_is_exact_about_the_pivot() -> None:
    body = scene("goryachev-chaplygin").body
    inertia = body.inertia_origin_exact
    assert inertia[0][0] == inertia[1][1] == 4 * inertia[2][2]
    assert body.com[2] == 0


def test_goryachev_chaplygin_starts_without_vertical_angular_momentum() -> None:
    scenario = scene("goryachev-chaplygin")
    L = angular_momentum_world(scenario, at_start(scenario))[0]
    assert abs(L[2]) <= 8 * EPS * np.linalg.norm(L)
    tilted = at_start(scenario)
    nudged = tilted.omega_body + np.array([[0.0, NUDGE, 0.0]])
    shifted = Trajectory(
        tilted.t, tilted.q_world_body_wxyz, nudged, tilted.com_world, tilted.velocity_world
    )
    assert abs(angular_momentum_world(scenario, shifted)[0, 2]) > 8 * EPS * np.linalg.norm(L)


def R_world_body(scenario: Scenario) -> FloatArray:
    return np.asarray(at_start(scenario).R_world_body.as_matrix()[0])


def inertia_world(scenario: Scenario) -> FloatArray:
    R = R_world_body(scenario)
    return R @ scenario.body.inertia_com @ R.T


def test_the_book_in_skew_axes_is_the_book_of_the_middle_axis() -> None:
    skew, straight = scene("book-in-skew-axes"), scene("book-middle-axis")
    size = 8 * EPS * np.abs(straight.body.inertia_com).max()
    assert np.abs(inertia_world(skew) - inertia_world(straight)).max() <= size
    assert np.abs(skew.body.inertia_com - straight.body.inertia_com).max() > size
    omegas = [R_world_body(book) @ book.start.omega_body for book in (skew, straight)]
    assert np.abs(omegas[0] - omegas[1]).max() <= 8 * EPS * np.abs(omegas[1]).max()


def test_detest_body_obeys_the_equations_of_problem_b5() -> None:
    i1, i2, i3 = scene("detest-b5").body.inertia_com.diagonal()
    a1, a2, a3 = 1.8, 0.75, 2.5
    rates = [
        (i2 - i3) / i1 * a2 * a3 / a1,
        (i3 - i1) / i2 * a3 * a1 / a2,
        (i1 - i2) / i3 * a1 * a2 / a3,
    ]
    assert all(map(equal, rates, (1.0, -1.0, -0.51)))


@pytest.mark.parametrize(
    ("name", "ratio"), [("feynman-plate", (1, 2)), ("football-spiral", (5, 3))]
)
def test_moments_across_and_along_stand_in_the_ratio_stated(
    name: str, ratio: tuple[int, int]
) -> None:
    across, _, along = scene(name).body.inertia_com.diagonal()
    assert equal(across / along, ratio[0] / ratio[1])


def test_the_motor_makes_up_for_the_drag() -> None:
    scenario = scene("motor-driven-top")
    braking = scenario.pushed["drag"] * scenario.start.omega_body[2]
    assert equal(scenario.pushed["torque_body"][2], braking)


def test_the_cube_is_a_symmetric_top_about_its_diagonal() -> None:
    inertia = scene("cube-on-a-corner").body.inertia_origin_exact
    diagonal, product = inertia[0][0], inertia[0][1]
    assert all(inertia[i][i] == diagonal for i in range(3))
    assert inertia[0][1] == inertia[1][2] == inertia[0][2] == product
    assert equal(float((diagonal - product) / (diagonal + 2 * product)), 11 / 2)


def test_the_top_with_y_up_is_the_fast_top() -> None:
    y_up, z_up = scene("y-is-up"), scene("fast-top")
    assert y_up.document.body == z_up.document.body
    invariants = []
    for top in (y_up, z_up):
        motion, up = at_start(top), -top.gravity_world / np.linalg.norm(top.gravity_world)
        L = angular_momentum_world(top, motion)[0]
        invariants.append((L @ up, np.linalg.norm(L), energy(top, motion)[0]))
    assert all(map(equal, *invariants))
