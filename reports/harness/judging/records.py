"""The records by which a method on a scene is judged."""

from collections.abc import Sequence
from dataclasses import dataclass

from ....scenarios import Known
from ...results.evidence import Evidence
from ...results.records import Row


@dataclass(frozen=True, eq=False)
class Records:
    """The runs of a method on a scene, and the evidence measured besides them.

    Attributes
    ----------
    evidence : the evidence from single steps and from replays of runs
    rows : rows of the ladder, coarse to fine
    single_rows : rows at timesteps that a user asked for, or that an expectation names
    above_rows : rows at timesteps longer than all rungs
    has_ladder : whether a ladder was asked for, though it may be empty
    order : the lower of the declared orders of ω and attitude
    as_shipped : whether the method is an engine with all its defaults
    lacking : why the engine cannot simulate the scene, in words; else empty
    is_single : whether the engine computes in single precision
    rounding : relative change of the body's angular acceleration if its moments of inertia are
        rounded to the engine's precision
    is_replayed : whether runs can be replayed; runs that were read from a file cannot
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
        """The run that decides the verdict if its outcome is not ok; None if there is no such run.

        It is the finest of the ladder, or else the last at a single timestep. If a ladder was asked
        for and is empty, it is the first run with a longer timestep that is hopeless
        (`is_hopeless`).
        """
        if self.rows or not self.has_ladder:
            return [*self.single_rows, *self.rows][-1]
        # Without rungs, only runs above the ladder exist, which are too coarse to show anything but
        # a failure.
        return next(filter(self.is_hopeless, self.above_rows), None)

    def is_hopeless(self, row: Row) -> bool:
        """Return whether no finer timestep can succeed.

        That is so if the run failed, or if it is unsupported and the method lacks an effect of the
        scene.
        """
        return bool(self.lacking) if row.outcome == "unsupported" else row.outcome == "failed"
