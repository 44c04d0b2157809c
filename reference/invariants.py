"""What a scene's exact motion conserves, and how far a run drifts from it.

A quantity is computed by the same code from every trajectory, the reference's or an engine's.
Drifts are relative to a scale that the scene alone sets, so that they compare across runs, and a
run that blows up cannot hide behind its own size.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..scenarios import FloatArray, Scenario, Trajectory
from .conservation_laws import LAWS, InvariantScales, Law
from .rotational_problem import rotational_problem


@dataclass(frozen=True, eq=False)
class Invariant:
    """A conservation law that holds for one scene."""

    law: Law
    scene: InvariantScales

    @property
    def name(self) -> str:
        """The law's name."""
        return self.law.name

    def values(self, motion: Trajectory) -> FloatArray:
        """The quantity at every sample, (n,) or (n, 3), in the law's unit."""
        return self.law.values(self.scene, motion)

    def drift_series(self, motion: Trajectory) -> FloatArray:
        """|Q(t) − Q(0)| over the law's scale, (n,); if the scale is zero, 0 or inf.

        It is inf, too, where a run has blown up so far that a term or square exceeds the doubles.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            values = self.values(motion).reshape(len(motion.t), -1)
            change = np.asarray(np.linalg.norm(values - values[0], axis=1))
        change[np.isnan(change)] = np.inf
        scale = self.law.scale(self.scene)
        return change / scale if scale > 0 else np.where(change == 0, 0.0, np.inf)

    def drift(self, motion: Trajectory) -> float:
        """The largest value of `drift_series`."""
        return float(self.drift_series(motion).max())


@lru_cache(maxsize=1)
def invariants(scenario: Scenario) -> tuple[Invariant, ...]:
    """Return the conservation laws of a scene's exact motion."""
    scene = InvariantScales(scenario, rotational_problem(scenario))
    return tuple(Invariant(law, scene) for law in LAWS if law.holds(scene))


def drifts(scenario: Scenario, motion: Trajectory) -> dict[str, float]:
    """Return the largest relative drift of a motion from each law of its scene, by law."""
    return {invariant.name: invariant.drift(motion) for invariant in invariants(scenario)}
