"""A method's answer when a scene's body is described in another encoding: a part of a run's row."""

from dataclasses import dataclass
from typing import Literal

from ...scenarios import Errors, printable

#: A method's answer to an encoding. same: the motion of the scene's own description, up to
#: round-off; coarser: another motion, with the same limit at short timesteps; other body: the
#: engine holds another body; differs: another motion at any timestep; ends early: the run does;
#: open: not decided; left out: not run.
EncodingWord = Literal["same", "coarser", "other body", "differs", "ends early", "open", "left out"]
#: The words that mean that the answer is wrong.
WRONG: frozenset[EncodingWord] = frozenset({"other body", "differs", "ends early"})


@dataclass(frozen=True)
class Beside:
    """How a run in an encoding compares with the run of the scene's own description.

    Attributes
    ----------
    reason : reason for the word, with the numbers
    apart : distance of the motions, in the norms of errors; None if one did not finish
    moves_as : another method of the engine whose motion of the scene's own body this is, up to
        round-off
    """

    word: EncodingWord
    reason: str = ""
    apart: Errors | None = None
    moves_as: str = ""


#: Sentences for the words, before the reason; for other words there is nothing to say.
PHRASES: dict[EncodingWord, str] = {
    "coarser": "another motion, whose difference goes away with the timestep",
    "other body": "another body is held",
    "differs": "another motion at any timestep",
    "ends early": "the run ends early",
    "open": "another motion; whether the timestep's alone is open",
}
#: Largest length of a reason, characters.
LONGEST = 160


def encoding_sentence(one: Beside) -> str:
    """Return a sentence on what an encoding does to a motion, with the numbers."""
    as_other = f"; it moves as {one.moves_as} does" if one.moves_as else ""
    reason = printable(" ".join(one.reason.split()), LONGEST)
    return f"{PHRASES.get(one.word, one.word)}{': ' * bool(reason)}{reason}{as_other}"
