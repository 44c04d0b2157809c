"""How a method answers when a scene's body is described otherwise: a part of a run's row."""

from dataclasses import dataclass
from typing import Literal

from ...scenarios import Errors, printable

#: What a method does with an encoding: the same motion as with the scene's own description, to
#: round-off; another one, which goes to the same limit with the timestep; it holds another body;
#: another motion at any timestep; a run that ends early; what cannot be told, and is not run.
EncodingWord = Literal["same", "coarser", "other body", "differs", "ends early", "open", "left out"]
#: Those that are wrong.
WRONG: frozenset[EncodingWord] = frozenset({"other body", "differs", "ends early"})


@dataclass(frozen=True)
class Beside:
    """How a run of an encoding is beside that with the scene's own description.

    Attributes
    ----------
    reason : of the word, with the numbers
    apart : how far the motions are apart, in the norms of errors; None if one did not finish
    moves_as : another method of the engine that moves the scene's own body so, to round-off
    """

    word: EncodingWord
    reason: str = ""
    apart: Errors | None = None
    moves_as: str = ""


#: What is said of each word before its reason; of those that are not here there is nothing to say.
PHRASES: dict[EncodingWord, str] = {
    "coarser": "another motion, whose difference goes away with the timestep",
    "other body": "another body is held",
    "differs": "another motion at any timestep",
    "ends early": "the run ends early",
    "open": "another motion; whether the timestep's alone is open",
}
#: Characters of a reason.
LONGEST = 160


def encoding_sentence(one: Beside) -> str:
    """What an encoding does to a motion, with the numbers."""
    as_other = f"; it moves as {one.moves_as} does" if one.moves_as else ""
    reason = printable(" ".join(one.reason.split()), LONGEST)
    return f"{PHRASES.get(one.word, one.word)}{': ' * bool(reason)}{reason}{as_other}"
