"""Compares published values of a scene with the values of its exact motion."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ....reference import ExactMotion
from ....scenarios import (
    FloatArray,
    Published,
    Scenario,
    Trajectory,
    angular_momentum_world,
    energy,
)


@dataclass(frozen=True, eq=False)
class PublishedValue:
    """A value published in the literature, and the value of the exact motion at the same time.

    Attributes
    ----------
    published : the entry of the scene's file that states the value
    quantity : name of the quantity in the scene's file
    printed : components of the published value, SI; NaN where none was printed
    ours : components of the exact value, SI; a quaternion gets the sign of the published one. All
        are NaN if the exact motion is not known at that time, as after its horizon
    """

    published: Published
    quantity: str
    printed: FloatArray
    ours: FloatArray

    @property
    def difference(self) -> float:
        """The largest difference between the two values in a printed component, SI.

        It is infinite unless `is_known`.
        """
        return float(np.nanmax(np.abs(self.ours - self.printed))) if self.is_known else np.inf

    @property
    def is_known(self) -> bool:
        """Whether the exact motion is known at the time of the published value."""
        return not np.isnan(self.ours).any()

    @property
    def holds(self) -> bool:
        """Whether the two values differ by no more than the tolerance in the scene's file."""
        return self.difference <= self.published.tolerance


def published_values(scenario: Scenario) -> Iterator[PublishedValue]:
    """Yield every value of a scene's `[[published]]`, with the exact value at the same time."""
    for published in scenario.document.published:
        exact = ExactMotion(scenario)
        times = np.array([0.0, published.t]) if published.t > 0 else np.array([0.0])
        at_time = exact.outline(times)
        for name, printed in published.values().items():
            ours = np.atleast_1d(_QUANTITIES[name](scenario, at_time)[-1])
            if at_time.t[-1] < published.t:  # the motion ends before, at its horizon
                ours = np.full_like(ours, np.nan)
            wanted = np.atleast_1d(np.array(printed, dtype=float))
            flipped = name == "quaternion_wxyz" and np.dot(ours, wanted) < 0
            yield PublishedValue(published, name, wanted, -ours if flipped else ours)


def published_that_do_not_hold(scenario: Scenario) -> Iterator[str]:
    """Yield a sentence for each published value that differs too much from the exact value.

    A difference is too large if it exceeds the tolerance that the scene's file states. There is
    also a sentence for each value that cannot be compared, as the exact motion is not known at its
    time.
    """
    for value in published_values(scenario):
        if not value.holds:
            is_printed = np.isfinite(value.printed)
            printed, ours = (
                ", ".join(f"{one:.8g}" for one in components[is_printed])
                for components in (value.printed, value.ours)
            )
            said = (
                f"{scenario.name}: {value.quantity} at t = {value.published.t:g} s: "
                f"{printed} in '{value.published.source}'"
            )
            if not value.is_known:
                yield f"{said} cannot be compared: the exact motion is not known at that time"
                continue
            yield (
                f"{said}, exact {ours}; "
                f"they differ by {value.difference:.2e}, tolerance {value.published.tolerance:g}"
            )


def _omega_world(_: Scenario, motion: Trajectory) -> FloatArray:
    """Return ω at the n samples of a motion along world axes, rad/s, (n, 3); `_` is not used."""
    return motion.to_world(motion.omega_body)


_QUANTITIES: dict[str, Callable[[Scenario, Trajectory], FloatArray]] = {
    "omega_body": lambda _, motion: motion.omega_body,
    "omega_world": _omega_world,
    "quaternion_wxyz": lambda _, motion: motion.q_world_body_wxyz,
    "com_world": lambda _, motion: motion.com_world,
    "L_world": angular_momentum_world,
    "energy": energy,
}
