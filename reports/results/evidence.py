"""What a method on a scene is judged by, besides its runs: numbers alone, no sentence.

They can be judged again, and put in other words, without a run.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field, model_validator

from .change_words import KINDS
from .records import Count, MethodKey, Record, Signed, Size

#: The probability that a method that converges is accused by one of the checks of its evidence.
LEVEL = 1e-9
#: Standard error at most of the limit of what steps gain, relative to the largest terms: over ten
#: radians it comes to a hundredth, which a user would see.
CONSISTENT = 1e-3
#: And relative to the weakest effect of the scene: a missing one must be seen.
SEEN = 0.1
#: The quantities that a step gains, in order, the last where parts turn in the body; see
#: `measuring/steps.py`.
Quantity = Literal["attitude", "angular momentum", "velocity", "place", "parts"]
QUANTITIES: tuple[Quantity, ...] = ("attitude", "angular momentum", "velocity", "place", "parts")
#: A vector, SI.
Vector = tuple[Signed, Signed, Signed]
#: How gains depend on the timestep where they are not those of a method that converges.
#:
#: limit : they tend to something else than zero
#: timestep : at one timestep alone they are not those that others predict
#: shorter : with that timestep, and shorter ones, they tend to something else
#: leap : a step changes the state by as much however short it is
#: misread : a state that is set reads back otherwise
FaultKind = Literal["limit", "timestep", "shorter", "leap", "misread"]


@dataclass(frozen=True)
class Explanation:
    """A change of the equations of motion or of reading: one of `KINDS`, and its numbers, SI."""

    kind: str
    numbers: tuple[Signed, ...]

    @model_validator(mode="after")
    def _is_known(self) -> "Explanation":
        if self.kind not in KINDS:
            raise ValueError("must be of a known kind")
        if len(self.numbers) != KINDS[self.kind].count:
            raise ValueError(f"must have {KINDS[self.kind].count} numbers")
        return self

    @property
    def words(self) -> str:
        """What follows "as if"."""
        return KINDS[self.kind].words(self.numbers)


@dataclass(frozen=True)
class StepFault:
    """How single steps are not those of a method that converges.

    Attributes
    ----------
    quantity : the one that shows it best
    time : s, of the state that shows it best; None where ω is along a skew axis at the start
    timestep : s, at which it shows
    got, wanted : what the state gains a second, and should; of `leap` and `misread` how far it is
        off
    changes : explain what all states gain; empty where no change, or two at once, does
    """

    kind: FaultKind
    quantity: Quantity
    time: Size | None
    timestep: Size
    got: Vector
    wanted: Vector
    changes: Annotated[tuple[Explanation, ...], Field(max_length=2)] = ()


@dataclass(frozen=True)
class GainCurve:
    """The gains of the least likely state, relative to the largest terms, for a picture.

    Attributes
    ----------
    timesteps : s, long to short, (J,)
    gains, predicted, predicted_to : sizes of its gains, of what those with longer timesteps
        predict, and the standard deviation of that, (J,)
    largest : the largest gain of any state, (J,)
    """

    quantity: Quantity
    timesteps: tuple[Size, ...]
    gains: tuple[Size, ...]
    predicted: tuple[Size, ...]
    predicted_to: tuple[Size, ...]
    largest: tuple[Size, ...]

    @model_validator(mode="after")
    def _is_a_table(self) -> "GainCurve":
        columns = self.gains, self.predicted, self.predicted_to, self.largest
        if any(len(column) != len(self.timesteps) for column in columns):
            raise ValueError("must have one value a timestep throughout")
        return self


@dataclass(frozen=True)
class StepEvidence:
    """What a method's single steps from known states show.

    Attributes
    ----------
    states : number of states
    tail : the probability of gains as unlikely as these, if the steps are those of a method that
        converges: the smallest tail times the number of tails
    known_to, of_an_effect : the larger of the standard error and the size of the gains' limit,
        relative to the largest terms, and to the weakest effect of the scene
    order, declared : the least order that gains show, and the one that is declared; the latter is
        0 in single precision, where rounding hides it
    curves : one a quantity that is not zero throughout
    settled : steps in which a constraint settled first
    changes_below : s; what shorter steps gain is another function of the timestep, which vanishes
        as well; 0 where it is not
    beyond_from : s; the shortest timestep that is beyond the radius of convergence of what steps
        gain, in some state; 0 if none is
    """

    states: Count
    tail: Size
    known_to: Size
    of_an_effect: Size
    order: Count
    curves: tuple[GainCurve, ...] = ()
    fault: StepFault | None = None
    settled: Count = 0
    changes_below: Size = 0.0
    beyond_from: Size = 0.0
    declared: Count = 0

    @property
    def is_of_low_order(self) -> bool:
        """Whether gains are of half of the declared order, or less."""
        return not self.fault and 0 < 2 * self.order <= self.declared

    @property
    def is_known(self) -> bool:
        """Whether the limit is known well enough for a verdict."""
        return self.known_to <= CONSISTENT and self.of_an_effect <= SEEN


@dataclass(frozen=True)
class ReplayEvidence:
    """What a run does otherwise than its own intervals, each run again from its own start.

    Attributes
    ----------
    timestep : s, of the run
    intervals : number of them
    tail : the probability of differences as large, if a step depends on the state alone
    off : the largest difference, rad or relative to ω, a radian of turn
    since : s; the start of the first interval that differs; None where none does
    spread : how far two runs of one interval differ, likewise; 0 where the engine is deterministic
    order : at which the differences vanish with the timestep; 0 where they do not
    declared : the order of accuracy that is declared
    """

    timestep: Size
    intervals: Count
    tail: Size
    off: Size
    since: Size | None = None
    spread: Size = 0.0
    order: Count = 0
    declared: Count = 1

    @property
    def is_wrong(self) -> bool:
        """Whether differences do not vanish with the timestep, or at too low an order."""
        # What a restart lacks it lacks once: one order less is enough.
        return self.tail < LEVEL or 0 < self.order < self.declared - 1


@dataclass(frozen=True)
class Evidence(Record):
    """What a method on a scene is judged by, besides its rows.

    Attributes
    ----------
    steps : from exact states; None where the method cannot be opened at them
    own_steps : from states of its own runs; None where none were taken
    replays : of its runs
    refusal : why the runs could not be replayed, in the engine's words; else empty
    """

    key: MethodKey
    steps: StepEvidence | None = None
    own_steps: StepEvidence | None = None
    replays: tuple[ReplayEvidence, ...] = ()
    refusal: str = ""
