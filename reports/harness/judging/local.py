"""Judges single steps, and short pieces, from exact states along the motion.

Consistency everywhere along the motion, and a step that depends on the state alone, make a method
converge (Hairer, Nørsett & Wanner I, theorem II.3.4), also where the motion is chaotic, or so long
that no ladder over the whole window reaches the asymptotic range.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

from ...results.evidence import JudgedLadder, LocalEvidence
from .best_window import SHARP
from .ladder import RUNGS_OF_A_LIMIT, LadderJudgement

#: Steps must be known to be consistent to this, relative to the largest terms: over ten radians
#: that comes to what a limit has to be known to.
CONSISTENT = SHARP / 10
#: And to this, relative to the weakest effect of the scene: a missing one must be seen.
SEEN = 0.1
#: Rungs of the pieces, and the uncertainty of their limits that is enough.
PIECE_RUNGS, PIECE_GOAL = 7, 1e-4


@dataclass(frozen=True, eq=False)
class LocalJudgement:
    """What steps and pieces show."""

    evidence: LocalEvidence

    @cached_property
    def pieces(self) -> LadderJudgement:
        """The judgement on the pieces."""
        pieces = self.evidence.pieces
        return judged_pieces(pieces) if pieces else LadderJudgement(None)

    @property
    def is_consistent(self) -> bool:
        """Whether steps are known to be consistent."""
        found = self.evidence
        is_sound = not (found.finding or found.is_open)
        return is_sound and is_known(found.tolerance, found.of_an_effect)

    @property
    def converges(self) -> bool:
        """Whether steps are known to be consistent, and all pieces converge."""
        return self.is_consistent and self.pieces.converges_to(float("inf"))


def is_known(tolerance: float, of_an_effect: float) -> bool:
    """Whether it is enough to know steps so well."""
    return tolerance <= CONSISTENT and of_an_effect <= SEEN


@lru_cache(maxsize=4)
def judged_pieces(pieces: JudgedLadder) -> LadderJudgement:
    """The judgement on the fewest rungs whose limits are known well enough, or on all."""
    for count in range(RUNGS_OF_A_LIMIT, len(pieces.rungs)):
        judged = LadderJudgement(JudgedLadder(pieces.basis, pieces.rungs[:count]))
        if judged.converges_to(PIECE_GOAL):
            return judged
    return LadderJudgement(pieces)


def is_long_enough(pieces: JudgedLadder) -> bool:
    """Whether pieces need no finer rung."""
    return len(pieces.rungs) >= PIECE_RUNGS or judged_pieces(pieces).converges_to(PIECE_GOAL)
