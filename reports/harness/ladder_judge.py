"""Judges a method's ladder as it grows: each signal by itself; the worst counts."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...engines import Engine, Method
from ...reference import Solution
from ...scenarios import SIGNAL, Scenario
from ..results.evidence import JudgedRung
from ..results.records import Row, SignalVerdict
from ..results.verdict_words import RANKS
from .best_window import SHARP
from .observed_order import ASYMPTOTIC
from .richardson import RichardsonLadder, SignalSequence
from .verdict import Judgement, judge

#: A ladder continues until every limit is known to `GOAL`, relative or in rad, or steps run out; to
#: `FINE_GOAL` for methods of `HIGH_ORDER`, which need few rungs for it; to `SHARP`, enough for a
#: judgement, for engines as shipped.
GOAL, FINE_GOAL = 1e-4, 1e-9
HIGH_ORDER = 4
#: Rungs needed for an extrapolated limit with an error estimate.
RUNGS_OF_A_LIMIT = 3


@dataclass(frozen=True, eq=False)
class SignalJudgement:
    """A ladder in one signal, and its judgement."""

    sequence: SignalSequence
    judgement: Judgement

    @property
    def severity(self) -> tuple[int, float, float]:
        """Sort key, worst last.

        Of two unresolved ones, the one that no timestep would resolve, or that needs the finer one;
        of two that no timestep would resolve, the one with the larger tolerance.
        """
        judgement = self.judgement
        rank = RANKS[judgement.word]
        if judgement.word == "unresolved":
            return rank, -(judgement.needed_timestep or 0.0), judgement.tolerance or 0.0
        excess = (judgement.limit_error or 0.0) / (judgement.tolerance or math.inf)
        return rank, 0.0, excess


@dataclass(eq=False)
class LadderJudge:
    """Takes the rows of a ladder, coarse to fine, and judges those finer than the last failed one.

    Attributes
    ----------
    solution : the exact motion at the ladder's sample times
    judged : rungs as they were judged before, by timestep, s; their motions are not needed
    rungs : all rungs taken, of ladders that a failed run ended, too
    blown_up_below : rows that finished before a finer one did not, if there are enough of them to
        show that finer timesteps are worse
    """

    scenario: Scenario
    engine: Engine
    method: Method
    solution: Solution
    judged: Mapping[float, JudgedRung] = field(default_factory=dict)
    rungs: list[JudgedRung] = field(default_factory=list)
    blown_up_below: list[Row] = field(default_factory=list)
    _taken: list[Row] = field(default_factory=list)
    _ladder: RichardsonLadder | None = None
    _judged: list[SignalJudgement] | None = None

    def take(self, row: Row) -> None:
        """Take the next rung's row."""
        self._judged = None
        judged = self.judged.get(row.timestep)
        if row.outcome != "ok" or (row.motion is None and judged is None):
            sound = [taken for taken in self._taken if taken.survived]
            if len(sound) >= RUNGS_OF_A_LIMIT:
                self.blown_up_below = sound
            self._ladder, self._taken = None, []
            return
        if self._ladder is None:
            self._ladder = self._new_ladder()
            self.blown_up_below = []
        if judged is not None:
            self._ladder.take(judged)
        elif row.motion is not None:
            self._ladder.add(row.timestep, row.motion, row.steps)
        self.rungs.append(self._ladder.rungs[-1])
        self._taken.append(row)

    @property
    def finished(self) -> int:
        """Number of rungs that are judged."""
        return len(self._ladder) if self._ladder else 0

    @property
    def signals(self) -> list[SignalJudgement]:
        """Every signal's judgement, computed once a rung; empty while there are too few rungs."""
        if self._judged is None:
            self._judged = []
            if self._ladder is not None and self.finished >= RUNGS_OF_A_LIMIT:
                sequences = [self._ladder.signal(signal) for signal in SIGNAL]
                self._judged = [SignalJudgement(one, judge(one)) for one in sequences]
        return self._judged

    @property
    def rows(self) -> list[Row]:
        """The rungs that are judged."""
        return self._taken

    @property
    def sequences(self) -> list[SignalSequence]:
        """Every signal's ladder; empty while there are too few rungs."""
        return [one.sequence for one in self.signals]

    @property
    def worst(self) -> SignalJudgement:
        """The judgement that the verdict is based on; there must be enough rungs."""
        return max(self.signals, key=lambda one: one.severity)

    def records(self) -> tuple[SignalVerdict, ...]:
        """The judgements to store."""
        return tuple(one.judgement.of(one.sequence) for one in self.signals)

    @property
    def is_known(self) -> bool:
        """Whether some signal disagrees, or every signal's limit is known to the goal."""
        if not self.signals:
            return False
        words = {one.judgement.word for one in self.signals}
        if "disagrees" in words:
            return True
        goal = self._goal
        return "unresolved" not in words and all(
            one.judgement.extrapolation_tolerance <= max(goal, (one.judgement.tolerance or 0) / 2)
            for one in self.signals
        )

    def is_out_of_reach(self, finest: float) -> bool:
        """Whether, by declared orders, an error would be too large even at the finest timestep, s.

        Only the error of the runs is used: the extrapolated limit becomes reliable later than that.
        """
        return any(
            one.judgement.word == "unresolved"
            and one.sequence.errors[-1]
            * (finest / one.sequence.timesteps[-1]) ** one.sequence.declared_order
            > ASYMPTOTIC
            for one in self.signals
        )

    @property
    def _goal(self) -> float:
        if self.method.as_shipped:
            return SHARP
        order = min(self.method.order, self.method.attitude_order)
        return FINE_GOAL if order >= HIGH_ORDER else GOAL

    def _new_ladder(self) -> RichardsonLadder:
        single = self.engine.single_precision
        return RichardsonLadder(
            self.scenario,
            self.solution,
            self.method.order,
            self.method.attitude_order,
            precision=self.engine.slack,
            ulp=float(np.finfo(np.float32 if single else np.float64).eps),
        )
