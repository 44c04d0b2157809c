"""What it takes each method of a scene to stay within several bounds at once."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ....scenarios import Scenario
from ...results.records import Key
from .cost_to_reach import Barrier, How, Reach, below_finest, first_within, reach
from .report_data import MethodRuns, SceneRuns
from .work_precision import EPS, Curve, Signal, curve_of, observed_order, slope

Bounds = Mapping[Signal, float]


@dataclass(frozen=True)
class Candidate:
    """One method, and what it takes it to stay within every bound.

    Attributes
    ----------
    word, reason : how that is known, or why it is out of reach; of the bound that decides
    decided_by : the error that needs the smallest timestep, or cannot be reached
    largest_stable : s, the coarsest timestep from which all finer ones ended well
    timestep : s, a whole number of them from sample to sample; None where out of reach
    cost : CPU seconds a simulated second at that timestep
    spread : of the timings of a step, relative
    """

    key: Key
    word: How | Barrier
    reason: str
    decided_by: Signal
    largest_stable: float | None
    timestep: float | None = None
    cost: float | None = None
    spread: float = 0.0

    @property
    def label(self) -> str:
        """As users type it."""
        return f"{self.key.engine} {self.key.method}"


def candidates(scene: SceneRuns, bounds: Bounds) -> list[Candidate]:
    """What it takes each method to stay within all bounds, the cheapest first.

    Engines as shipped are none: what they do besides the scene, a bound on errors does not tell.
    """
    offered = [runs for runs in scene.methods if not (runs.declared and runs.declared.as_shipped)]
    found = [_candidate(scene, runs, bounds) for runs in offered]
    return sorted(found, key=lambda candidate: candidate.cost or math.inf)


def as_cheap(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The others that the spread of the timings cannot tell from the first."""
    best, *others = candidates
    if best.cost is None:
        return []
    limit = best.cost * (1 + best.spread)
    return [other for other in others if other.cost is not None and other.cost <= limit]


def _candidate(scene: SceneRuns, runs: MethodRuns, bounds: Bounds) -> Candidate:
    """The smallest of the timesteps that the bounds ask for, or the first bound out of reach."""
    curves = {signal: curve_of(scene, runs, signal) for signal in bounds}
    reached = {signal: reach(curves[signal], bound) for signal, bound in bounds.items()}
    timesteps = {
        signal: _cautious(curves[signal], found) if found.timestep is not None else 0.0
        for signal, found in reached.items()
    }
    signal = min(timesteps, key=lambda name: timesteps[name])
    curve, found = curves[signal], reached[signal]
    key = Key(scene.name, runs.engine, runs.method)
    stable = curve.stable[0].timestep if curve.stable else None
    candidate = Candidate(key, found.word, found.reason, signal, stable)
    if not timesteps[signal] or curve.seconds_per_step is None:
        return candidate
    assert scene.found is not None, "only a solved scene has candidates"
    timestep = _whole(_sample_interval(scene.found.scenario), timesteps[signal])
    spread = next((row.seconds_spread for row in reversed(runs.rows) if row.seconds_spread), 0.0)
    return replace(
        candidate,
        timestep=timestep,
        cost=curve.seconds_per_step / timestep,
        spread=spread / curve.seconds_per_step,
    )


def _cautious(curve: Curve, found: Reach) -> float:
    """The timestep of a bound, smaller where the curve of logarithms bends.

    Between two runs the error is at most that of the finer one times (dt ratio)^p, if p is the
    steeper of the slopes on either side of it. Below the finest the slope goes to a whole number
    as dt → 0: where it comes from above, that number is the lesser.
    """
    assert found.timestep is not None, "a bound out of reach has no timestep"
    if found.word == "extrapolated":
        order = observed_order(curve)
        assert order is not None, "what shows no order is not extrapolated"
        return below_finest(curve, found.level, min(order, max(1, round(order))))
    k = first_within(curve, found.level)
    if not k:
        return found.timestep
    fine = curve.stable[k]
    slopes = [slope(curve.stable[k - 1], fine)]
    finer = curve.stable[k + 1 : k + 2]
    slopes += [slope(fine, point) for point in finer if point.error > curve.floor(point.timestep)]
    return float(fine.timestep * (found.level / fine.error) ** (1 / max(slopes)))


def _whole(interval: float, timestep: float) -> float:
    """The largest timestep up to the one given that divides the interval between samples."""
    # A ladder's own timestep divides it already, but for the last bits of a quotient.
    return interval / math.ceil(interval / timestep * (1 - 4 * EPS))


def _sample_interval(scenario: Scenario) -> float:
    return float(scenario.window.duration / (scenario.window.samples - 1))
