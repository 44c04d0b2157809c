"""Judges a method's ladder: each signal by itself; the worst counts."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ...results.evidence import Evidence, JudgedLadder
from ...results.records import Row, SignalVerdict
from ..measuring.asymptotic import ASYMPTOTIC
from .sequences import sequence
from .signal_ladder import Judgement, judge_signal

#: Rungs needed for an extrapolated limit with an error estimate.
RUNGS_OF_A_LIMIT = 3


@dataclass(frozen=True, eq=False)
class LadderJudgement:
    """Every signal's judgement; none while there are too few rungs."""

    ladder: JudgedLadder | None

    @cached_property
    def signals(self) -> list[Judgement]:
        """The judgements, in the order of the ladder's signals."""
        if self.ladder is None or len(self.ladder.rungs) < RUNGS_OF_A_LIMIT:
            return []
        return [judge_signal(sequence(self.ladder, name)) for name in self.ladder.basis.signals]

    @property
    def worst(self) -> Judgement:
        """The judgement that the verdict is based on; there must be enough rungs."""
        return max(self.signals, key=lambda one: one.severity)

    def records(self) -> tuple[SignalVerdict, ...]:
        """The judgements to store."""
        return tuple(one.record for one in self.signals)

    def converges_to(self, goal: float) -> bool:
        """Whether every signal converges, its limit known to the goal, relative or in rad."""
        return bool(self.signals) and all(
            one.converges and one.extrapolation_tolerance <= goal for one in self.signals
        )

    def is_known(self, goal: float) -> bool:
        """Whether some signal disagrees, or every signal's limit is known to the goal."""
        if not self.signals:
            return False
        words = {one.word for one in self.signals}
        if "disagrees" in words:
            return True
        return "unresolved" not in words and all(
            one.extrapolation_tolerance <= max(goal, (one.tolerance or 0) / 2)
            for one in self.signals
        )

    def is_out_of_reach(self, finest: float) -> bool:
        """Whether, by declared orders, an error would be too large even at the finest timestep, s.

        Only the error of the runs is used: the extrapolated limit becomes reliable later than that.
        """
        return any(
            one.word == "unresolved"
            and one.sequence.errors[-1]
            * (finest / one.sequence.timesteps[-1]) ** one.sequence.declared_order
            > ASYMPTOTIC
            for one in self.signals
        )


def since_failure(rows: Sequence[Row]) -> tuple[list[Row], list[Row]]:
    """The rows that are judged, finer than the last that failed, and sound ones that it ended.

    The sound ones are those that finished before the failed one did not, if there are enough of
    them to show that finer timesteps are worse, and none finer has finished.
    """
    judged: list[Row] = []
    blown_up_below: list[Row] = []
    for row in rows:
        if row.outcome == "ok":
            judged, blown_up_below = [*judged, row], []
            continue
        sound = [one for one in judged if one.survived]
        blown_up_below = sound if len(sound) >= RUNGS_OF_A_LIMIT else blown_up_below
        judged = []
    return judged, blown_up_below


def judged_ladder(evidence: Evidence, rows: Sequence[Row]) -> LadderJudgement:
    """The judgement on some rows."""
    judged = {row.timestep for row in rows}
    rungs = tuple(rung for rung in evidence.rungs if rung.timestep in judged)
    return LadderJudgement(JudgedLadder(evidence.basis, rungs) if evidence.basis else None)
