"""What a scene's exact motion conserves, and how far a run drifts from it.

A quantity is computed by the same code from every trajectory, the reference's or an engine's.
Drifts are relative to a scale that the scene alone sets. So they can be compared across runs, and a
run that blows up is not measured against its own large values.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..scenarios import FloatArray, Scenario, Trajectory
from .conservation_laws import LAWS, InvariantScales, Law
from .rotational_problem import rotational_problem


@dataclass(frozen=True, eq=False)
class Invariant:
    """A conservation law together with a scene for which it holds.

    Attributes
    ----------
    law : the law
    scene : the scene, with the sizes that the law's scale is computed from
    """

    law: Law
    scene: InvariantScales

    @property
    def name(self) -> str:
        """The law's name."""
        return self.law.name

    def values(self, motion: Trajectory) -> FloatArray:
        """Return the conserved quantity at each sample, in the law's unit, (n,) or (n, 3)."""
        return self.law.values(self.scene, motion)

    def drift_series(self, motion: Trajectory) -> FloatArray:
        """Return |Q(t) − Q(0)| relative to the law's scale at each sample, (n,).

        Q is the conserved quantity, a number or a vector. If the scale is zero, the drift is 0
        where Q has not changed and inf elsewhere. It is also inf where a run has blown up so far
        that a term or its square overflows.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            values = self.values(motion).reshape(len(motion.t), -1)
            change = np.asarray(np.linalg.norm(values - values[0], axis=1))
        change[np.isnan(change)] = np.inf
        scale = self.law.scale(self.scene)
        return change / scale if scale > 0 else np.where(change == 0, 0.0, np.inf)

    def drift(self, motion: Trajectory) -> float:
        """Return the conserved quantity's largest change along a motion, relative to its scale."""
        return float(self.drift_series(motion).max())


@lru_cache(maxsize=1)
def invariants(scenario: Scenario) -> tuple[Invariant, ...]:
    """Return the conservation laws of a scene's exact motion."""
    scene = InvariantScales(scenario, rotational_problem(scenario))
    return tuple(Invariant(law, scene) for law in LAWS if law.holds(scene))


def drifts(scenario: Scenario, motion: Trajectory) -> dict[str, float]:
    """Return the largest change of each conserved quantity relative to its scale, by law's name."""
    return {invariant.name: invariant.drift(motion) for invariant in invariants(scenario)}
