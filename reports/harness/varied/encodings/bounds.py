"""Bounds of the difference that rounding makes between two encodings of a motion, by signal."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from .....engines import Engine
from .....engines.checks.read_back import State
from .....engines.encodings import KEPT, SAME_BODY, Encoding, SceneChange
from .....engines.models.description import away_from
from .....reference import Solution
from .....scenarios import SIGNAL, Scenario, Trajectory, signals_of
from .....scenarios.mechanics import angular_momentum_world
from .....scenarios.rotation import norms

#: The signals that make up a state; the other signals follow from these.
JUDGED = ("omega", "attitude", "com", "velocity", "spins")
#: Number of motions that are rounded: both.
BOTH = 2
#: Number of numbers that a motion follows from, each of which rounding may change: three of ω,
#: three of the attitude, six of the tensor. The conditioning is for a change of all of them of
#: length one.
NUMBERS = 12
#: Number of operations by which a component of ω̇ is rounded in a step.
OPERATIONS = 20
EPS = float(np.finfo(float).eps)


def rounding_bounds(
    scenario: Scenario, encoding: Encoding, solution: Solution, steps: int, engine: Engine
) -> dict[str, float]:
    """Return the largest distances, in the norm of errors, that rounding explains, by signal.

    To first order two motions are apart by the conditioning, per ulp, times the ulp by which their
    bodies and states are apart, with √n for n numbers that each change by as much (Higham, §1.6).

    - The body: one that reads back within `SAME_BODY` ulp of I₃ + m r², r from the frame's origin
      to the com, has a least moment that is off by (I₃ + m r²) / I₁ times as many ulp.
    - A step: ω̇ = I⁻¹ (ω × I ω) is rounded relative to ‖I⁻¹‖ ‖I‖ ω² = (I₃ + m r²) / I₁ ω², and ω
      changes by ω dt times that, an ulp of ω for the 20 operations of a component at 0.05 rad a
      step; the state is rounded once. Steps add up as if all had one sign. With parts that turn, L
      is not I ω; torques are added that cancel in coordinates that turn with the parts, at places
      whose rounding is relative to their distance from the origin; and I₁ is the least moment that
      is left when the parts turn freely. The arm r to a free body's com is rounded in the same way,
      in the torque m r × ω² r.
    - The flight, for place and velocity of a free body: an ulp of either scene's own numbers, and
    of
      forces that cancel in coordinates that turn with parts.
    """
    change, exact = encoding.change(scenario), solution.trajectory
    changed, moved = _farthest(encoding.scene(scenario), encoding), _moved(change, exact)
    far = float(norms(moved.com_world).max()) / change.length
    flight = _roundings_in_flight(changed, replace(solution, trajectory=moved), steps)
    ulps = steps * _ulps_a_step(scenario, exact, steps, far) + flight + SAME_BODY
    ulps *= _condition(changed) * BOTH * np.sqrt(NUMBERS) * engine.ulp / EPS
    units = {"com": change.length, "velocity": change.length / change.time}
    # A place turns with the body, so that its rounding makes a velocity.
    metres = SIGNAL["com"].growth(changed, moved, solution.conditioning)
    metres *= SIGNAL["com"].base(changed, moved)
    swing = metres * float(norms(moved.omega_body).max())
    flung = _flung(scenario, exact, far) * engine.ulp * float(exact.t[-1])
    flown = {"com": flung * float(exact.t[-1]) / 2, "velocity": flung}
    bounds = {}
    for signal in signals_of(scenario):
        if (name := signal.name) not in JUDGED:
            continue
        ulp = solution.conditioning[name]
        # If nothing moves, distances are 0 or infinite, whatever they are relative to.
        base = signal.base(scenario, exact) or 1.0
        if name in units and not scenario.constraint.is_pivot:
            absolute = signal.growth(changed, moved, solution.conditioning)
            absolute *= signal.base(changed, moved)
            absolute += swing if name == "velocity" else 0.0
            own = signal.growth(scenario, exact, solution.conditioning)
            ulp = max(absolute / units[name] / base, own)
        bounds[name] = ulp * ulps + flown.get(name, 0.0) / base
    return bounds


def _moved(change: SceneChange, exact: Trajectory) -> Trajectory:
    """Return the exact motion with the changed scene's units, places and velocities."""
    state = State(exact.q_world_body_wxyz, exact.omega_body, exact.com_world, exact.velocity_world)
    place, velocity = change.motion(state, exact.t)
    return Trajectory(
        t=exact.t * change.time,
        q_world_body_wxyz=exact.q_world_body_wxyz,
        omega_body=exact.omega_body / change.time,
        com_world=place,
        velocity_world=velocity,
        spins=exact.spins / change.time,
    )


def _flung(scenario: Scenario, exact: Trajectory, far: float) -> float:
    """Return cancelling accelerations, m/s², if parts of a free body are off its com, both ways."""
    if not scenario.constraint.is_free:
        return 0.0
    force, _ = scenario.cancelling(exact.spins, far)
    return BOTH * OPERATIONS * float(force.max()) / scenario.body.mass


@lru_cache(maxsize=KEPT)
def _farthest(scenario: Scenario, encoding: Encoding) -> Scenario:
    """Return the scene with its com at the distance that the model's farthest frame has from it."""
    if encoding.description.parts == "one":
        return scenario
    there = zip(scenario.body.com_exact, away_from(scenario.body), strict=True)
    x, y, z = (com - far for com, far in there)
    return SceneChange(shift=(x, y, z)).scene(scenario)


def _ulps_a_step(scenario: Scenario, exact: Trajectory, steps: int, far: float) -> float:
    """Return roundings of ω in a step, in condition numbers: one, or more with fast parts."""
    speed = norms(exact.omega_body).max() or 1 / float(exact.t[-1])
    turning = np.abs(exact.spins) + speed
    _, torque = scenario.cancelling(turning, far)
    torque = torque + norms(angular_momentum_world(scenario, exact)) * speed
    if scenario.constraint.is_free:
        torque = (
            torque + scenario.body.mass * float(np.linalg.norm(scenario.body.com)) * far * speed**2
        )
    rate = torque.max() / (scenario.body.principal_moments[-1] * speed)
    return max(1.0, OPERATIONS * float(rate * exact.t[-1]) / steps)


def _condition(scenario: Scenario) -> float:
    """Return the condition number (I₃ + m r²) / I₁, r the distance of com and frame's origin."""
    body = scenario.body
    far = float(np.linalg.norm(body.com))
    left = scenario.without_free_axes(body.inertia_com_exact)
    moments = np.linalg.eigvalsh(np.array(left, dtype=float))
    return float((body.principal_moments[-1] + body.mass * far**2) / moments[0])


def _roundings_in_flight(scenario: Scenario, solution: Solution, steps: int) -> float:
    """Return the roundings of L, in ulp, that a free body's flight adds to those of the steps.

    There are none on a pivot. Engines may solve for rotation and flight together, with terms m v²
    that cancel: the model is that a torque of one ulp of them is left, m v² T / L ulp of L over the
    run, added up as a random walk. Measured in MuJoCo 4.0: at 957 m/s for 98 s L is off by 1e-11,
    at rest and 47 km away by nothing.

    Parameters
    ----------
    steps : number of steps of the run
    """
    if scenario.constraint.is_pivot:
        return 0.0
    exact, body = solution.trajectory, scenario.body
    fast = float(np.linalg.norm(exact.velocity_world, axis=1).max())
    momentum = float(np.linalg.norm(exact.omega_body @ body.inertia_com, axis=1).max())
    if not momentum:
        return 0.0
    return body.mass * fast**2 * float(exact.t[-1]) / momentum / float(np.sqrt(steps))
