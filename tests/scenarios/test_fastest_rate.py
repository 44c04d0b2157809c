"""The fastest rate of motions where it is not the spin."""

import numpy as np
import pytest
from library_scenes import library_scene
from mpmath import mpf
from spincheck.reference import solve
from spincheck.scenarios import EFFECTS
from spincheck.scenarios.effects.effect import Extent
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.scenarios.scenario import with_tables
from top_scenes import scene

EPS = float(np.finfo(float).eps)
MASS, LENGTH, ACROSS, GRAVITY = 0.7, 0.3, 0.02, 9.81

PIVOT = "[effects.pivot]\n[effects.gravity]\nacceleration = [0.0, 0.0, -9.81]\n"


def pace_of(spin=0.0, tilt=180.0, axial=0.03, effects=PIVOT, com=(0.0, 0.0, LENGTH)):
    body = f"mass = {MASS}\ninertia = [{ACROSS}, {ACROSS}, {axial}]\ncom = {list(com)}"
    start = f"euler_zyz_deg = [0.0, {tilt}, 0.0]\nomega_body = [0.0, 0.0, {spin}]"
    made = scene(body, start, effects, "duration = 1.0\nsamples = 11")
    return fastest_rate(made, solve(made, made.times).trajectory.omega_body)


SWING = np.sqrt(MASS * GRAVITY * LENGTH / (ACROSS + MASS * LENGTH**2))


def test_a_fast_spin_is_its_own_pace():
    assert pace_of(spin=50.0) == pytest.approx(50.0, rel=8 * EPS)


@pytest.mark.parametrize("axial", [1e-9, 0.03])
def test_what_hangs_at_rest_has_the_pace_of_its_small_swings(axial):
    """However easily it spins about its own axis."""
    assert pace_of(axial=axial) == pytest.approx(SWING, rel=16 * EPS)


def test_a_lever_that_is_no_principal_axis_swings_about_the_axis_that_gives_way_most():
    # About y and z the body gives way alike but for their moments, 0.02 and 0.03.
    rate = pace_of(com=(LENGTH, 0.0, 0.0))
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


def test_a_swing_on_a_table_is_counted_by_the_lever_of_the_tip():
    """The body's origin is at the com: the arm from there is no lever."""
    stick = library_scene("falling-stick")
    body = stick.document.body.model_copy(update={"com": (0.0, 0.0, 0.0)})
    table = stick.effects.table.model_copy(update={"tip": (0.0, 0.0, -0.5)})
    effects = stick.effects.model_copy(update={"table": table})
    moved = with_tables(stick, body=body, effects=effects)
    moments = tuple(map(mpf, sorted(np.linalg.eigvalsh(moved.inertia))))
    extent = Extent(moved, mpf(1), moments, mpf(0))
    ((_, what, rate),) = EFFECTS["gravity"].rates(extent)
    assert what == "a swing under gravity"
    pull = 0.3 * 9.81 * 0.5
    assert float(rate) == pytest.approx(np.sqrt(pull / moments[1]), rel=1e-12)
