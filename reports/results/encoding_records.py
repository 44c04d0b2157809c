"""How a method answers when a scene's body is described otherwise."""

from dataclasses import dataclass
from typing import Literal

from ...scenarios import Errors
from .records import MethodKey, Record

#: What a method does with an encoding: the same motion as with the scene's own description, to
#: round-off; another one, which goes to the same limit with the timestep; it holds another body;
#: another motion at any timestep; a run that ends early; what cannot be told, and is not run.
EncodingWord = Literal["same", "coarser", "other body", "differs", "ends early", "open", "left out"]
#: Those that are wrong.
WRONG: frozenset[EncodingWord] = frozenset({"other body", "differs", "ends early"})


@dataclass(frozen=True)
class EncodedRun:
    """A run of a method with one encoding, beside that with the scene's own description.

    Attributes
    ----------
    reason : of the word, with the numbers
    errors : from the exact motion; None if the run did not finish
    apart : from the run of the scene as it is, in the same norms; None likewise
    moves_as : another method of the engine that moves the scene's own body so, to round-off
    """

    encoding: str
    word: EncodingWord
    reason: str = ""
    errors: Errors | None = None
    apart: Errors | None = None
    moves_as: str = ""


@dataclass(frozen=True)
class EncodedRuns(Record):
    """A method on a scene in several encodings, at one timestep.

    Attributes
    ----------
    timestep : s
    plain : why the scene as it is gives nothing to compare with; empty if it does
    """

    key: MethodKey
    engine_version: str
    timestep: float
    each: tuple[EncodedRun, ...]
    plain: str = ""
