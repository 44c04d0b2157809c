"""The option `--as`: which encodings it names, and what is printed about them."""

from collections.abc import Iterator, Sequence

from ....engines import Engine, engines
from ....engines.encodings import ENCODINGS, EncodedEngine
from ....scenarios import EFFECTS, Scenario, did_you_mean
from ..terminal import Complaint, say

#: Name for all encodings.
ALL = "all"


def named_encodings(text: str) -> tuple[str, ...]:
    """Return the names of the encodings that the value of `--as` names, each once.

    A `Complaint` is raised for a name that no encoding has.

    Parameters
    ----------
    text : names with commas between, or `all`, in upper or lower case; empty for no encodings
    """
    names = [part.strip().lower() for part in text.split(",") if part.strip()]
    if ALL in names:
        return tuple(ENCODINGS)
    for name in names:
        if name not in ENCODINGS:
            raise Complaint(
                f"'--as' must be {ALL} or out of {', '.join(ENCODINGS)}, got '{name}'"
                f"{did_you_mean(name, ENCODINGS)}; 'spincheck engines --encodings' explains them"
            )
    return tuple(dict.fromkeys(names))


def encoded(
    chosen: Sequence[Engine], names: Sequence[str], scenarios: Sequence[Scenario]
) -> Iterator[Engine]:
    """Yield each engine in each encoding that applies to any of the scenes.

    If an encoding applies to none, a message says why it does not apply to the first scene. There
    is no message about an engine that loads users' files.

    Parameters
    ----------
    chosen : the engines
    names : names of encodings
    scenarios : the scenes, at least one
    """
    left_out: dict[str, list[str]] = {}
    for engine in (EncodedEngine(base, name) for base in chosen for name in names):
        if any(map(engine.applies_to, scenarios)):
            yield engine
        elif not engine.base.of_file:
            left_out.setdefault(engine.why_not(scenarios[0]), []).append(engine.name)
    for reason, without in left_out.items():
        say(f"Left out: {', '.join(without)}: {reason}.")


def encoding_rows() -> list[dict[str, str]]:
    """Return a table row for each encoding, by the headings of the columns.

    It has the encoding's name, what it changes, and the scenes and the engines that it applies to.
    """
    rows = []
    for name, encoding in ENCODINGS.items():
        needed = encoding.description.features
        able = [e.name for e in engines().values() if needed and needed <= e.describes]
        kept = "free bodies" if encoding.needs_free else "all"
        if beyond := EFFECTS.keys() - encoding.effects:
            kept += f", without {', '.join(sorted(beyond))}"
        who = ", ".join(able) if needed else "all"
        rows.append({"name": name, "changes": encoding.summary, "scenes": kept, "engines": who})
    return rows
