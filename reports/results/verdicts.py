"""The verdict on a method on a scene: a word, and the numbers that it rests on."""

from dataclasses import dataclass

from .evidence import LEVEL, ReplayEvidence, StepEvidence
from .reasons import ground_in_words, reason_in_words
from .records import Count, MethodKey, Record, Size
from .verdict_words import VERDICT, VerdictWord

#: Properties that JSON and tables show of a verdict besides its fields.
MADE = ("reason", "tail", "level", "order", "ground")


@dataclass(frozen=True)
class Verdict(Record):
    """The verdict on a method on a scene.

    Attributes
    ----------
    quoted : the reason, or a part of it, as a run, the engine or the scene's file states it
    steps : evidence from steps from exact states, without curves; None if there is none
    own_steps : evidence from steps from states of the method's runs; None if there is none
    replays : evidence from replays of the method's runs
    unmet : expectations in the scene's file that this method did not meet, in words
    as_shipped : whether the method is the engine with all its defaults
    expected_failure : whether this is an expected failure, which the scene's file states
    timesteps : the timesteps asked for, s, increasing; empty for the verdict on a ladder
    step_limit : the limit on the steps of a run, if it kept finer rungs from being run; else None
    """

    key: MethodKey
    verdict: VerdictWord
    quoted: str = ""
    steps: StepEvidence | None = None
    own_steps: StepEvidence | None = None
    replays: tuple[ReplayEvidence, ...] = ()
    unmet: tuple[str, ...] = ()
    as_shipped: bool = False
    expected_failure: bool = False
    timesteps: tuple[Size, ...] = ()
    step_limit: Count | None = None

    @property
    def reason(self) -> str:
        """The reason in words, made from the numbers of the evidence."""
        return reason_in_words(self.verdict, self.quoted, self.steps, self.own_steps, self.replays)

    @property
    def ground(self) -> str:
        """How many states and intervals a verdict `converges` rests on, in words; else empty."""
        converges = self.verdict == "converges" and self.steps is not None
        return ground_in_words(self.steps, self.replays) if converges and self.steps else ""

    @property
    def tail(self) -> float | None:
        """The probability of evidence as unlikely as this if the method converges, at most 1.

        It is the smallest tail of steps and replays times the number of these tails (Bonferroni);
        None if there is no evidence.
        """
        found = [one.tail for one in (self.steps, self.own_steps, *self.replays) if one]
        return min(1.0, min(found) * len(found)) if found else None

    @property
    def level(self) -> float:
        """The probability below which a check's tail shows a fault."""
        return LEVEL

    @property
    def order(self) -> int | None:
        """The lower of the orders at which gains of attitude and of I ω vanish with the timestep.

        It is None if no single steps were examined, or if they show a fault.
        """
        return self.steps.order if self.steps and not self.steps.fault else None

    @property
    def agrees(self) -> bool:
        """Whether the verdict does not make a study fail, and no expectation is unmet."""
        return not self._is_wrong and not self.unmet

    @property
    def findings(self) -> list[str]:
        """Sentences: one on the verdict, with its reason, and one on each unmet expectation.

        The verdict comes first if it makes a study fail, else last.
        """
        judged = f"{self.verdict}: {self.reason}"
        return [judged, *self.unmet] if self._is_wrong else [*self.unmet, judged]

    @property
    def _is_wrong(self) -> bool:
        """Whether the verdict makes a study fail.

        Verdicts of some kinds do (`VerdictKind.fails`), unless the method is as shipped or its
        failure is expected.
        """
        return VERDICT[self.verdict].fails and not (self.as_shipped or self.expected_failure)

    @property
    def is_unproven(self) -> bool:
        """Whether the verdict says neither that the method converges nor that it is wrong.

        It is false for methods as shipped and for expected failures.
        """
        expected = self.as_shipped or self.expected_failure
        return VERDICT[self.verdict].is_unproven and not expected
