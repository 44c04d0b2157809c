"""The fastest rate of motions where it is not the spin."""

import numpy as np
import pytest
from spincheck.reference import solve
from spincheck.scenarios import loads
from spincheck.scenarios.fastest_rate import fastest_rate

EPS = float(np.finfo(float).eps)
MASS, LENGTH, ACROSS, GRAVITY = 0.7, 0.3, 0.02, 9.81

SCENE = """
spincheck = 1
title = "A body"
source = "made up"
[body]
mass = 0.7
inertia = [0.02, 0.02, {axial}]
com = [0.0, 0.0, 0.3]
[start]
euler_zyz_deg = [0.0, {tilt}, 0.0]
omega_body = [0.0, 0.0, {spin}]
{effects}
[window]
duration = 1.0
samples = 11
"""
PIVOT = "[effects.pivot]\n[effects.gravity]\nacceleration = [0.0, 0.0, -9.81]\n"


def pace_of(spin: float = 0.0, tilt: float = 180.0, axial: float = 0.03, effects: str = PIVOT):
    text = SCENE.format(spin=spin, tilt=tilt, axial=axial, effects=effects)
    scene = loads(text, "body")
    return fastest_rate(scene, solve(scene, scene.times).trajectory.omega_body)


SWING = np.sqrt(MASS * GRAVITY * LENGTH / (ACROSS + MASS * LENGTH**2))


def test_a_fast_spin_is_its_own_pace():
    assert pace_of(spin=50.0) == pytest.approx(50.0, rel=8 * EPS)


@pytest.mark.parametrize("axial", [1e-9, 0.03])
def test_what_hangs_at_rest_has_the_pace_of_its_small_swings(axial):
    """However easily it spins about its own axis."""
    assert pace_of(axial=axial) == pytest.approx(SWING, rel=16 * EPS)


def test_a_lever_that_is_no_principal_axis_swings_about_the_axis_that_gives_way_most():
    text = SCENE.format(spin=0.0, tilt=180.0, axial=0.03, effects=PIVOT)
    skew = loads(text.replace("com = [0.0, 0.0, 0.3]", "com = [0.3, 0.0, 0.0]"), "body")
    # About y and z the body gives way alike but for their moments, 0.02 and 0.03.
    rate = fastest_rate(skew, solve(skew, skew.times).trajectory.omega_body)
    assert rate == pytest.approx(SWING, rel=0.5)
    assert rate >= SWING * (1 - 16 * EPS)


def test_without_a_pivot_gravity_turns_nothing():
    gravity = "[effects.gravity]\nacceleration = [0.0, 0.0, -9.81]\n"
    assert pace_of(effects=gravity) == 0.0


def test_a_drag_faster_than_the_spin_sets_the_pace():
    drag = "[effects.drag]\nrotational = 2.0\n"
    assert pace_of(spin=1.0, effects=drag) == pytest.approx(2.0 / ACROSS, rel=8 * EPS)


def test_a_body_pushed_from_rest_has_the_pace_that_it_comes_to():
    push = "[effects.torque]\nbody = [0.0, 0.0, 0.3]\n"
    assert pace_of(effects=push) == pytest.approx(0.3 / 0.03 * 1.0, rel=64 * EPS)
