"""Richardson extrapolation of a ladder of halved timesteps, in every signal.

Everything whose cost is proportional to a motion's length is computed once, when a rung is added; a
judgement then reads a few numbers a rung.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....reference import Solution
from ....scenarios import ErrorNorm, FloatArray, Scenario, Trajectory
from ....scenarios.effects.gravity import swing_rate
from ....scenarios.fastest_rate import fastest_rate
from ...results.evidence import Deviation, JudgedLadder, JudgedRung, LadderBasis, Refinement
from .asymptotic import ASYMPTOTIC, CAUTIOUS, DISTINCT, ORDER_SLACK, WHOLE
from .rounding import roundings_in_flight, ulp_growth

EPS = float(np.finfo(float).eps)


class RichardsonLadder:
    """The rungs of a method on a scene, each half the one before.

    Parameters
    ----------
    solution : the exact motion at the ladder's sample times
    order, attitude_order : declared, of ω and of the attitude; other signals depend on both
    precision : relative, to which body and start are held by the engine
    ulp : relative, of the engine's floating-point numbers
    """

    def __init__(
        self,
        scenario: Scenario,
        solution: Solution,
        order: int,
        attitude_order: int,
        precision: float,
        ulp: float = EPS,
    ) -> None:
        exact = solution.trajectory
        self._norm = ErrorNorm(scenario, exact)
        signals = self._norm.signals
        declared = [signal.declared_order(order, attitude_order) for signal in signals]
        self.declared = np.array(declared, dtype=float)
        growth = np.array([value for _, value in ulp_growth(scenario, solution)]) / EPS
        self._roundoff_a_step = growth * ulp
        uncertainty = np.array([value for _, value in solution.uncertainty])
        self._uncertainty = uncertainty + growth * precision
        rate = fastest_rate(scenario, exact.omega_body)
        self.basis = LadderBasis(
            self.declared,
            self._uncertainty,
            float(exact.t[-1]),
            rate,
            tuple(signal.name for signal in signals),
        )
        self._scenario, self._solution, self._exact = scenario, solution, exact
        self._p = float(self.declared.min())
        rates = np.maximum(np.linalg.norm(exact.omega_body, axis=1), swing_rate(scenario))
        # ∫ Ω^(p+1) dt: times h^p, the error that a method of order p may have made by then.
        self._committed = np.cumsum(rates ** (self._p + 1) * np.gradient(exact.t))
        self.rungs: list[JudgedRung] = []
        self._last: list[FloatArray] = []

    @property
    def judged(self) -> JudgedLadder:
        """What its rungs show, to be judged."""
        return JudgedLadder(self.basis, tuple(self.rungs))

    def add(self, timestep: float, motion: Trajectory, steps: int) -> None:
        """Take the next rung: its timestep, s, motion, and how many steps it took."""
        norm = self._norm
        table = norm.table(motion)
        roundings = steps + CAUTIOUS * roundings_in_flight(self._scenario, self._solution, steps)
        self._last = [*self._last[-2:], table]
        pair = self._last[-2:]
        rung = JudgedRung(
            timestep,
            norm.distances(table, norm.true_table).max(axis=0),
            roundings * self._roundoff_a_step,
            norm.distances(*pair).max(axis=0) if len(pair) > 1 else None,
        )
        self.rungs.append(rung)
        if len(self._last) > 2:
            self.rungs[-1] = replace(rung, refinement=self._refined())

    @property
    def _differences(self) -> list[FloatArray]:
        return [rung.differences for rung in self.rungs if rung.differences is not None]

    @property
    def _refinements(self) -> list[Refinement]:
        return [rung.refinement for rung in self.rungs if rung.refinement]

    def _refined(self) -> Refinement:
        norm = self._norm
        coarsest, coarse, fine = self._last
        orders = self._extrapolation_orders()
        limit = norm.extrapolated(coarse, fine, orders)
        limit_errors = norm.distances(limit, norm.true_table)
        changes = norm.distances(limit, norm.extrapolated(coarsest, coarse, orders))
        is_clean = self._is_clean(orders, changes.max(axis=0))
        rounding = self._rounding(is_clean, changes.max(axis=0))
        noise_floor = rounding + self._uncertainty
        allowed = CAUTIOUS * np.maximum.accumulate(changes) + noise_floor
        return Refinement(
            orders=orders,
            limit_error=limit_errors.max(axis=0),
            limit_change=changes.max(axis=0),
            is_clean=is_clean,
            rounding=rounding,
            deviations=self._deviations(np.maximum.accumulate(limit_errors), allowed),
        )

    def _is_clean(self, orders: FloatArray, changes: FloatArray) -> NDArray[np.bool_]:
        """Whether differences shrink by 2^p, and limits by 2^(p+1), or 2^(p+2) if symmetric."""
        before = self._refinements[-1].limit_change if self._refinements else 0 * changes
        with np.errstate(divide="ignore", invalid="ignore"):
            shrinking = np.log2(before / changes)
            seen = np.log2(self._differences[-2] / self._differences[-1])
        is_clean = np.abs(seen - orders) <= ORDER_SLACK
        is_clean &= shrinking >= orders + 1 - 2 * ORDER_SLACK
        is_clean &= shrinking <= orders + 2 + 2 * ORDER_SLACK
        return np.asarray(is_clean, dtype=bool)

    def _rounding(self, is_clean: NDArray[np.bool_], changes: FloatArray) -> FloatArray:
        """The derived bound, or less where clean rungs, this one or those before, show less.

        Rounding shows in a limit's change, and over clean rungs it cannot be much larger than that.
        Twice as many steps at most double it.
        """
        bound = self.rungs[-1].roundoff_bounds
        if self._refinements:
            bound = np.minimum(bound, 2 * self._refinements[-1].rounding)
        return np.where(is_clean, np.minimum(bound, CAUTIOUS * changes), bound)

    def _deviations(self, errors: FloatArray, allowed: FloatArray) -> tuple[Deviation | None, ...]:
        """The deviations of every signal; both are running maxima, (n, signals)."""
        is_wrong = (errors > DISTINCT * allowed) & (allowed <= ASYMPTOTIC)
        samples = [np.flatnonzero(one) for one in is_wrong[: self._samples_in_range()].T]
        times = self._exact.t
        return tuple(
            Deviation(
                float(times[wrong[0]]),
                float(times[wrong[-1]]),
                float(errors[wrong[-1], k]),
                float(allowed[wrong[-1], k]),
            )
            if len(wrong)
            else None
            for k, wrong in enumerate(samples)
        )

    def _extrapolation_orders(self) -> FloatArray:
        """The declared orders, or higher whole numbers if two refinements in a row show them."""
        if len(self._differences) < 3:
            return self.declared
        with np.errstate(divide="ignore", invalid="ignore"):
            seen = -np.diff(np.log2(self._differences[-3:]), axis=0)
        least = np.floor(np.min(seen, axis=0) + ORDER_SLACK)
        is_above = np.isfinite(least) & (least > self.declared) & (least <= 2 * self.declared + 2)
        return np.where(is_above, least, self.declared)

    def _samples_in_range(self) -> int:
        """Samples, the first at least, by which not all of the motion can have been damped away."""
        # By the coarsest of the three rungs that a limit's change is made of.
        return max(
            1, int(np.searchsorted(self._committed * self.rungs[-3].timestep ** self._p, WHOLE))
        )
