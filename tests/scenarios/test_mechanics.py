"""L and energy of motions that can be worked out by hand."""

import numpy as np
import pytest
from scene_texts import scene
from spincheck.scenarios import (
    Trajectory,
    angular_momentum_world,
    energy,
    energy_base,
    kinetic_energy,
    potential_energy,
)

EPS = np.finfo(float).eps
#: A handful of products and sums of numbers below a hundred.
ROUNDED = 100 * 8 * EPS
PIVOT = "[effects.pivot]\n"
GRAVITY = "[effects.gravity]\nacceleration = [0.0, 0.0, -10.0]\n"
SIDEWAYS = "[effects.gravity]\nacceleration = [3.0, 0.0, 0.0]\n"
#: Takes body x to world y, y to −x: a quarter turn about z.
QUARTER = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]


def moment(q=(1, 0, 0, 0), omega=(0, 0, 0), com=(0, 0, 0), velocity=(0, 0, 0)):
    """A trajectory of one sample."""
    return Trajectory([0.0], [q], [omega], [com], [velocity])


def test_about_the_com_each_axis_has_its_moment():
    """Moments 1, 2, 2.5 about the com."""
    L = angular_momentum_world(scene(), moment(omega=(1, 2, 4)))
    assert L[0] == pytest.approx([1, 4, 10], abs=ROUNDED)


def test_a_turned_body_has_its_angular_momentum_turned():
    L = angular_momentum_world(scene(), moment(QUARTER, omega=(1, 2, 4)))
    assert L[0] == pytest.approx([-4, 1, 10], abs=ROUNDED)
    assert L[0] != pytest.approx([1, 4, 10], abs=0.1)


def test_about_the_com_flight_does_not_count():
    flying = moment(omega=(1, 2, 4), com=(5, 6, 7), velocity=(1, -1, 3))
    assert angular_momentum_world(scene(), flying)[0] == pytest.approx([1, 4, 10], abs=ROUNDED)


def test_about_a_pivot_the_com_goes_round_with_its_mass():
    """r × m v with r = (1, 0, 0), v = (0, 3, 0), m = 2 beside I ω = (0, 0, 2.5 · 3)."""
    round_the_pivot = moment(omega=(0, 0, 3), com=(1, 0, 0), velocity=(0, 3, 0))
    L = angular_momentum_world(scene(more=PIVOT), round_the_pivot)
    assert L[0] == pytest.approx([0, 0, 7.5 + 6], abs=ROUNDED)


def test_about_a_pivot_it_is_the_tensor_about_the_pivot():
    scenario = scene(more=PIVOT)
    omega, com = np.array([1.0, 2.0, 4.0]), scenario.body.com
    L = angular_momentum_world(
        scenario, moment(omega=omega, com=com, velocity=np.cross(omega, com))
    )
    assert L[0] == pytest.approx(scenario.body.inertia_origin @ omega, abs=ROUNDED)
    assert L[0] != pytest.approx(scenario.body.inertia_com @ omega, abs=0.1)


def test_kinetic_energy_is_of_turning_and_of_flight():
    """½ (1 + 2·4 + 2.5·16) + ½ 2 (9 + 16)."""
    moving = moment(QUARTER, omega=(1, 2, 4), velocity=(3, 0, 4))
    assert kinetic_energy(scene(), moving)[0] == pytest.approx(24.5 + 25, abs=ROUNDED)


@pytest.mark.parametrize(
    ("gravity", "by_hand"), [(GRAVITY, 2 * 10 * 7), (SIDEWAYS, -2 * 3 * 5), ("", 0)]
)
def test_potential_energy_rises_against_gravity(gravity, by_hand):
    state = moment(com=(5, 6, 7))
    assert potential_energy(scene(more=gravity), state)[0] == pytest.approx(by_hand, abs=ROUNDED)


def test_energy_is_their_sum():
    scenario, state = (
        scene(more=GRAVITY),
        moment(omega=(1, 2, 4), com=(5, 6, 7), velocity=(3, 0, 4)),
    )
    assert energy(scenario, state)[0] == pytest.approx(49.5 + 140, abs=ROUNDED)


def test_energy_is_conserved_in_free_fall():
    """z = 2 t − 5 t²."""
    t = np.linspace(0, 2, 50)
    zero = np.zeros_like(t)
    com = np.column_stack([3 * t, zero, 2 * t - 5 * t**2])
    velocity = np.column_stack([3 + zero, zero, 2 - 10 * t])
    q, omega = np.tile([1.0, 0, 0, 0], (50, 1)), np.zeros((50, 3))
    scenario = scene(more=GRAVITY)
    assert np.ptp(energy(scenario, Trajectory(t, q, omega, com, velocity))) < 10 * ROUNDED
    assert np.ptp(energy(scenario, Trajectory(t, q, omega, com, 1.01 * velocity))) > 0.1


def test_the_base_is_of_the_fastest_and_the_farthest():
    """Two samples: T = 2.5·16/2 and at rest; |r| = 0 and 5, weight 20."""
    q, still = [1, 0, 0, 0], [0, 0, 0]
    path = Trajectory([0, 1], [q, q], [[0, 0, 4], still], [still, [3, 0, 4]], [still, still])
    assert energy_base(scene(more=GRAVITY), path) == pytest.approx(20 + 100, abs=ROUNDED)


def test_every_sample_has_its_own():
    q, still = [1, 0, 0, 0], [0, 0, 0]
    path = Trajectory([0, 1], [q, q], [[0, 0, 4], [2, 0, 0]], [still, still], [still, still])
    assert kinetic_energy(scene(), path) == pytest.approx([20, 2], abs=ROUNDED)
    assert angular_momentum_world(scene(), path) == pytest.approx(
        np.array([[0, 0, 10], [2, 0, 0]]), abs=ROUNDED
    )
