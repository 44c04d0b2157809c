"""The option `--as`: which encodings it names, and what is printed of them."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from ....engines import engines
from ....engines.encodings import ENCODINGS
from ....scenarios import did_you_mean
from ...results.encoding_records import PHRASES, WRONG, Beside, encoding_sentence
from ...results.records import Row
from ..terminal import Complaint

#: Name for all encodings.
ALL = "all"
PLAIN = "plain"


def named_encodings(text: str) -> tuple[str, ...]:
    """Return the encodings of `--as`, names separated by commas, or `all`; none if empty."""
    known = [name for name in ENCODINGS if name != PLAIN]
    names = [part.strip().lower() for part in text.split(",") if part.strip()]
    if ALL in names:
        return tuple(known)
    for name in names:
        if name not in known:
            raise Complaint(
                f"'--as' must be {ALL} or out of {', '.join(known)}, got '{name}'"
                f"{did_you_mean(name, known)}; 'spincheck engines --encodings' explains them"
            )
    return tuple(dict.fromkeys(names))


def encoding_rows() -> list[dict[str, str]]:
    """Return a row for each encoding: its name, what it changes, which engines can be given it."""
    installed = engines().values()
    rows = []
    for name, encoding in ENCODINGS.items():
        needed = encoding.description.features
        able = [e.name for e in installed if needed and needed <= e.describes]
        kept = "free bodies" if encoding.needs_free else "all"
        if beyond := ENCODINGS[PLAIN].effects - encoding.effects:
            kept += f", without {', '.join(sorted(beyond))}"
        who = ", ".join(able) if needed else "all"
        rows.append({"name": name, "changes": encoding.summary, "scenes": kept, "engines": who})
    return rows


def encoding_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the differences, by scene, engine and encoding, and how many are the same."""
    by_scene = groupby(rows, key=lambda row: (row.key.scenario, row.timestep))
    for (scene, timestep), group in by_scene:
        answers = [(row, row.beside) for row in group if row.beside]
        words = [beside.word for _, beside in answers if beside.word != "left out"]
        wrong = sum(word in WRONG for word in words)
        yield (
            f"{scene}, its body described otherwise, at {timestep:.3g} s: "
            f"{words.count('same')} of {len(words)} runs are the same to round-off, {wrong} wrong"
        )
        if wrong:
            yield "  Describe the body as the scene does, or take a method that is not wrong below."
        yield from (f"  {line}" for line in _lines(answers))


def _lines(answers: Sequence[tuple[Row, Beside]]) -> Iterator[str]:
    """Yield a line for each engine, encoding and word, with the numbers of the method furthest off.

    Wrong answers come first; at the end there is a line for each reason why encodings are left out.
    """
    alike: dict[tuple[str, str, str, str], list[tuple[str, Beside]]] = {}
    left_out: dict[str, dict[str, None]] = {}
    for row, one in answers:
        if one.word in PHRASES:
            what = (row.key.engine, row.encoding, one.word, one.moves_as)
            alike.setdefault(what, []).append((row.key.method, one))
        elif one.word == "left out":
            left_out.setdefault(one.reason, {})[row.encoding] = None
    for (engine, encoding, *_), made in sorted(
        alike.items(), key=lambda one: one[0][2] not in WRONG
    ):
        methods = ", ".join(method for method, _ in made)
        method, furthest = max(made, key=lambda one: _distance(one[1]))
        most = f"; most with {method}" if len({one.reason for _, one in made}) > 1 else ""
        yield f"{engine} {methods}, {encoding}: {encoding_sentence(furthest)}{most}"
    for reason, names in left_out.items():
        yield f"left out: {', '.join(names)}: {reason}"


def _distance(one: Beside) -> float:
    """Return the largest distance of a run from that of the unchanged scene, over all signals."""
    return max(error for _, error in one.apart) if one.apart else float("inf")


def are_alike(rows: Sequence[Row]) -> bool:
    """Return whether no encoding is answered wrongly."""
    return not any(row.beside.word in WRONG for row in rows if row.beside)
