"""What a method on a scene is judged by."""

from collections.abc import Sequence
from dataclasses import dataclass

from ....scenarios import Known
from ...results.evidence import Evidence
from ...results.records import Row


@dataclass(frozen=True, eq=False)
class Records:
    """Its runs, and what was measured of them.

    Attributes
    ----------
    evidence : of single steps and of replayed runs
    rows, single_rows, above_rows : of the ladder, coarse to fine; of single timesteps; above it
    has_ladder : whether a ladder was asked for, though it may be empty
    order : the least that is declared
    as_shipped : whether the method is an engine with all its defaults
    lacking : why the engine cannot simulate the scene, in words; else empty
    is_single : whether the engine computes in single precision
    rounding : what rounding of the body's moments to that precision changes of its angular
        acceleration, relative
    is_replayed : whether runs can be replayed: those of a file cannot
    unmet : expectations of the scene that were not met, in words
    known : the expected failures of the scene's file
    """

    evidence: Evidence
    rows: Sequence[Row]
    single_rows: Sequence[Row]
    above_rows: Sequence[Row]
    has_ladder: bool
    order: int
    as_shipped: bool = False
    lacking: str = ""
    is_single: bool = False
    rounding: float = 0.0
    is_replayed: bool = True
    unmet: tuple[str, ...] = ()
    known: Sequence[Known] = ()

    @property
    def last(self) -> Row | None:
        """The run whose end decides the verdict if it is not ok; None if there is none."""
        if self.rows or not self.has_ladder:
            return [*self.single_rows, *self.rows][-1]
        # Without rungs, only runs above the ladder exist: too coarse for anything but a failure.
        return next(filter(self.is_hopeless, self.above_rows), None)

    def is_hopeless(self, row: Row) -> bool:
        """Whether no finer timestep can succeed: the run failed, or the method lacks an effect."""
        return bool(self.lacking) if row.outcome == "unsupported" else row.outcome == "failed"
