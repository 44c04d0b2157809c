"""The growth of rounding errors in a run: of body and start, and of every step."""

import numpy as np

from ...reference import Solution
from ...scenarios import Errors, Scenario, energy_base, radius_of_gyration

EPS = float(np.finfo(float).eps)


def ulp_growth(scenario: Scenario, solution: Solution) -> Errors:
    """The change of each signal by the end, if one ulp changes in each number of a state.

    For the rotation that is its conditioning. For a free body the flight is added, which engines
    may integrate for an origin other than the com.
    """
    growth = solution.conditioning
    if scenario.has_pivot:
        return growth
    exact, body = solution.trajectory, scenario.body
    arm = float(np.linalg.norm(body.com))
    speed = float(np.linalg.norm(exact.omega_body, axis=1).max())
    far = float(np.linalg.norm(exact.com_world, axis=1).max())
    fast = float(np.linalg.norm(exact.velocity_world, axis=1).max())
    way = float(np.linalg.norm(exact.com_world - exact.com_world[0], axis=1).max())
    gyration = radius_of_gyration(scenario)
    metres = EPS * (far + arm + fast * float(exact.t[-1])) + growth.attitude * arm
    metres_a_second = EPS * fast + (growth.attitude + growth.omega) * arm * speed
    weight = body.mass * float(np.linalg.norm(scenario.gravity_world))
    joules = body.mass * fast * metres_a_second + weight * metres
    return Errors(
        growth.omega,
        growth.attitude,
        growth.angular_momentum,
        max(growth.energy, _relative(joules, energy_base(scenario, exact))),
        _relative(metres, max(way, gyration)),
        max(EPS, _relative(metres_a_second, max(fast, gyration * speed))),
    )


def precision_in_flight(scenario: Scenario, solution: Solution, ulp: float) -> float:
    """To which relative precision a free body is held that flies far; zero for one on a pivot.

    Engines hold its points in world coordinates, which are rounded in proportion to the distance.

    Parameters
    ----------
    ulp : relative, of the engine's floating-point numbers
    """
    if scenario.has_pivot:
        return 0.0
    far = float(np.linalg.norm(solution.trajectory.com_world, axis=1).max())
    return ulp * far / radius_of_gyration(scenario)


def _relative(change: float, base: float) -> float:
    return change / base if base else EPS
