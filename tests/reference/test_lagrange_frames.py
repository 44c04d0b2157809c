"""Lagrange's top whichever axis is its own, whichever way gravity pulls."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form_checks import GOAL, apart
from heavy_tops import DOWN, tilted, top
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.lagrange import lagrange
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import FINE_ORDERS, integrate
from spincheck.scenarios.exact import Quaternion, conjugate, exact, normalised, product, rotate
from taylor_problems import problem

DIGITS = 60
TIMES = np.linspace(0.0, 20.0, 41)
TOP = top((0.1, 0.4, 3.0), tilted(0.5))
#: Turns of a cube that take the third axis to each of the six directions, and two others.
CUBE = {
    "+x": (1, 0, 1, 0),
    "-x": (1, 0, -1, 0),
    "+y": (1, -1, 0, 0),
    "-y": (1, 1, 0, 0),
    "+z": (1, 0, 0, 1),
    "-z": (0, 1, 0, 0),
    "-z, turned": (0, 1, 1, 0),
}
TURNS = {**CUBE, "anywhere": (1, -2, 3, 5), "almost −z": (1e-9, 1, 0, 0)}


def quaternion(components: tuple[float, ...]) -> Quaternion:
    return normalised(components)


def with_axes_turned(p: Problem, turn: Quaternion) -> Problem:
    """The same body in axes from which `turn` leads to the old ones; moments stay diagonal."""
    with mp.workdps(DIGITS):

        def to_new(v: tuple[mpf, ...]) -> tuple[mpf, ...]:
            # A turn of a cube moves integers: rounding must not tilt the lever off the axis.
            return tuple(c if abs(c) > mpf(10) ** -50 else mpf(0) for c in rotate(turn, v))

        third = [abs(c) for c in to_new((mpf(0), mpf(0), mpf(1)))]
        odd = third.index(max(third))
        return replace(
            p,
            moments=tuple(p.moments[2 if k == odd else 0] for k in range(3)),
            q_world_axes=product(p.q_world_axes, conjugate(turn)),
            omega_axes=to_new(p.omega_axes),
            lever_axes=to_new(p.lever_axes),
        )


def with_world_turned(p: Problem, turn: Quaternion) -> Problem:
    with mp.workdps(DIGITS):
        return replace(
            p,
            q_world_axes=product(turn, p.q_world_axes),
            gravity_world=rotate(turn, p.gravity_world),
        )


SPHERE = problem(
    (2.0, 2.0, 2.0), (2.0, 0.3, 0.1), (1, 0.2, 0.3, 0.4), gravity_world=(0.0, -1.0, 3.0)
)
LEVERS = [(0.3, 0.6, -0.2), (0.0, -1.0, 0.0), (1e-9, 0.0, -1.0)]
FRAMES = {
    **{f"axis {name}": with_axes_turned(TOP, quaternion(turn)) for name, turn in CUBE.items()},
    **{f"gravity {name}": with_world_turned(TOP, quaternion(turn)) for name, turn in TURNS.items()},
    **{f"lever {lever}": replace(SPHERE, lever_axes=exact(lever)) for lever in LEVERS},
}


@pytest.mark.parametrize("p", FRAMES.values(), ids=FRAMES)
def test_axis_gravity_and_a_spheres_lever_may_point_anywhere(p):
    assert apart(closed_form(p).states(TIMES), integrate(p, TIMES)) < GOAL


def test_a_negative_lever_is_not_a_positive_one():
    reversed_lever = replace(TOP, lever_axes=tuple(-c for c in TOP.lever_axes))
    assert apart(lagrange(reversed_lever).states(TIMES), integrate(TOP, TIMES)) > GOAL


@pytest.mark.parametrize("turn", TURNS.values(), ids=TURNS)
def test_asleep_or_on_the_separatrix_it_ends_upright_in_any_world(turn):
    """The world's turn is exact to sixty digits only: what is off by 1e-60 must not fall."""
    asleep, rising = (
        with_world_turned(top(omega, q), quaternion(turn))
        for omega, q in (((0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)), ((0.0, 2.0, 0.0), DOWN))
    )
    _, omega = lagrange(asleep).states(np.array([1e3, 1e6]))
    assert (omega == [0.0, 0.0, 1.0]).all()
    assert lagrange(rising).period == np.inf


def test_the_sign_of_a_quaternion_is_kept():
    minus = replace(TOP, q_world_axes=tuple(-c for c in TOP.q_world_axes))
    q, omega = lagrange(TOP).states(TIMES)
    assert apart(lagrange(minus).states(TIMES), (-q, omega)) < GOAL


small = st.builds(lambda k, sign: sign * 10.0**k, st.floats(-9.0, -1.0), st.sampled_from((-1, 1)))
component = st.one_of(st.integers(-30, 30).map(lambda n: n / 10), st.floats(0.5, 3.0), small)


@settings(max_examples=60, deadline=None)
@given(
    I3=st.one_of(st.floats(1e-3, 2.0), small.map(lambda e: 1 + e / 2)),
    omega=st.tuples(component, component, component),
    q=st.tuples(*[component] * 4).filter(lambda q: max(map(abs, q)) > 0.0),
    kappa=st.one_of(st.floats(0.01, 10.0), small.map(abs)),
)
def test_any_motion_is_that_of_the_ode(I3, omega, q, kappa):
    """Over twenty radians, in which the ODE's own error of 1e-27 cannot grow to a double's."""
    p = top(omega, q, I3, kappa)
    times = np.linspace(0.0, 20.0 / (np.abs(omega).max() + np.sqrt(kappa)), 21)
    assert apart(closed_form(p).states(times), integrate(p, times, FINE_ORDERS)) < GOAL
