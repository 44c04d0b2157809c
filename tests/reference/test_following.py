"""Motions by equations that are a scene's are the scene's, and integrators have their orders."""

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library_scene
from spincheck.reference import solve
from spincheck.reference.following import (
    APPROXIMATE,
    ERROR,
    EXACT,
    KNOWN,
    TURN,
    Integrator,
    follow,
    rates,
)
from spincheck.reference.other_equations import equations_of
from spincheck.scenarios.rotation import norms

#: Every term of the equations: none, gravity and a pivot, drag, torques, rotors, a table.
SCENES = [
    "tennis-racket",
    "fast-top",
    "book-with-drag",
    "pushed-aslant",
    "satellite-and-its-wheel",
    "gliding-top",
]
ORDERS = {"the midpoint rule": 2, "RK4": 4}
EPS = float(np.finfo(float).eps)
#: Radians that are followed at the first rate, and ulps of the state that a step may be off by: a
#: sum of twelve stages, each of a dozen products.
TURNS, ULPS = 3.0, 12


def states(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times, s, and exact states q and ω along body axes, (n, 7), over some radians."""
    scene = library_scene(name)
    equations = equations_of(scene)
    rate = max(equations.rate, float(np.linalg.norm(scene.start.omega_body)))
    motion = solve(scene, np.linspace(0.0, min(TURNS / rate, scene.window.duration), 7)).trajectory
    return motion.t, np.hstack([motion.q_world_body_wxyz, motion.omega_body])


@each_case("name", ["tennis-racket", "discus-wobble", "fast-top", "book-with-drag", "gliding-top"])
@each_case("turn", [0.05, 0.99 * TURN])
def test_the_approximate_integrator_has_the_stated_error_a_radian(name: str, turn: float) -> None:
    equations = equations_of(library_scene(name))
    _, (first, *_) = states(name)
    speed = float(np.linalg.norm(first[4:]))
    spans = np.full((1, round(100 / turn)), turn / (speed + equations.rate))
    exact, approximate = (
        follow(equations, first[None], spans, one) for one in (EXACT, APPROXIMATE)
    )
    relative = np.array([1.0] * 4 + [1 / speed] * 3)
    assert 0 < np.abs((approximate - exact) * relative).max() <= 100 * ERROR


@each_case("name", SCENES)
def test_by_a_scenes_equations_a_state_goes_where_the_exact_motion_does(name: str) -> None:
    t, exact = states(name)
    equations = equations_of(library_scene(name))
    spans = np.diff(t, prepend=0.0)[None]
    made = follow(equations, exact[:1], spans)[0]
    size = np.repeat([1.0, np.abs(exact[:, 4:]).max()], [4, 3])
    speeds = np.linalg.norm(exact[:, 4:], axis=1) + equations.rate
    known = ULPS * EPS * np.sum(1 + np.diff(t) * speeds.max() / TURN)
    assert np.abs((made - exact) / size).max() < known
    if equations.slowing.any() or equations.torque.any() or equations.kept.any():
        zero = np.zeros(3)
        without = equations.of(slowing=zero, torque=zero, torque_world=zero, kept=zero)
        other = follow(without, exact[:1], spans)[0]
        assert np.abs((other - exact) / size).max() > known


@each_case("name", SCENES)
def test_rates_are_those_of_the_states(name: str) -> None:
    _, exact = states(name)
    equations = equations_of(library_scene(name))
    h = 1e-4 / max(equations.rate, float(np.linalg.norm(exact[0, 4:])))
    kept = np.tile(equations.kept, (len(exact), 1))
    around = [follow(equations, exact, np.full((len(exact), 1), s * h))[:, 0] for s in (1, -1)]
    derivative = (around[0] - around[1])[:, 4:] / (2 * h)
    # A central difference is off by h² of a third derivative, and by rounding over h.
    size = np.abs(exact[:, 4:]).max()
    assert (
        np.abs(rates(equations, exact, kept)[:, 3:] - derivative).max() < 1e-7 * size**2 + EPS / h
    )


@pytest.mark.parametrize("integrator", KNOWN, ids=lambda one: one.name)
def test_a_known_integrator_has_its_order(integrator) -> None:
    """But for the one that keeps the length of L, on a scene whose gravity changes it."""
    t, exact = states("fast-top")
    equations, spans = equations_of(library_scene("fast-top")), np.full((1, 1), t[-1])
    off = [
        np.linalg.norm(follow(equations, exact[:1], spans, integrator, t[-1] / n)[0, 0] - exact[-1])
        for n in (64, 128)
    ]
    order = np.log2(off[0] / off[1])
    assert abs(order - (0 if integrator.keeps_length else ORDERS.get(integrator.name, 1))) < 0.25


@pytest.mark.parametrize("integrator", [EXACT, *KNOWN[:1]])
def test_a_motion_is_not_followed_once_it_is_too_fast(integrator: Integrator) -> None:
    scene = library_scene("motor-driven-top")
    equations, start = equations_of(scene), solve(scene, np.zeros(1)).trajectory
    states_at_start = np.hstack([start.q_world_body_wxyz, start.omega_body])
    spans, h = np.full((1, 50), scene.window.duration / 50), scene.window.duration / 5000
    motion = equations, states_at_start, spans, integrator
    (every,) = follow(*motion, h * (integrator is not EXACT))
    speeds = norms(every[:, 4:])
    bound = (speeds[9] + speeds[10]) / 2
    (made,) = follow(*motion, h * (integrator is not EXACT), bound)
    first = int(np.argmax(speeds > bound))
    np.testing.assert_array_equal(made[:first], every[:first])
    assert np.isnan(made[first:]).all()


@each_case("integrator", [EXACT, *KNOWN])
def test_no_state_is_infinite(integrator: Integrator) -> None:
    dragged = equations_of(library_scene("book-with-drag"))
    speeding = dragged.of(slowing=-dragged.slowing)
    start = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e150]])
    for span in 10.0 ** np.arange(-160, 300, 20):
        (made,) = follow(speeding, start, np.array([[span]]), integrator, span)
        assert not np.isinf(made).any()


def test_several_sets_of_equations_are_not_taken_for_one():
    both = equations_of(library_scene("fast-top")).repeated(2)
    with pytest.raises(ValueError, match="2 sets of equations for 1 of states"):
        follow(both, np.zeros((1, 7)), np.zeros((1, 1)))
