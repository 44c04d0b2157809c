"""The timestep and cost that each method of a scene needs to stay within several bounds."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ...results.records import Key
from .cost_to_reach import Barrier, How, reach
from .report_data import MethodRuns, SceneRuns
from .work_precision import curve_of

ErrorBounds = Mapping[str, float]


@dataclass(frozen=True)
class Candidate:
    """One method, and the timestep and cost it needs to stay within every bound.

    Attributes
    ----------
    word, reason : how that is known, or why it is out of reach, for the deciding bound
    decided_by : the error whose bound needs the smallest timestep, or cannot be reached
    largest_stable : s, the coarsest timestep from which all finer ones ended well
    timestep : s; None where out of reach
    cost : CPU seconds a simulated second at that timestep
    spread : of the timings of a step, relative
    """

    key: Key
    word: How | Barrier
    reason: str
    decided_by: str
    largest_stable: float | None
    timestep: float | None = None
    cost: float | None = None
    spread: float = 0.0

    @property
    def label(self) -> str:
        """As users type it."""
        return self.key.label


def candidates(scene: SceneRuns, bounds: ErrorBounds) -> list[Candidate]:
    """Timestep and cost of each method for staying within all bounds, the cheapest first.

    Engines as shipped are left out, since they may simulate something else than the scene, and so
    are other readers of models.
    """
    offered = [runs for runs in scene.methods if runs.is_recommendable]
    offers = [_candidate(scene, runs, bounds) for runs in offered]
    return sorted(offers, key=lambda candidate: candidate.cost or math.inf)


def as_cheap(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The candidates whose cost differs from the first's by less than the spread of the timings."""
    best, *others = candidates
    if best.cost is None:
        return []
    limit = best.cost * (1 + best.spread)
    return [other for other in others if other.cost is not None and other.cost <= limit]


def _candidate(scene: SceneRuns, runs: MethodRuns, bounds: ErrorBounds) -> Candidate:
    """The smallest of the timesteps that the bounds ask for, or the first bound out of reach."""
    curves = {signal: curve_of(scene, runs, signal) for signal in bounds}
    reached = {signal: reach(curves[signal], bound) for signal, bound in bounds.items()}
    timesteps = {
        signal: reach_there.timestep if reach_there.timestep is not None else 0.0
        for signal, reach_there in reached.items()
    }
    signal = min(timesteps, key=lambda name: timesteps[name])
    curve, reach_there = curves[signal], reached[signal]
    key = Key(scene.name, runs.engine, runs.method)
    stable = curve.stable[0].timestep if curve.stable else None
    candidate = Candidate(key, reach_there.word, reach_there.reason, signal, stable)
    if not timesteps[signal] or curve.seconds_per_step is None:
        return candidate
    spread = next((row.seconds_spread for row in reversed(runs.rows) if row.seconds_spread), 0.0)
    return replace(
        candidate,
        timestep=timesteps[signal],
        cost=reach_there.cost,
        spread=spread / curve.seconds_per_step,
    )
