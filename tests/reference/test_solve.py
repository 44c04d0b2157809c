"""`solve` picks the simplest method, bounds its own error, and knows where an exact motion ends."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from library_scenes import library_scene
from spincheck.reference import solve, solve_cheaply
from spincheck.reference.cross_check import cross_check
from spincheck.reference.motion import motion
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.solution import MAX_UNCERTAINTY
from spincheck.reference.solve import ROUNDING
from spincheck.reference.taylor import Orders, integrate
from spincheck.scenarios import (
    Scenario,
    Trajectory,
    angular_momentum_world,
    errors_between,
)
from top_scenes import ASYMMETRIC, HEAVY, TOP, scene

pytestmark = pytest.mark.slow

EPS = float(np.finfo(float).eps)
TIMES = np.linspace(0.0, 2.0, 41)
FREE = ""
#: The stated error may miss the true one by this factor at the most.
HONESTY = 10.0
#: All terms in double-double.
DEAREST_ORDERS = Orders(40, 40)
#: Two double pendulum-like swings of an asymmetric top, strongly chaotic.
CHAOTIC = scene(
    body="mass = 1.0\ninertia = [1.0, 2.0, 2.5]\ncom = [0.6, 0.5, 0.4]",
    start="euler_zyz_deg = [0.0, 170.0, 20.0]\nomega_body = [0.5, 1.0, 0.3]",
    window="duration = 400.0\nsamples = 2001",
)


def true_motion(scenario: Scenario, times: np.ndarray) -> Trajectory:
    """The motion by a series dearer than any that `solve` uses, rounded once."""
    problem = rotational_problem(scenario)
    return motion(scenario, problem, times, integrate(problem, times, DEAREST_ORDERS))


METHODS = {
    "free symmetric": (scene(body=TOP, effects=FREE), "precession"),
    "free asymmetric": (scene(body=ASYMMETRIC, effects=FREE), "Jacobi"),
    "heavy symmetric": (scene(body=TOP, effects=HEAVY), "Lagrange"),
    "heavy asymmetric": (scene(ASYMMETRIC + "com = [0.1, 0.2, 0.3]", effects=HEAVY), "Taylor"),
    "drag": (scene(body=TOP, effects="[effects.drag]\nrotational = 0.1"), "Taylor"),
    "pushed": (scene(effects=HEAVY + "\n[effects.torque]\nbody = [0, 0, 1]"), "Taylor"),
}


@pytest.mark.parametrize(("scenario", "word"), METHODS.values(), ids=METHODS)
def test_the_effects_select_the_simplest_method(scenario, word):
    assert word in solve(scenario, TIMES).method


def test_times_must_increase_from_zero_on():
    with pytest.raises(ValueError, match="'times' must increase from 0 on"):
        solve(scene(), np.array([1.0, 0.5]))


def bodies() -> st.SearchStrategy[str]:
    """Moments that obey the triangle inequality, from near-symmetric to flat."""
    share = st.floats(0.0, 1.0)
    moments = st.tuples(st.floats(0.5, 2.0), st.floats(0.5, 2.0), share).map(
        lambda m: [m[0], m[1], abs(m[0] - m[1]) + m[2] * (m[0] + m[1] - abs(m[0] - m[1])) or 0.1]
    )
    return st.builds(
        lambda m, com: f"mass = 1.0\ninertia = {m}\ncom = {com}",
        moments.filter(lambda m: min(m) > 1e-3),
        st.sampled_from([[0.0, 0.0, 0.5], [0.3, -0.2, 0.4]]),
    )


def scenes() -> st.SearchStrategy[Scenario]:
    number = st.floats(-5.0, 5.0)
    effects = st.sampled_from([FREE, HEAVY, HEAVY + "\n[effects.drag]\nrotational = 0.1"])
    return st.builds(
        lambda body, omega, angle, effects: scene(
            body,
            f"euler_zyz_deg = [10.0, {angle}, 20.0]\nomega_body = {list(omega)}",
            effects,
            "duration = 2.0\nsamples = 41",
        ),
        bodies(),
        st.tuples(number, number, number),
        st.floats(0.0, 180.0),
        effects,
    )


@settings(max_examples=40, deadline=None)
@given(scenes())
def test_the_stated_uncertainty_covers_the_true_error(scenario):
    true = true_motion(scenario, TIMES)
    for solution in (solve(scenario, TIMES), *solve_cheaply(scenario, [TIMES])):
        known = true.until(len(solution.trajectory.t))
        for name, error in errors_between(scenario, solution.trajectory, known):
            assert error <= HONESTY * getattr(solution.uncertainty, name), (solution.method, name)


@pytest.mark.parametrize("hinge", ["driven", "free"])
def test_it_covers_rounding_where_the_momenta_of_rotors_cancel(hinge):
    rotors = "".join(
        "[[rotors]]\naxis = [1.0, 1.0, 1.0]\nposition = [0.0, 0.0, 0.0]\nmass = 1.0\n"
        f'inertia = [0.01, 0.015]\nspin = {spin}\nhinge = "{hinge}"\n'
        for spin in (1e4, -1e4)
    )
    start = "quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\nomega_body = [0.01, 0.003, 0.02]"
    opposite = scene(ASYMMETRIC, start, rotors)
    solution = solve(opposite, TIMES)
    kept = opposite.body.inertia_com @ opposite.start.omega_body
    L = angular_momentum_world(opposite, solution.trajectory)
    error = np.linalg.norm(L - kept, axis=1).max() / np.linalg.norm(kept)
    assert ROUNDING < error <= solution.uncertainty.angular_momentum


def test_where_the_series_ends_early_the_cheap_motion_is_the_closed_form():
    on_the_saddle = library_scene("separatrix-exactly")
    (solution,) = solve_cheaply(on_the_saddle, [on_the_saddle.times])
    assert (solution.method, solution.horizon) == (solve(on_the_saddle, TIMES).method, None)


def test_elsewhere_it_is_the_series():
    (solution,) = solve_cheaply(scene(body=TOP, effects=HEAVY), [TIMES])
    assert "Taylor" in solution.method


#: Few long steps reach the end, between which DOP853's dense output is off by more than it bounds.
SLOW = scene(
    "mass = 1.0\ninertia = [0.5, 1.0, 1.5]",
    "euler_zyz_deg = [10, 0, 20]\nomega_body = [0, 0.5, 0.125]",
    FREE,
    "duration = 2.0\nsamples = 41",
)


@settings(max_examples=20, deadline=None)
@given(scenes())
@example(SLOW)
def test_an_independent_integrator_finds_the_same_motion(scenario):
    solution = solve(scenario, TIMES)
    if solution.horizon is not None:
        return
    other = cross_check(scenario, TIMES)
    for name, error in errors_between(scenario, other.trajectory, solution.trajectory):
        growth = getattr(solution.conditioning, name) / EPS
        assert error <= other.steps * other.tolerance * growth + ROUNDING, name


def test_a_chaotic_motion_ends_where_its_uncertainty_exceeds_the_bound_and_is_right_up_to_there():
    solution = solve(CHAOTIC, CHAOTIC.times)
    assert solution.horizon is not None
    assert solution.trajectory.t[-1] < solution.horizon < CHAOTIC.window.duration
    assert max(solution.uncertainty.omega, solution.uncertainty.attitude) <= MAX_UNCERTAINTY
    exact = true_motion(CHAOTIC, solution.trajectory.t)
    errors = errors_between(CHAOTIC, solution.trajectory, exact)
    assert errors.attitude <= HONESTY * solution.uncertainty.attitude


def test_conditioning_is_what_one_ulp_in_the_start_does():
    """Beside the upright saddle of a slow top, a nudge grows as the linear theory says."""
    waking = scene(
        start="euler_zyz_deg = [0.0, 1e-3, 0.0]\nomega_body = [0.0, 0.0, 1.0]",
        window="duration = 4.0\nsamples = 41",
    )
    short, long = (solve(waking, np.linspace(0, end, 41)) for end in (2.0, 4.0))
    assert long.conditioning.attitude > 10 * short.conditioning.attitude


def test_a_steady_spin_is_conditioned_like_its_angle():
    solution = solve(scene(body=TOP, effects=FREE), TIMES)
    turn = np.linalg.norm(solution.trajectory.omega_body[0]) * TIMES[-1]
    for name in ("omega", "attitude"):
        assert EPS <= getattr(solution.conditioning, name) <= 4 * turn * EPS, name
