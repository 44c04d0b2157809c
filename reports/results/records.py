"""What a study finds: one row a run, one verdict a method and scene."""

from dataclasses import dataclass
from typing import Literal

from ...engines import Cause, Outcome
from ...scenarios import Errors, Trajectory

Signal = Literal["omega", "attitude", "angular_momentum", "energy", "com", "velocity"]
#: The signals' names in reports and messages.
SIGNAL_NAMES: dict[Signal, str] = {
    "omega": "ω",
    "attitude": "attitude",
    "angular_momentum": "L",
    "energy": "energy",
    "com": "com",
    "velocity": "velocity",
}
VerdictWord = Literal["converges", "disagrees", "unresolved", "diverges", "unsupported", "failed"]

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
    wall_seconds_per_step : likewise the least by the clock on the wall
    motion : the samples; None where there are none, and where a finer run of the method has them
    printed : what the engine wrote to the terminal
    stock : whether the timestep is one of those that an engine is run at whatever the scene: its
        own stock timestep, and 1 ms
    unasked : of an engine as shipped, what acted though the scene does not call for it, by the
        engine's names
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

    def __post_init__(self) -> None:
        if self.errors is not None and self.outcome != "ok":
            raise ValueError(f"a run that is not ok has no errors: {self.outcome}, {self.key}")

    @property
    def made(self) -> bool:
        """Whether there was a run at all: a stock timestep may make no sense of a scene."""
        return self.cause != "timestep"

    @property
    def survived(self) -> bool:
        """Whether the run came to its end and is better than no motion."""
        return self.outcome == "ok" and not self.without_skill


@dataclass(frozen=True)
class SignalVerdict:
    """What a ladder says of a method in one signal.

    Attributes
    ----------
    declared_order, order : of accuracy; the observed one is None where no errors show it
    limit_error : distance of the Richardson-extrapolated motion from the exact one
    tolerance : what that may be
    """

    signal: Signal
    verdict: VerdictWord
    reason: str
    declared_order: int
    order: float | None = None
    limit_error: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True)
class Verdict:
    """What a ladder says of a method on a scene: the worst of what it says of each signal.

    Attributes
    ----------
    signal : the one that decided
    order, limit_error, tolerance : of that signal, as `SignalVerdict` has them
    signals : all of them; none where no ladder was judged
    unmet : expectations in the scene's file that this method did not meet, in words
    as_shipped : of the engine with all its defaults, which need not simulate the scene
    is_expected_failure : whether it is an expected failure of the scene's file
    """

    key: Key
    verdict: VerdictWord
    reason: str
    signal: Signal = "omega"
    order: float | None = None
    limit_error: float | None = None
    tolerance: float | None = None
    signals: tuple[SignalVerdict, ...] = ()
    unmet: tuple[str, ...] = ()
    as_shipped: bool = False
    is_expected_failure: bool = False

    @property
    def agrees(self) -> bool:
        """Whether a study with this verdict passes."""
        expected = self.as_shipped or self.is_expected_failure
        wrong = self.verdict in ("disagrees", "failed") and not expected
        return not wrong and not self.unmet

    @property
    def is_unproven(self) -> bool:
        """Whether a clean method was neither found to converge nor to be wrong."""
        open_ended = self.verdict in ("unresolved", "diverges")
        return open_ended and not (self.as_shipped or self.is_expected_failure)
