"""Checks of the reference, scene by scene: invariants, a cross-check, published values."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ...reference import ExactMotion, Solution, drifts, solve
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
#: A cross-check whose own error may be this large, relative or in rad, is inconclusive; errors of
#: that size no longer grow in proportion, as conditioning assumes.
TELLING = 1e-2


def complaints(scenario: Scenario) -> Iterator[str]:
    """Complaints about a scene's reference, one sentence each; none if it passes."""
    solution = solve(scenario, scenario.times)
    yield from drifting(scenario, solution)
    yield from _cross_check(scenario, solution)
    yield from published_that_do_not_hold(scenario)


def drifting(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Conserved quantities that drift further than the stated uncertainty allows."""
    allowed = allowed_drifts(scenario, solution.trajectory, solution.uncertainty)
    for name, drift in drifts(scenario, solution.trajectory).items():
        if not drift <= allowed[name]:
            yield f"{name} drifts by {drift:.2e}, more than {allowed[name]:.2e}"


def _cross_check(scenario: Scenario, solution: Solution) -> Iterator[str]:
    """Compare with DOP853; the span is halved until DOP853's own error is small enough."""
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
    """Bound on the cross-check's error: local errors of all steps, grown by the conditioning."""
    committed = other.steps * other.tolerance
    uncertainty = dict(solution.uncertainty)
    return {name: committed * ulp / EPS + uncertainty[name] for name, ulp in solution.conditioning}


@dataclass(frozen=True, eq=False)
class PublishedValue:
    """A published value, beside the reference's.

    Attributes
    ----------
    quantity : as the scenario file names it
    printed, ours : components, SI, NaN where none was printed; our quaternion has the sign of the
        printed one
    """

    published: Published
    quantity: str
    printed: FloatArray
    ours: FloatArray

    @property
    def difference(self) -> float:
        """The largest difference of a component."""
        return float(np.nanmax(np.abs(self.ours - self.printed)))

    @property
    def holds(self) -> bool:
        """Whether the difference is within the tolerance of the digits printed."""
        return self.difference <= self.published.tolerance


def published_values(scenario: Scenario) -> Iterator[PublishedValue]:
    """Every quantity of a scene's `[[published]]`, beside the reference's at that time."""
    exact = ExactMotion(scenario)
    for published in scenario.published:
        times = np.array([0.0, published.t]) if published.t > 0 else np.array([0.0])
        at_time = exact.outline(times)
        for name, printed in published.values().items():
            ours = np.atleast_1d(_QUANTITIES[name](scenario, at_time)[-1])
            wanted = np.atleast_1d(np.array(printed, dtype=float))
            flipped = name == "quaternion_wxyz" and np.dot(ours, wanted) < 0
            yield PublishedValue(published, name, wanted, -ours if flipped else ours)


def published_that_do_not_hold(scenario: Scenario) -> Iterator[str]:
    """Values that somebody else printed and the exact motion does not have, in words."""
    for value in published_values(scenario):
        if not value.holds:
            yield (
                f"{scenario.name}: {value.quantity} at t = {value.published.t:g} s is "
                f"{value.difference:.2e} from the value printed in {value.published.source}, "
                f"tolerance {value.published.tolerance:g}"
            )


def _omega_world(_: Scenario, motion: Trajectory) -> FloatArray:
    return motion.to_world(motion.omega_body)


_QUANTITIES: dict[str, Callable[[Scenario, Trajectory], FloatArray]] = {
    "omega_body": lambda _, motion: motion.omega_body,
    "omega_world": _omega_world,
    "quaternion_wxyz": lambda _, motion: motion.q_world_body_wxyz,
    "com_world": lambda _, motion: motion.com_world,
    "L_world": angular_momentum_world,
    "energy": energy,
}
