"""The words of verdicts: what each means, how it is displayed, and its effect on an exit code.

Everything that ranks, counts, colours or explains verdicts iterates over `VERDICTS`. To add a word,
add it there and to `VerdictWord`, besides the code that decides on it.
"""

from dataclasses import dataclass
from typing import Literal, get_args

VerdictWord = Literal["converges", "unresolved", "unsupported", "diverges", "disagrees", "failed"]


@dataclass(frozen=True)
class VerdictKind:
    """A kind of verdict: its word, and all that depends on the word.

    Attributes
    ----------
    sign : sign beside the word, so that verdicts differ not only in colour
    phrases : verb phrase for one method on one scene, and for several
    meaning : when the verdict is given, in words
    light, dark : colours of background and text, on light and on dark pages. Each such pair has a
        contrast ratio of 4.5 or more, and the backgrounds of the words differ in lightness too
    fails : whether it makes a study fail
    is_unproven : whether it says neither that a method converges nor that it is wrong
    """

    word: VerdictWord
    sign: str
    phrases: tuple[str, str]
    meaning: str
    light: tuple[str, str]
    dark: tuple[str, str]
    fails: bool = False
    is_unproven: bool = False

    @property
    def needs_reason(self) -> bool:
        """Whether lists show the verdict's reason, as something is wrong or undecided."""
        return self.fails or self.is_unproven


#: The kinds, from good to bad.
VERDICTS = (
    VerdictKind(
        "converges",
        sign="✓",
        phrases=("converges to the exact motion", "converge to the exact motion"),
        meaning="single steps are consistent with the equations of motion, and depend on the state "
        "alone: runs tend to the exact motion as dt → 0",
        light=("#cdeee4", "#07493a"),
        dark=("#12453a", "#b9f2e0"),
    ),
    VerdictKind(
        "unresolved",
        sign="?",
        phrases=("is unresolved", "are unresolved"),
        meaning="noise hides what steps tend to, or no step could be taken from given states; the "
        "reason says which",
        light=("#fbf0b4", "#4f4000"),
        dark=("#4b4212", "#fbeeb0"),
        is_unproven=True,
    ),
    VerdictKind(
        "unsupported",
        sign="–",
        phrases=("cannot be simulated", "cannot be simulated"),
        meaning="the engine cannot simulate one of the scene's effects, or its precision does not "
        "hold the body",
        light=("#eceef1", "#4a525c"),
        dark=("#262b31", "#aab3bd"),
    ),
    VerdictKind(
        "diverges",
        sign="↗",
        phrases=("blows up", "blow up"),
        meaning="the finest run still blew up: it has a number that is not finite, a reset, a "
        "clamp, or an energy far beyond its scale",
        light=("#f8c99c", "#5a2800"),
        dark=("#6b3a10", "#ffdcb8"),
        is_unproven=True,
    ),
    VerdictKind(
        "disagrees",
        sign="✗",
        phrases=("settles on a wrong motion", "settle on a wrong motion"),
        meaning="its steps are not those of the equations of motion, or depend on more than the "
        "state: no smaller timestep mends it",
        light=("#b0261c", "#ffffff"),
        dark=("#c8372c", "#ffffff"),
        fails=True,
    ),
    VerdictKind(
        "failed",
        sign="!",
        phrases=("failed", "failed"),
        meaning="the engine crashed, hung, did not read back what was set, or simulated what the "
        "scene does not call for",
        light=("#5a2a75", "#ffffff"),
        dark=("#7c45a0", "#ffffff"),
        fails=True,
    ),
)
#: The kinds by their words, and the ranks of the words: a higher rank is worse.
VERDICT = {kind.word: kind for kind in VERDICTS}
RANKS = {kind.word: rank for rank, kind in enumerate(VERDICTS)}
assert tuple(VERDICT) == get_args(VerdictWord), "one entry a word, in one order"
#: The kinds in the order in which verdicts are counted and listed: `converges` first, then the
#: others from the worst on.
LISTED = (VERDICTS[0], *reversed(VERDICTS[1:]))
UNPROVEN = " or ".join(f"'{kind.word}'" for kind in VERDICTS if kind.is_unproven)
