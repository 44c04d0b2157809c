"""What a method on a scene is judged by."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ....scenarios import Known
from ...results.evidence import Evidence
from ...results.records import Row
from .ladder import LadderJudgement, judged_ladder, since_failure
from .local import LocalJudgement


@dataclass(frozen=True, eq=False)
class Records:
    """Its runs, and what was measured of them.

    Attributes
    ----------
    evidence : of the runs of the ladder, and of steps and pieces from exact states
    rows, single_rows, above_rows : of the ladder, coarse to fine; of single timesteps; above it
    least_steps : of the ladder's first rung, though they exceed the limit; None if only single
        timesteps were asked for
    finest : s, the timestep of the ladder's last rung; 0 if it has none
    order : the least that is declared
    as_shipped, of_file : whether the method is an engine with all its defaults, or of a user's file
    slack : relative, to which the engine holds a state
    interval : s, between two samples
    lacking : why the engine cannot simulate the scene, in words; else empty
    is_single : whether the engine computes in single precision
    rounding : what rounding of the body's moments to that precision changes of its angular
        acceleration, relative
    ending : why the exact motion ends before its window, in words; else empty
    unmet : expectations of the scene that were not met, in words
    known : the expected failures of the scene's file
    """

    evidence: Evidence
    rows: Sequence[Row]
    single_rows: Sequence[Row]
    above_rows: Sequence[Row]
    least_steps: float | None
    finest: float
    order: int
    as_shipped: bool = False
    of_file: bool = False
    slack: float = 0.0
    interval: float = 0.0
    lacking: str = ""
    is_single: bool = False
    rounding: float = 0.0
    ending: str = ""
    unmet: tuple[str, ...] = ()
    known: Sequence[Known] = ()

    @property
    def last(self) -> Row | None:
        """The run that decides the verdict where nothing is judged; None if there is none."""
        if self.rows or self.least_steps is None:
            return [*self.single_rows, *self.rows][-1]
        # Without rungs, only runs above the ladder exist: too coarse for anything but a failure.
        return next(filter(self.is_hopeless, self.above_rows), None)

    @cached_property
    def judged_rows(self) -> list[Row]:
        """Those of the ladder finer than the last that failed."""
        return since_failure(self.rows)[0]

    @cached_property
    def blown_up_below(self) -> list[Row]:
        """Those that finished, while finer ones did not."""
        return since_failure(self.rows)[1]

    @cached_property
    def ladder(self) -> LadderJudgement:
        """The judgement on the judged rows."""
        return judged_ladder(self.evidence, self.judged_rows)

    @cached_property
    def local(self) -> LocalJudgement | None:
        """The judgement on steps and pieces from exact states; None where there are none."""
        return LocalJudgement(self.evidence.local) if self.evidence.local else None

    @property
    def remembers(self) -> bool:
        """Whether a run goes on otherwise than if restarted from its own states."""
        return (self.evidence.memory or 0.0) > 1

    def is_hopeless(self, row: Row) -> bool:
        """Whether no finer timestep can succeed: the run failed, or the method lacks an effect."""
        return bool(self.lacking) if row.outcome == "unsupported" else row.outcome == "failed"
