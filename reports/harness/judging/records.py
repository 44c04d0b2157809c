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
    rows : of the ladder, coarse to fine
    last : the run that decides where nothing is judged; None if there is none
    as_shipped, of_file : whether the method is an engine with all its defaults, or of a user's file
    slack : relative, to which the engine holds a state
    interval : s, between two samples
    lacking : why the engine cannot simulate the scene, in words; else empty
    least_steps : that the first rung would take, more than the limit; None if there are rungs
    ending : why the exact motion ends before its window, in words; else empty
    single : whether only single timesteps were asked for
    cut_short : whether finer rungs would have been run if the step limit allowed them
    unmet : expectations of the scene that were not met, in words
    known : the expected failures of the scene's file
    """

    evidence: Evidence
    rows: Sequence[Row] = ()
    last: Row | None = None
    as_shipped: bool = False
    of_file: bool = False
    slack: float = 0.0
    interval: float = 0.0
    lacking: str = ""
    least_steps: float | None = None
    ending: str = ""
    single: bool = False
    cut_short: bool = False
    unmet: tuple[str, ...] = ()
    known: Sequence[Known] = ()

    @cached_property
    def judged_rows(self) -> list[Row]:
        """Those finer than the last that failed."""
        return since_failure(self.rows)[0]

    @cached_property
    def blown_up_below(self) -> list[Row]:
        """Those that finished, while finer ones did not."""
        return since_failure(self.rows)[1]

    @cached_property
    def ladder(self) -> LadderJudgement:
        """The judgement on these rows."""
        return judged_ladder(self.evidence, self.rows)

    @cached_property
    def local(self) -> LocalJudgement | None:
        """The judgement on steps and pieces from exact states; None where there are none."""
        return LocalJudgement(self.evidence.local) if self.evidence.local else None

    @property
    def remembers(self) -> bool:
        """Whether a run goes on otherwise than if restarted from its own states."""
        return (self.evidence.memory or 0.0) > 1
