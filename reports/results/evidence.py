"""The evidence that a method on a scene is judged by, besides its runs: numbers, no sentences.

So it can be judged again, or put in other words, without another run.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...engines import Cause
from ...engines.fault import ENVIRONMENTAL, WRONG_AT_ANY_TIMESTEP
from .change_words import KINDS
from .records import Count, MethodKey, Record, Signed, Size

#: Probability with which one check finds a fault in a method that converges.
LEVEL = 1e-9
#: Largest standard error of the gains' limit with which a verdict is possible, relative to the
#: largest terms of the equations of motion: while the body turns by ten radians, an error of this
#: size adds up to 0.01 rad, which a user would see.
CONSISTENT = 1e-3
#: Largest standard error of that limit, relative to the weakest effect of the scene: it must be
#: small enough to show that an effect is missing.
SEEN = 0.1
#: Causes for which an examination ends that are faults of the engine or its adapter. With other
#: causes the engine refuses the states that it is set to, or the machine is to blame.
FAILURES: frozenset[Cause] = (WRONG_AT_ANY_TIMESTEP - ENVIRONMENTAL) | {"bug"}
#: The quantities whose gains are judged, in order. The last, the angular momentum of parts that
#: turn in the body, is judged only if there are such parts (`measuring/steps.py`).
Quantity = Literal["attitude", "angular momentum", "velocity", "place", "parts"]
QUANTITIES: tuple[Quantity, ...] = ("attitude", "angular momentum", "velocity", "place", "parts")
#: A vector, SI units.
Vector = tuple[Signed, Signed, Signed]
#: Ways in which steps differ from those of a method that converges.
#:
#: limit : as the timestep vanishes, gains do not tend to zero
#: timestep : at one timestep gains are not those that the other timesteps predict
#: shorter : below some timestep, gains no longer tend to zero
#: leap : the error of a step stays as large however short the step is
#: misread : a state reads back differently from how it was set, before any step
#: random : gains differ when the same step is taken again
FaultKind = Literal["limit", "timestep", "shorter", "leap", "misread", "random"]


@dataclass(frozen=True)
class Explanation:
    """A change of the equations of motion, or of how states are read, that explains a fault.

    Attributes
    ----------
    kind : the kind of change, one of `KINDS`
    numbers : the numbers that a change of this kind has, SI
    """

    kind: str
    numbers: tuple[Signed, ...]

    @model_validator(mode="after")
    def _is_known(self) -> "Explanation":
        """Return the change; raise ValueError if its kind or the count of numbers is wrong."""
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
    time : time of the exact state that shows it best, s; None if this is the start with ω turned to
        an axis that is no principal axis
    timestep : timestep at which the difference shows, s; 0 for `misread`
    got, wanted : the rate at which the quantity changes, and the rate at which it should change.
        For three kinds `wanted` is zero, and `got` is a difference: for `leap` how far the quantity
        is off after a step; for `misread` how far ω is off, relative, the attitude, rad, and the
        spins, relative; for `random` how much the rates of two equal steps differ
    changes : one or two changes that explain the gains of all states; empty if none are found
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

    All norms are relative to the largest terms of the equations of motion. Except for `largest`,
    they are of the gains from one state: the one whose gains are the least probable for a method
    that converges.

    Attributes
    ----------
    timesteps : s, long to short, (J,)
    gains : norms of the gains, (J,)
    predicted, predicted_to : norms of the gains that longer timesteps predict, and the standard
        deviations of the predictions, (J,)
    largest : the largest norm of the gains of all states, (J,)
    """

    quantity: Quantity
    timesteps: tuple[Size, ...]
    gains: tuple[Size, ...]
    predicted: tuple[Size, ...]
    predicted_to: tuple[Size, ...]
    largest: tuple[Size, ...]

    @model_validator(mode="after")
    def _is_a_table(self) -> "GainCurve":
        """Return the curve; raise ValueError unless there is one value for each timestep."""
        columns = self.gains, self.predicted, self.predicted_to, self.largest
        if any(len(column) != len(self.timesteps) for column in columns):
            raise ValueError("must have one value a timestep throughout")
        return self


def is_known(known_to: float, of_an_effect: float) -> bool:
    """Whether the limit of gains is known well enough for a verdict.

    Parameters
    ----------
    known_to : the limit's standard error, or its size if that is larger, relative to the largest
        terms of the equations of motion
    of_an_effect : that error or size, relative to the weakest effect of the scene
    """
    return known_to <= CONSISTENT and of_an_effect <= SEEN


@dataclass(frozen=True)
class StepEvidence:
    """Evidence from a method's single steps from known states.

    Attributes
    ----------
    states : number of states from which steps were taken
    tail : the probability of gains as unlikely as these, if the steps are those of a method that
        converges: the smallest tail times the number of tails (Bonferroni)
    known_to : the standard error of the gains' limit, or the limit's size if that is larger,
        relative to the largest terms of the equations of motion
    of_an_effect : that error or size, relative to the weakest effect of the scene
    order : the lower of the orders at which the gains of attitude and of I ω vanish with the
        timestep; `declared` if both are hidden by noise
    declared : the declared order; 0 in single precision, where rounding hides it
    curves : one for each quantity whose gains are not all zero
    fault : how the steps differ from those of a method that converges; None if they do not
    settled : number of steps taken before each examined step, so that a constraint settles
    changes_below : timestep below which gains are another function of the timestep, which also
        vanishes, s; 0 if there is none
    beyond_from : the shortest timestep that is beyond the radius of convergence of the gains'
        series in any state, s; 0 if none is
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
    """Evidence from the replays of one run: differences between its intervals and their replays.

    Attributes
    ----------
    timestep : timestep of the run, s
    intervals : number of intervals that were replayed
    tail : the probability of differences as large as these, if a step depends only on the state
    off : norm of the differences, attitude in rad and all else relative, divided by the angle that
        the body turns in the interval, rad; of the interval with the least probable differences
    since : start of the first interval that differs, s; None if none does
    spread : difference of two replays of one interval, in the unit of `off`; 0 if the engine is
        deterministic
    order : order at which the differences vanish with the timestep; 0 if they do not vanish
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
        """Whether replays and run differ by more than noise or a harmless memory explain.

        A memory is harmless if what it changes vanishes with the timestep at the declared order, or
        at one order less.
        """
        # A restart forgets once, and not in every step, so that one order less is sufficient.
        return self.tail < LEVEL or 0 < self.order < self.declared - 1


@dataclass(frozen=True)
class Evidence(Record):
    """The evidence that a method on a scene is judged by, besides its runs.

    Attributes
    ----------
    steps : evidence from steps from exact states; None if none could be taken
    own_steps : evidence from steps from states of the method's runs; None if none were taken
    replays : evidence from replays, one for each run that was replayed
    refusal : why steps could not be examined or runs not replayed, in words; else empty
    cause : the same in one word; empty if `refusal` is
    """

    key: MethodKey
    steps: StepEvidence | None = None
    own_steps: StepEvidence | None = None
    replays: tuple[ReplayEvidence, ...] = ()
    refusal: str = ""
    cause: Cause = ""

    @property
    def is_of_failure(self) -> bool:
        """Whether the engine or its adapter failed when its steps or runs were examined."""
        return self.cause in FAILURES
