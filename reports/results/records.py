"""The results of a study: one row a run, one verdict a method and scene."""

from dataclasses import dataclass

from ...engines import Cause, Outcome
from ...scenarios import Errors, SignalName, Trajectory
from .verdict_words import VERDICT, VerdictWord

#: Names of an engine and of one of its methods.
Pair = tuple[str, str]
#: s; the timestep of the one row of a method on a scene whose reference could not be solved.
UNSOLVED = 0.0


@dataclass(frozen=True)
class Key:
    """Which scene, engine and method."""

    scenario: str
    engine: str
    method: str


@dataclass(frozen=True)
class Defect:
    """What a run does between two samples, beside the exact flow, in one signal.

    Attributes
    ----------
    p50, p95, max : median, 95th percentile and largest over the intervals, in the norm of errors
    at : s, the end of the interval of the largest
    floor : the largest that round-off may make
    """

    p50: float
    p95: float
    max: float
    at: float
    floor: float


@dataclass(frozen=True, eq=False)
class Row:
    """One run against the reference.

    Attributes
    ----------
    reason : why, where the outcome is not ok; of an engine as shipped, what differs from the scene
    cause : the same in a word
    without_skill : whether a run that is ok is no better than no motion
        (`harness/without_skill.py`)
    stopped_at : s, when it diverged or failed
    errors : at the run's sample times; None unless it is ok
    drifts : largest change of each conserved quantity, relative, by name
    uncertainty : the reference's, in ω, relative
    seconds_per_step, seconds_spread : CPU seconds, least over the repeats, and (max − min) of them;
        None where it was not timed
    wall_seconds_per_step : the least wall time; None where it was not timed
    motion : the samples; None if there are none, or only those of a finer run are kept
    printed : what the engine wrote to the terminal
    stock : whether the timestep is one at which an engine is run on every scene: its own stock
        timestep, and 1 ms
    unasked : of an engine as shipped, what acted though the scene does not call for it, by the
        engine's names
    defects : by signal (`harness/defects.py`); None where the motion turns too far to be followed
    """

    key: Key
    engine_version: str
    timestep: float
    outcome: Outcome
    reason: str = ""
    cause: Cause = ""
    stopped_at: float | None = None
    errors: Errors | None = None
    drifts: dict[str, float] | None = None
    uncertainty: float = 0.0
    steps: int = 0
    seconds_per_step: float | None = None
    seconds_spread: float | None = None
    wall_seconds_per_step: float | None = None
    motion: Trajectory | None = None
    printed: str = ""
    without_skill: bool = False
    stock: bool = False
    unasked: tuple[str, ...] = ()
    defects: dict[str, Defect] | None = None

    def __post_init__(self) -> None:
        if self.errors is not None and self.outcome != "ok":
            raise ValueError(f"a run that is not ok has no errors: {self.outcome}, {self.key}")

    @property
    def made(self) -> bool:
        """Whether the run was made: a stock timestep may be too coarse or too fine for a scene."""
        return self.cause != "timestep"

    @property
    def survived(self) -> bool:
        """Whether the run came to its end and is better than no motion."""
        return self.outcome == "ok" and not self.without_skill


@dataclass(frozen=True)
class SignalVerdict:
    """The verdict on a ladder in one signal.

    Attributes
    ----------
    declared_order, order : of accuracy; the observed one is None where no errors show it
    limit_error : distance of the Richardson-extrapolated motion from the exact one
    tolerance : the largest that this distance may be
    """

    signal: SignalName
    verdict: VerdictWord
    reason: str
    declared_order: int
    order: float | None = None
    limit_error: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True)
class LocalCheck:
    """What a method does from exact states along the motion.

    Attributes
    ----------
    reason : how its steps are inconsistent with the equations of motion, in words; empty if not
    tolerance : to which they are known to be consistent, relative to the largest terms
    remembers : whether a step depends on more than the state before it
    settles : whether a constraint holds the body, which takes some steps to settle
    states : number of states
    pieces : the verdicts on short runs from some of them
    """

    reason: str
    tolerance: float
    remembers: bool
    settles: bool
    states: int
    pieces: tuple[SignalVerdict, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """The verdict on a method on a scene: that of the signal with the worst verdict.

    Attributes
    ----------
    signal : the signal with the worst verdict
    order, limit_error, tolerance : of that signal, as in `SignalVerdict`
    signals : the verdicts on all signals; empty if no ladder was judged
    unmet : expectations in the scene's file that this method did not meet, in words
    as_shipped : whether the method is the engine with all its defaults
    is_expected_failure : whether it is an expected failure of the scene's file
    ground : what a verdict `converges` rests on, in words
    """

    key: Key
    verdict: VerdictWord
    reason: str
    signal: SignalName = "omega"
    order: float | None = None
    limit_error: float | None = None
    tolerance: float | None = None
    signals: tuple[SignalVerdict, ...] = ()
    unmet: tuple[str, ...] = ()
    as_shipped: bool = False
    is_expected_failure: bool = False
    ground: str = ""

    @property
    def agrees(self) -> bool:
        """Whether a study with this verdict passes."""
        expected = self.as_shipped or self.is_expected_failure
        wrong = VERDICT[self.verdict].fails and not expected
        return not wrong and not self.unmet

    @property
    def is_unproven(self) -> bool:
        """Whether a method, not as shipped, is shown neither to converge nor to be wrong."""
        expected = self.as_shipped or self.is_expected_failure
        return VERDICT[self.verdict].is_unproven and not expected
