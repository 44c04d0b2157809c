"""The evidence that a method on a scene is judged by, besides its runs: numbers, no sentences.

The numbers can be judged again, and put in other words, without a run.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field, model_validator

from .change_words import KINDS
from .records import Count, MethodKey, Record, Signed, Size

#: Probability with which any one check wrongly accuses a method that converges.
LEVEL = 1e-9
#: Largest standard error of the limit of what steps gain, relative to the largest terms: over ten
#: radians an error of this size comes to a hundredth, which a user would see.
CONSISTENT = 1e-3
#: Largest standard error of that limit, relative to the weakest effect of the scene: a missing
#: effect must be seen.
SEEN = 0.1
#: The quantities whose gain in a step is judged, in order; the last one only if parts turn in the
#: body. See `measuring/steps.py`.
Quantity = Literal["attitude", "angular momentum", "velocity", "place", "parts"]
QUANTITIES: tuple[Quantity, ...] = ("attitude", "angular momentum", "velocity", "place", "parts")
#: A vector, SI units.
Vector = tuple[Signed, Signed, Signed]
#: Ways in which steps differ from those of a method that converges.
#:
#: limit : as the timestep shrinks, gains tend to something else than zero
#: timestep : at one timestep gains are not those that the other timesteps predict
#: shorter : from one timestep down gains tend to something else
#: leap : a step changes the state by as much however short it is
#: misread : a state reads back differently from how it was set, before any step
#: random : gains differ when the same step is taken again
FaultKind = Literal["limit", "timestep", "shorter", "leap", "misread", "random"]


@dataclass(frozen=True)
class Explanation:
    """A change of the equations of motion or of reading: one of `KINDS`, and its numbers, SI."""

    kind: str
    numbers: tuple[Signed, ...]

    @model_validator(mode="after")
    def _is_known(self) -> "Explanation":
        """Return the change; raise ValueError unless its kind is known and has as many numbers."""
        if self.kind not in KINDS:
            raise ValueError("must be of a known kind")
        if len(self.numbers) != KINDS[self.kind].count:
            raise ValueError(f"must have {KINDS[self.kind].count} numbers")
        return self

    @property
    def words(self) -> str:
        """The change in words, which complete a sentence that begins "behaves as if"."""
        return KINDS[self.kind].words(self.numbers)


@dataclass(frozen=True)
class StepFault:
    """A difference of an engine's single steps from those of a method that converges.

    Attributes
    ----------
    kind : how the steps differ, see `FaultKind`
    quantity : the quantity that shows the difference best
    time : time of the state that shows it best, s; None if that is the start with ω along a skew
        axis
    timestep : timestep at which it shows, s
    got, wanted : the rate at which the quantity changes, and the rate at which it should; for
        `leap` and `misread` how far the state is off, for `random` by how much the rate differs
        when the same step is taken again
    changes : changes that explain the gains of all states; empty if no single change and no two do
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
    """The gains of one quantity at J timesteps, for a figure.

    They are relative to the largest terms of the equations of motion. The state from which the
    steps are taken is the one whose gains are the least likely, except for `largest`.

    Attributes
    ----------
    timesteps : s, long to short, (J,)
    gains : sizes of the gains, (J,)
    predicted, predicted_to : sizes of the gains predicted from longer timesteps, and the standard
        deviation of the prediction, (J,)
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
        """Return the curve; raise ValueError unless all columns are of one length."""
        columns = self.gains, self.predicted, self.predicted_to, self.largest
        if any(len(column) != len(self.timesteps) for column in columns):
            raise ValueError("must have one value a timestep throughout")
        return self


def is_known(known_to: float, of_an_effect: float) -> bool:
    """Whether the limit of gains is known well enough for a verdict.

    Parameters
    ----------
    known_to, of_an_effect : the limit's standard error, or its size if that is larger, relative to
        the largest terms, and to the weakest effect of the scene
    """
    return known_to <= CONSISTENT and of_an_effect <= SEEN


@dataclass(frozen=True)
class StepEvidence:
    """Evidence from a method's single steps from known states.

    Attributes
    ----------
    states : number of states
    tail : the probability of gains as unlikely as these, if the steps are those of a method that
        converges: the smallest tail times the number of tails (Bonferroni)
    known_to, of_an_effect : the standard error of the gains' limit, or its size if that is larger,
        relative to the largest terms, and to the weakest effect of the scene
    order, declared : the least order that gains show, and the declared order, which is 0 in single
        precision, where rounding hides it
    curves : one for each quantity that is not zero throughout
    fault : how the steps differ from those of a method that converges; None if they do not
    settled : number of steps taken before those examined, in which a constraint settled
    changes_below : timestep below which gains are another function of the timestep, which vanishes
        as well, s; 0 if there is none
    beyond_from : the shortest timestep beyond the radius of convergence of the gains' series in
        some state, s; 0 if none is
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
        """Whether gains vanish with the timestep, but at half of the declared order or less."""
        return not self.fault and 0 < 2 * self.order <= self.declared

    @property
    def is_known(self) -> bool:
        """Whether the limit of the gains is known well enough for a verdict."""
        return is_known(self.known_to, self.of_an_effect)


@dataclass(frozen=True)
class ReplayEvidence:
    """Evidence from a run's intervals, each run again from its own start and compared with the run.

    Attributes
    ----------
    timestep : timestep of the run, s
    intervals : number of intervals
    tail : the probability of differences as large as these, if a step depends only on the state
    off : the largest difference for each radian turned, rad or relative to ω
    since : start of the first interval that differs, s; None if none does
    spread : difference of two runs of one interval, in the unit of `off`; 0 if the engine is
        deterministic
    order : order at which the differences vanish with the timestep; 0 if they do not
    declared : the declared order of accuracy
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
        """Whether replays and run differ by more than noise, and not by a harmless memory.

        A memory is harmless if what it changes vanishes with the timestep at a sufficient order.
        """
        # What a restart lacks is lacking once, not in every step: one order less is enough.
        return self.tail < LEVEL or 0 < self.order < self.declared - 1


@dataclass(frozen=True)
class Evidence(Record):
    """The evidence that a method on a scene is judged by, besides its runs.

    Attributes
    ----------
    steps : evidence from steps from exact states; None if the method cannot be opened there
    own_steps : evidence from steps from states of its own runs; None if none were taken
    replays : evidence from replays of its runs, one for each run that was replayed
    refusal : why the runs could not be replayed, in the engine's words; else empty
    """

    key: MethodKey
    steps: StepEvidence | None = None
    own_steps: StepEvidence | None = None
    replays: tuple[ReplayEvidence, ...] = ()
    refusal: str = ""
