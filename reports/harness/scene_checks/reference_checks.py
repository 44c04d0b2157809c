"""Checks a scene's exact motion by conserved quantities, a cross-check and published values."""

from collections.abc import Iterator

import numpy as np

from ....reference import Solution, drifts, solve
from ....reference.allowed_drift import allowed_drifts
from ....reference.cross_check import CrossCheck, cross_check, times_within_reach
from ....scenarios import Scenario, errors_between
from .published import published_that_do_not_hold

EPS = float(np.finfo(float).eps)
#: Largest error bound, relative or in rad, of a conclusive cross-check: larger errors do not grow
#: linearly, as the conditioning assumes.
TELLING = 1e-2


def complaints(scenario: Scenario) -> Iterator[str]:
    """Yield a sentence for each check that a scene's exact motion does not pass.

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
    """Yield a sentence for each conserved quantity that drifts more than the uncertainty allows."""
    allowed = allowed_drifts(scenario, solution.trajectory, solution.uncertainty)
    for name, drift in drifts(scenario, solution.trajectory).items():
        if not drift <= allowed[name]:
            yield f"{name} drifts by {drift:.2e}, more than {allowed[name]:.2e}"


def _cross_check(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Yield a sentence for each signal in which DOP853 differs too much from the exact motion.

    The compared part of the window is halved until the error bound of DOP853 is at most `TELLING`.
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
    """Return, by signal, the largest difference between solution and cross-check that is allowed.

    It is the solution's uncertainty plus the global error of the cross-check: the sum of its local
    errors, in ulp, times the conditioning.
    """
    committed = other.steps * other.tolerance
    uncertainty = dict(solution.uncertainty)
    return {name: committed * ulp / EPS + uncertainty[name] for name, ulp in solution.conditioning}
