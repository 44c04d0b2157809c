"""Errors against CPU time: the runs of each method on a scene, and the best runs of all methods.

Engines are compared at equal error, never at equal timestep (work–precision diagrams: Hairer,
Nørsett & Wanner, Solving Ordinary Differential Equations I, §II.10). docs/explanation/cost.md has
the rules and their constants.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...results.records import OfMethod, Row
from ...results.verdict_words import VERDICT, VerdictWord
from .observed_order import observed_order
from .report_data import MethodRuns, SceneRuns

#: Factor by which errors must grow at shorter timesteps to be put down to rounding. When a timestep
#: is halved, errors by random rounding grow by √2, errors by biased rounding by 2 or more.
GROWN = 2**0.5
#: Machine epsilon of double precision: relative errors are not taken to be smaller.
EPS = float(np.finfo(float).eps)
#: Machine epsilon of single precision.
SINGLE = float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class CurvePoint:
    """One run that ended `ok`, as a point of a curve.

    Attributes
    ----------
    timestep : s
    cost : CPU seconds for a simulated second; None if not timed
    error : the run's error in one signal, raised to the reference's uncertainty if below that
    """

    timestep: float
    cost: float | None
    error: float


@dataclass(frozen=True)
class Curve(OfMethod):
    """The errors of one method on one scene in one signal, against timestep and cost.

    Attributes
    ----------
    signal : name of the signal
    points : every run that ended `ok`, coarse to fine
    stable : the runs of the ladder, or at stock timesteps if there are no others, that ended `ok`
        and for which all finer runs did, too, coarse to fine
    seconds_per_step : CPU time of a step, s; None if it was not timed
    uncertainty : uncertainty of the reference in this signal
    rounding : error that a change of the start by one ulp of the engine's precision may cause
    duration : simulated time, s
    single_precision : whether the engine computes in single precision
    declared : the order of accuracy of ω that the adapter declares; None if not known
    verdict : the verdict on the method and scene; None if there is none
    reason : the verdict's reason, or why there is no verdict
    order : the order at which gains vanish, from the verdict; None if not known
    """

    engine: str
    method: str
    signal: str
    points: tuple[CurvePoint, ...]
    stable: tuple[CurvePoint, ...]
    seconds_per_step: float | None
    uncertainty: float
    rounding: float
    duration: float
    single_precision: bool
    declared: int | None
    verdict: VerdictWord | None
    reason: str
    order: float | None

    def floor(self, timestep: float) -> float:
        """Return the error that rounding may cause in a run, plus the reference's uncertainty.

        Each step may cause the error `rounding`. In double precision these errors are added up,
        which is a bound, as all steps may round the same way. In single precision that bound would
        exceed most errors, so `rounding` times √steps is used, the sum of random rounding.

        Parameters
        ----------
        timestep : s
        """
        steps = self.duration / timestep
        added_up = math.sqrt(steps) if self.single_precision else steps
        return self.uncertainty + self.rounding * added_up

    @cached_property
    def observed_order(self) -> float | None:
        """The slope of log error against log timestep, fitted to the finest usable runs.

        A run is usable if its error is in the asymptotic range, above round-off, and well above the
        reference's uncertainty. If fewer than two runs are usable, the order is that of the
        verdict, `order`, which may be None.
        """
        timesteps = np.array([point.timestep for point in self.stable])
        errors = np.array([point.error for point in self.stable])
        floors = np.array([self.floor(timestep) for timestep in timesteps])
        order = observed_order(timesteps, errors, floors, self.uncertainty)
        return self.order if order is None else order

    @cached_property
    def least(self) -> CurvePoint | None:
        """The run with the least error, if errors at shorter timesteps grow, else None.

        Runs at timesteps longer than all in `stable` are left out. It is None for a method whose
        verdict fails, too: its errors need not grow by rounding.

        As a single larger error may be chance, there must be at least two runs at shorter
        timesteps, stock ones included, and the finest must have an error larger by the factor
        `GROWN`. In addition, their errors must either grow from each run to the next, or all be
        larger by that factor, with the finest run's at least the largest divided by `GROWN`.
        """
        if not self.stable or (self.verdict and VERDICT[self.verdict].fails):
            return None
        coarsest = max(point.timestep for point in self.stable)
        points = sorted(self.points, key=lambda point: -point.timestep)
        least = min(
            (point for point in points if point.timestep <= coarsest), key=lambda point: point.error
        )
        finer = [point.error for point in points if point.timestep < least.timestep]
        if len(finer) < 2 or finer[-1] <= GROWN * least.error:
            return None
        grow = all(a < b for a, b in pairwise([least.error, *finer]))
        stay = min(finer) > GROWN * least.error and finer[-1] * GROWN >= max(finer)
        return least if grow or stay else None

    @property
    def finest_useful(self) -> float | None:
        """The timestep, s, below which errors grow; None if no run shows that they do."""
        return self.least.timestep if self.least else None


def curves(scene: SceneRuns, signal: str) -> list[Curve]:
    """Return the curve of each method on a scene: its errors in a signal, by timestep and cost.

    There are none if the scene could not be solved.
    """
    return [curve_of(scene, runs, signal) for runs in scene.methods] if scene.solved else []


def curve_of(scene: SceneRuns, runs: MethodRuns, signal: str) -> Curve:
    """Return the curve of one method, its errors in a signal, on a scene that was solved."""
    solution = scene.exact.solution
    finished = [row for row in runs.rows if row.errors]
    unfinished = [row.timestep for row in runs.rows if row.made and row.outcome != "ok"]
    points = tuple(_point(scene, row, signal) for row in finished)
    has_others = any(not row.stock for row in finished)
    ulp = SINGLE / EPS if runs.single_precision else 1.0
    return Curve(
        engine=runs.engine,
        method=runs.method,
        signal=signal,
        points=points,
        stable=tuple(
            point
            for point, row in zip(points, finished, strict=True)
            # A stock timestep may be so close to one of the ladder that the two give no slope.
            if point.timestep < min(unfinished, default=math.inf) and not (row.stock and has_others)
        ),
        seconds_per_step=finished[-1].seconds_per_step if finished else None,
        uncertainty=max(solution.uncertainty[signal], EPS),
        rounding=ulp * solution.conditioning[signal],
        duration=scene.end,
        single_precision=runs.single_precision,
        declared=runs.declared.order if runs.declared else None,
        verdict=runs.verdict.verdict if runs.verdict else None,
        reason=runs.verdict.reason if runs.verdict else "the study was stopped before a verdict",
        order=runs.verdict.order if runs.verdict else None,
    )


def cost(row: Row) -> float | None:
    """Return a run's CPU seconds for a simulated second; None if its steps were not timed."""
    if row.seconds_per_step is None or not row.timestep:
        return None
    return row.seconds_per_step / row.timestep


def slope(coarse: CurvePoint, fine: CurvePoint) -> float:
    """Return the slope of log error against log timestep between two runs."""
    return math.log(coarse.error / fine.error) / math.log(coarse.timestep / fine.timestep)


def front(drawn: Iterable[Curve]) -> list[tuple[Curve, CurvePoint]]:
    """Return the Pareto front of several curves, the cheapest run first.

    These are the timed runs that are more accurate than all cheaper ones, each with its curve.
    """
    timed = [
        (point.cost, point.error, curve, point)
        for curve in drawn
        for point in curve.points
        if point.cost is not None
    ]
    best: list[tuple[Curve, CurvePoint]] = []
    for _, error, curve, point in sorted(timed, key=lambda entry: entry[:2]):
        if not best or error < best[-1][1].error:
            best.append((curve, point))
    return best


def _point(scene: SceneRuns, row: Row, signal: str) -> CurvePoint:
    """Return a run, which must have errors, as a point of the curve of a signal."""
    least = max(scene.uncertainty(row)[signal], EPS)
    assert row.errors is not None, "only a run with errors is a point"
    return CurvePoint(row.timestep, cost(row), max(row.errors[signal], least))
