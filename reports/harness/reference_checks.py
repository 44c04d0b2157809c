"""Checks of the truth itself, scene by scene: a truth is not believed either."""

from collections.abc import Iterator

import numpy as np

from ...reference import Solution, drifts, solve
from ...reference.allowed_drift import allowed_drifts
from ...reference.cross_check import CrossCheck, cross_check, times_within_reach
from ...scenarios import (
    FloatArray,
    Published,
    Scenario,
    Trajectory,
    angular_momentum_world,
    energy,
    errors_between,
)

EPS = float(np.finfo(float).eps)
#: A second method that may be this far off, relative or in rad, tells nothing, and errors of that
#: size no longer grow in proportion, as conditioning assumes.
TELLING = 1e-2


def complaints(scenario: Scenario) -> Iterator[str]:
    """What is wrong with a scene's reference, in words; nothing if it stands."""
    solution = solve(scenario, scenario.times)
    yield from drifting(scenario, solution)
    yield from _cross_check(scenario, solution)
    for published in scenario.published:
        yield from _published(scenario, published)


def drifting(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Conserved quantities that drift further than the stated uncertainty allows."""
    allowed = allowed_drifts(scenario, solution.trajectory, solution.uncertainty)
    for name, drift in drifts(scenario, solution.trajectory).items():
        if not drift <= allowed[name]:
            yield f"{name} drifts by {drift:.2e}, more than {allowed[name]:.2e}"


def _cross_check(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Compare with DOP853, as far as it tells something: half of the span, while it does not."""
    times = times_within_reach(scenario, solution.trajectory)
    while True:
        if len(times) < len(solution.trajectory.t) or times[-1] < solution.trajectory.t[-1]:
            solution = solve(scenario, times)
        other = cross_check(scenario, solution.trajectory.t)
        bounds = _bounds(solution, other)
        if max(bounds.values()) <= TELLING or len(times) <= 2:
            break
        times = times[: (len(times) + 1) // 2]
    for name, error in errors_between(scenario, other.trajectory, solution.trajectory):
        if not error <= bounds[name]:
            yield f"{name} differs by {error:.2e} from a second method good to {bounds[name]:.2e}"


def _bounds(solution: Solution, other: CrossCheck) -> dict[str, float]:
    """How far the second method may be off: each step errs, and the motion grows that."""
    committed = other.steps * other.tolerance
    known = dict(solution.uncertainty)
    return {name: committed * ulp / EPS + known[name] for name, ulp in solution.conditioning}


def _published(scenario: Scenario, published: Published) -> Iterator[str]:
    """Compare with what somebody else printed."""
    times = np.array([0.0, published.t]) if published.t > 0 else np.array([0.0])
    at_time = solve(scenario, times).trajectory
    for name, wanted in published.values().items():
        got = _QUANTITIES[name](scenario, at_time)[-1]
        if name == "quaternion_wxyz" and np.dot(got, wanted) < 0:
            got = -got
        error = float(np.max(np.abs(got - np.array(wanted))))
        if not error <= published.tolerance:
            yield (
                f"{name} at t = {published.t:g} s is {error:.2e} from the value printed in "
                f"{published.source}, tolerance {published.tolerance:g}"
            )


def _omega_world(_: Scenario, motion: Trajectory) -> FloatArray:
    return motion.to_world(motion.omega_body)


_QUANTITIES = {
    "omega_body": lambda _, motion: motion.omega_body,
    "omega_world": _omega_world,
    "quaternion_wxyz": lambda _, motion: motion.q_world_body_wxyz,
    "com_world": lambda _, motion: motion.com_world,
    "L_world": angular_momentum_world,
    "energy": energy,
}
