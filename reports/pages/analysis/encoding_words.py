"""What encodings do to a motion, in words."""

from ....scenarios import printable
from ...results.encoding_records import EncodedRun, EncodingWord

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


def encoding_sentence(one: EncodedRun) -> str:
    """What an encoding does to a motion, with the numbers."""
    as_other = f"; it moves as {one.moves_as} does" if one.moves_as else ""
    reason = printable(" ".join(one.reason.split()), LONGEST)
    return f"{PHRASES.get(one.word, one.word)}{': ' * bool(reason)}{reason}{as_other}"
