"""The exact flow of states is that of double-doubles to a few ulp, under every effect."""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from mpmath import mpf
from spincheck.reference import ExactMotion, IntegrationError, flow
from spincheck.reference.flow import MAX_STEPS, ORDERS, flow_each
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import constants_of, integrate, inverses_to, terms_of
from spincheck.scenarios import EFFECTS, Scenario, Trajectory
from spincheck.scenarios.agreement import ErrorNorm
from spincheck.scenarios.exact import exact, normalised
from taylor_problems import problem

EPS = float(np.finfo(float).eps)
#: A step of some 0.3 rad rounds each number of the state a few times.
ULPS_A_RADIAN = 16

BODY = {"moments": (1.0, 1.3, 0.7), "omega_axes": (0.5, 1.0, 3.0)}
HEAVY = {"lever_axes": (0.2, 0.1, 0.9), "gravity_world": (0, 0, -1)}
TORQUES = {"torque_axes": (0.25, -0.5, 1.0), "torque_world": (0.25, -2, 0.375)}
PROBLEMS = {
    "free": problem(**BODY),
    "all effects": problem(**BODY, **HEAVY, **TORQUES, drag=0.125),
    "moments of 1 and 1e-12": problem((1, 1, 1e-12), (0.5, 1.0, 3.0)),
    "with a rotor": replace(
        problem(**BODY, **HEAVY), kept=(mpf(2),), kept_axes=(exact((0.6, 0.0, 0.8)),)
    ),
    "spins of 1e4": problem((1.0, 1.3, 0.7), (5e3, 1e4, 3e4), **HEAVY),
    "spins of 1e-8": problem((1.0, 1.3, 0.7), (5e-9, 1e-8, 3e-8)),
}
#: Free, flying, pivoted and pushed bodies, some in skew axes: every effect acts on one of them.
SCENES = [
    "book-in-skew-axes",
    "hammer",
    "lopsided-body",
    "book-with-drag",
    "motor-driven-top",
    "book-pushed",
    "flying-disc",
    "gliding-top",
    "brake-on-one-wheel",
    "wheels-in-syrup",
]


def random_states(p: Problem, n: int) -> np.ndarray:
    """States of the size of the problem's own, (n, 7): ω and q."""
    rng = np.random.default_rng(1)
    speed = max(float(abs(w)) for w in p.omega_axes)
    q = rng.normal(size=(n, 4))
    return np.column_stack(
        [speed * rng.normal(size=(n, 3)), q / np.linalg.norm(q, axis=1, keepdims=True)]
    )


def flowed(p: Problem, states: np.ndarray, spans: np.ndarray):
    after = states.copy()
    inverses = inverses_to(ORDERS[-1])[0]
    momenta = np.tile(np.array(p.kept_momentum, dtype=float), (len(states), 1))
    numbers = after, momenta, spans, MAX_STEPS
    return flow_each(constants_of(p)[0], inverses, terms_of(p), *numbers), after


def relative(after: np.ndarray, other: np.ndarray, speed: float) -> float:
    return float(np.abs((after - other) / np.repeat([speed, 1.0], [3, 4])).max())


@pytest.mark.parametrize("p", PROBLEMS.values(), ids=PROBLEMS)
@pytest.mark.parametrize("turn", [1e-3, 0.1, 1.0, 10.0])
def test_each_state_moves_as_in_double_doubles(p: Problem, turn: float) -> None:
    states = random_states(p, 5)
    speed = float(np.abs(states[:, :3]).max())
    spans = turn / np.maximum(speed, np.ones(5) * float(any(p.lever_axes) or any(p.torque_axes)))
    done, after = flowed(p, states, spans)
    assert done == 5
    nudged = replace(p, moments=(p.moments[0] * (1 + mpf(1e-9)), *p.moments[1:]))
    for k, state in enumerate(states):
        right, wrong = (
            integrate(
                replace(
                    one, omega_axes=exact(state[:3]), q_world_axes=normalised(exact(state[3:]))
                ),
                spans[k : k + 1],
            )
            for one in (p, nudged)
        )
        bound = ULPS_A_RADIAN * EPS * (1 + turn)
        assert relative(after[k], np.concatenate([right[1][0], right[0][0]]), speed) < bound
        differs = relative(after[k], np.concatenate([wrong[1][0], wrong[0][0]]), speed) > bound
        assert differs or turn < 1 or p is PROBLEMS["moments of 1 and 1e-12"]


def distances(scenario: Scenario, states: Trajectory, spans: np.ndarray, after: Trajectory):
    """By signal, the largest between the flow of states and those that come after."""
    norm = ErrorNorm(scenario, after)
    return norm.distances(norm.table(flow(scenario, states, spans)), norm.true_table).max(axis=0)


@pytest.mark.parametrize("back", [False, True], ids=["on", "back"])
@pytest.mark.parametrize("name", SCENES)
def test_the_exact_motion_is_its_own_flow_from_sample_to_sample(name: str, back: bool) -> None:
    scenario = library_scene(name)
    motion = ExactMotion(scenario).outline(scenario.times[:41])
    ends, spans = [motion.until(40), motion.at(np.arange(1, 41))], np.diff(motion.t)
    if back:
        ends, spans = ends[::-1], -spans
    before, after = ends
    assert (distances(scenario, before, spans, after) < ULPS_A_RADIAN * EPS).all()
    late = distances(scenario, before, spans * (1 + 1e-9), after)
    assert (late > ULPS_A_RADIAN * EPS).any()


def test_every_effect_is_flowed_with() -> None:
    assert set().union(*(library_scene(name).called_for for name in SCENES)) == set(EFFECTS)


def test_states_and_spans_are_each_their_own() -> None:
    scenario = library_scene("hammer")
    motion = ExactMotion(scenario).outline(scenario.times[:4])
    spans = np.array([0.0, 0.3, 0.02, 1.0])
    together = flow(scenario, motion, spans)
    np.testing.assert_array_equal(together.t, motion.t)
    np.testing.assert_array_equal(together.com_world[0], motion.com_world[0])
    for k in range(4):
        alone = flow(scenario, motion.at(np.array([k])), spans[k : k + 1])
        for values in ("q_world_body_wxyz", "omega_body", "com_world", "velocity_world"):
            np.testing.assert_array_equal(getattr(alone, values)[0], getattr(together, values)[k])


def test_a_body_at_rest_stays_so_for_however_long() -> None:
    resting = problem((1, 2, 3), (0, 0, 0))
    states = np.array([[0, 0, 0, 1.0, 0, 0, 0]])
    done, after = flowed(resting, states, np.array([1e300]))
    assert done == 1
    np.testing.assert_array_equal(after, states)


@pytest.mark.parametrize("speed", [1e200, np.inf, np.nan])
def test_a_state_beyond_doubles_ends_the_flow_at_once(speed: float) -> None:
    states = np.tile([1.0, 2.0, 3.0, 1.0, 0, 0, 0], (3, 1))
    states[1, :3] *= speed
    assert flowed(problem((1, 2, 4), (1, 2, 3)), states, np.ones(3))[0] == 1


def test_a_span_of_too_many_steps_is_refused() -> None:
    scenario = library_scene("hammer")
    start = ExactMotion(scenario).outline(scenario.times[:1])
    with pytest.raises(IntegrationError, match=r"state 0 cannot be followed for 1e\+30 s"):
        flow(scenario, start, np.array([1e30]))
