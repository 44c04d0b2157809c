"""Converts the rotation of a body's principal axes to the motion of the body, and back."""

from typing import NamedTuple

import numpy as np

from ..scenarios import FloatArray, Scenario, Trajectory
from ..scenarios.exact import conjugate
from ..scenarios.rotation import matrices, matrix, norms, turned
from ..scenarios.rotation import times as times_quaternion
from .problem import Problem

#: Names of the effects whose forces on the centre of mass `assembled` takes into account.
FORCES_IN_FLIGHT = frozenset({"gravity"})


class Flight(NamedTuple):
    """The duration and the initial state of the free flight that leads to each sample.

    Attributes
    ----------
    seconds : duration of the flight, s, (n,)
    com_world, velocity_world : position, m, and velocity, m/s, of the centre of mass at the start
        of the flight, (3,), or (n, 3) if each sample has a flight of its own
    """

    seconds: FloatArray
    com_world: FloatArray
    velocity_world: FloatArray


def motion(
    scenario: Scenario,
    problem: Problem,
    times: FloatArray,
    states: tuple[FloatArray, FloatArray],
) -> Trajectory:
    """Return the trajectory of a scene, given the rotation of its principal axes.

    Parameters
    ----------
    times : (n,) s, from the scene's start on
    states : q_world_axes (n, 4), scalar first, and omega_axes (n, 3), rad/s, along these axes
    """
    start = scenario.start
    flight = Flight(times, start.position_world, start.velocity_world)
    kept = np.array(problem.kept, dtype=float)
    return assembled(scenario, problem, times, states, flight, kept)


def assembled(
    scenario: Scenario,
    problem: Problem,
    times: FloatArray,
    states: tuple[FloatArray, FloatArray],
    flight: Flight,
    kept: FloatArray,
) -> Trajectory:
    """Return the trajectory of a scene whose samples may each have a flight of their own.

    Parameters
    ----------
    times : (n,) s, from the scene's start on
    states : q_world_axes (n, 4), scalar first, and omega_axes (n, 3), rad/s
    flight : duration and start of the com's free flight that leads to each sample
    kept : constant angular momentum of each rotor about its axle, kg m²/s, (rotors,) or (n, rotors)
    """
    q_world_axes, omega_axes = states
    q_axes_body = np.array(problem.q_axes_body, dtype=float)
    if q_axes_body[0] == 1:  # body axes are principal: no rotation, no rounding
        q_world_body, omega_body = q_world_axes, omega_axes
    else:
        q_world_body = q_world_axes @ times_quaternion(q_axes_body)
        omega_body = omega_axes @ matrix(q_axes_body)
    com_world, velocity_world = _placed(scenario, q_world_body, omega_body, flight)
    spins = scenario.spins(omega_body, kept)
    return Trajectory(times, q_world_body, omega_body, com_world, velocity_world, spins)


def along_axes(problem: Problem, motion: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Return attitude and ω of a trajectory along the principal axes.

    This is the inverse of the function `motion` of this module.

    Returns
    -------
    q_world_axes (n, 4), of unit norm, and omega_axes (n, 3), rad/s
    """
    q_axes_body = np.array(problem.q_axes_body, dtype=float)
    q_world_axes, omega_axes = motion.q_world_body_wxyz, motion.omega_body
    if q_axes_body[0] != 1:
        q_world_axes = q_world_axes @ times_quaternion(
            np.array(conjugate(problem.q_axes_body), dtype=float)
        )
        omega_axes = omega_axes @ matrix(q_axes_body).T
    return q_world_axes / norms(q_world_axes)[:, None], omega_axes


def _placed(
    scenario: Scenario, q_world_body: FloatArray, omega_body: FloatArray, flight: Flight
) -> tuple[FloatArray, FloatArray]:
    """Return position, m, and velocity, m/s, of the com at n samples, (n, 3) each, world axes.

    On a world axis along which the body is held, they follow from attitude, (n, 4), and ω, rad/s,
    (n, 3); on any other world axis the body is in free flight, as `flight` describes it.
    """
    g, t = scenario.gravity_world, flight.seconds[:, None]
    fallen = flight.com_world + flight.velocity_world * t + 0.5 * g * t**2
    falling, constraint = flight.velocity_world + g * t, scenario.constraint
    if constraint.is_free:
        return fallen, falling
    R_world_body, lever = matrices(q_world_body), constraint.lever
    swing_world = turned(R_world_body, np.cross(omega_body, lever))
    return (
        constraint.com_world(R_world_body @ lever, fallen),
        constraint.velocity_world(swing_world, falling),
    )
