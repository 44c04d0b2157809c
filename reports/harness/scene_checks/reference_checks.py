"""Checks of the reference, scene by scene: invariants, a cross-check, published values."""

from collections.abc import Iterator

import numpy as np

from ....reference import Solution, drifts, solve
from ....reference.allowed_drift import allowed_drifts
from ....reference.cross_check import CrossCheck, cross_check, times_within_reach
from ....scenarios import Scenario, errors_between
from .published import published_that_do_not_hold

EPS = float(np.finfo(float).eps)
#: Largest error bound of a cross-check, relative or in rad, with which it is conclusive. Larger
#: errors do not grow linearly, as conditioning assumes.
TELLING = 1e-2


def complaints(scenario: Scenario) -> Iterator[str]:
    """Yield complaints about a scene's reference, one sentence each; none if it passes.

    Raises
    ------
    IntegrationError
        If the exact motion cannot be found.
    """
    solution = solve(scenario, scenario.times)
    yield from drifting(scenario, solution)
    yield from _cross_check(scenario, solution)
    yield from published_that_do_not_hold(scenario)


def drifting(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Yield a complaint for each conserved quantity that drifts further than uncertainty allows."""
    allowed = allowed_drifts(scenario, solution.trajectory, solution.uncertainty)
    for name, drift in drifts(scenario, solution.trajectory).items():
        if not drift <= allowed[name]:
            yield f"{name} drifts by {drift:.2e}, more than {allowed[name]:.2e}"


def _cross_check(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Yield a complaint for each signal in which a solution by DOP853 differs too much.

    The span that is compared is halved until the error bound of DOP853 is small enough.
    """
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
    """Return bounds, by signal, of the difference between a solution and its cross-check.

    Each is the sum of the local errors of the cross-check, multiplied by the conditioning, and of
    the solution's uncertainty.
    """
    committed = other.steps * other.tolerance
    uncertainty = dict(solution.uncertainty)
    return {name: committed * ulp / EPS + uncertainty[name] for name, ulp in solution.conditioning}
