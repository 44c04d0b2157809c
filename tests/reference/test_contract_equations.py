"""Every scene's exact motion is consistent, and obeys the equations of Newton and Euler.

A derivative is the difference quotient of five samples close together, wherever along the motion:
earlier errors do not matter, so that chaotic motions are checked too. Each check is repeated with a
planted fault, and must fail.
"""

from functools import cache

import numpy as np
import pytest
from contract_references import every_scene, few, solved, states
from spincheck.reference.motion import motion
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.scenarios import Scenario, Trajectory
from spincheck.scenarios.fastest_rate import fastest_rate

pytestmark = pytest.mark.slow

EPS = float(np.finfo(float).eps)
#: Ulp: of four squares, and of a product of two quaternions.
NORM = 4 * EPS
#: rad; short of π, beyond which a quaternion does change sign between two samples.
CLOSE = 3.0
#: rad at the fastest rate: steps of the difference quotient, at most.
STEP = 2.0**-9
#: d/dt ≈ Σ w x / (12 h); the next term is h⁴/30 times the fifth derivative.
WEIGHTS = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12
#: What it errs by, relative to size times rate: of a motion at up to three times the fastest rate,
#: and of samples rounded to a few ulp.
DIFFERENCES = 3**5 / 30 * STEP**4 + 8 * EPS * float(np.abs(WEIGHTS).sum()) / (STEP / 2)
#: Relative: a fault that is noticed.
NOTICED = 1e-8


@cache
def close_samples(name: str) -> tuple[Scenario, Trajectory, float, float]:
    """Five samples each at a few times, their distance in s, and the fastest rate in 1/s."""
    scenario, solution = solved(name)
    problem, exact = rotational_problem(scenario), solution.trajectory
    rate = fastest(scenario, exact)
    h = 2.0 ** np.floor(np.log2(STEP / rate))  # so that no time is rounded
    times = (h * (np.floor(few(exact.t) / h)[:, None] + np.arange(-4, 1))).ravel()
    close = motion(scenario, problem, times, states(problem, times))
    return scenario, close, h, rate


def fastest(scenario: Scenario, exact: Trajectory) -> float:
    """1/s: of turning, swinging, being driven, nutating, drag; at least one window."""
    least = float(min(rotational_problem(scenario).moments))
    torque = np.linalg.norm(scenario.pushed["torque_body"]) + np.linalg.norm(
        scenario.pushed["torque_world"]
    )
    driven = float(np.sqrt(torque / least))
    nutating = (
        float(np.linalg.norm(scenario.rotors.momentum_body(exact.spins), axis=1).max()) / least
    )
    once = 1 / scenario.window.duration
    turning = fastest_rate(scenario, exact.omega_body)
    return max(turning, driven, nutating, scenario.pushed["drag"] / least, once)


def slope(samples: np.ndarray, h: float) -> np.ndarray:
    """Derivative at the middle of every five samples, (n, k)."""
    return np.einsum("i,nik->nk", WEIGHTS, samples.reshape(-1, 5, samples.shape[1])) / h


def hamilton(q: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """q (0, ω), scalar first, (n, 4)."""
    scalar = -np.einsum("ni,ni->n", q[:, 1:], omega)
    vector = q[:, :1] * omega + np.cross(q[:, 1:], omega)
    return np.column_stack([scalar, vector])


@every_scene
def test_quaternions_are_of_norm_one_and_never_change_sign(name):
    """A turn of less than π between two samples leaves q·q' = cos(θ/2) positive."""
    exact = solved(name)[1].trajectory
    q = exact.q_world_body_wxyz
    assert np.abs(np.linalg.norm(q, axis=1) - 1).max() <= NORM
    speed = np.linalg.norm(exact.omega_body, axis=1)
    turned = np.maximum(speed[1:], speed[:-1]) * np.diff(exact.t)
    same = np.einsum("ni,ni->n", q[1:], q[:-1]) > 0
    assert same[turned < CLOSE].all()


class TestEquationsOfMotion:
    """Differences of five samples close together, each relative to its own rate."""

    @every_scene
    def test_attitude_turns_at_omega(self, name):
        _, close, h, rate = close_samples(name)
        for slip in (0.0, NOTICED):
            omega = close.omega_body[2::5] + slip * rate
            q_rate = 0.5 * hamilton(close.q_world_body_wxyz[2::5], omega)
            misfit = np.abs(slope(close.q_world_body_wxyz, h) - q_rate).max() / rate
            assert (misfit <= DIFFERENCES) == (slip == 0)

    @every_scene
    def test_the_centre_of_mass_moves_at_its_velocity(self, name):
        _, close, h, rate = close_samples(name)
        place, velocity = close.com_world, close.velocity_world[2::5]
        size = np.abs(place).max() * rate + np.abs(velocity).max()
        for slip in (0.0, NOTICED):
            misfit = np.abs(slope(place, h) - velocity - slip * size).max()
            assert (misfit <= DIFFERENCES * size) == (slip == 0 or size == 0)

    @every_scene
    def test_omega_obeys_euler(self, name):
        scenario, close, h, rate = close_samples(name)
        body = scenario.body
        inertia = scenario.inertia
        omega, to_body = close.omega_body[2::5], close.R_world_body[2::5].inv()
        kept = scenario.kept_body(scenario.kept(close.omega_body, close.spins))
        L = close.omega_body @ inertia + kept
        torque = (
            scenario.pushed["torque_body"]
            + to_body.apply(np.array(scenario.pushed["torque_world"]))
            - scenario.pushed["drag"] * omega
        )
        if scenario.constraint.is_pivot:
            weight = body.mass * to_body.apply(np.array(scenario.gravity_world))
            torque = torque + np.cross(body.com, weight)
        elif not scenario.constraint.is_free:  # a table's force, from the com's acceleration
            force = body.mass * (slope(close.velocity_world, h) - scenario.gravity_world)
            torque = torque - np.cross(scenario.constraint.lever, to_body.apply(force))
        size = np.abs(inertia).max() * rate**2
        for slip in (0.0, NOTICED):
            misfit = slope(L, h) + np.cross(omega, L[2::5]) - torque - slip * size
            assert (np.abs(misfit).max() <= DIFFERENCES * size) == (slip == 0)
