"""The option `--as`, the list of encodings, and what they print."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from ....engines import engines
from ....engines.encodings import ENCODINGS
from ....scenarios import did_you_mean
from ...results.encoding_records import PHRASES, WRONG, EncodedRun, EncodedRuns, encoding_sentence
from ..terminal import Complaint

#: The word for all of them.
ALL = "all"
PLAIN = "plain"


def named_encodings(text: str) -> tuple[str, ...]:
    """The encodings of `--as`, names with commas between, or `all`; none of an empty text."""
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
    """A row for each encoding: its name, what it changes, which engines can be given it."""
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


def encoding_lines(encodings: Sequence[EncodedRuns]) -> Iterator[str]:
    """What differs, by scene, engine and encoding; and how many are the same."""
    by_scene = groupby(encodings, key=lambda runs: (runs.key.scenario, runs.timestep))
    for (scene, timestep), group in by_scene:
        of_scene = list(group)
        alike = sum(one.word == "same" for runs in of_scene for one in runs.each)
        compared = sum(one.word != "left out" for runs in of_scene for one in runs.each)
        wrong = sum(one.word in WRONG for runs in of_scene for one in runs.each)
        yield (
            f"{scene}, its body described otherwise, at {timestep:.3g} s: "
            f"{alike} of {compared} runs are the same to round-off, {wrong} wrong"
        )
        if wrong:
            yield "  Describe the body as the scene does, or take a method that is not wrong below."
        for runs in of_scene:
            if runs.plain:
                yield f"  {runs.key.label}: not compared, the scene as it is {runs.plain}"
        yield from (f"  {line}" for line in _lines(of_scene))


def _lines(of_scene: Sequence[EncodedRuns]) -> Iterator[str]:
    """One line for each engine, encoding and word, with the numbers of the method furthest off.

    What is wrong comes first; last, a line for each reason that encodings are left out for.
    """
    alike: dict[tuple[str, str, str, str], list[tuple[str, EncodedRun]]] = {}
    for runs in of_scene:
        for one in runs.each:
            if one.word in PHRASES:
                what = (runs.key.engine, one.encoding, one.word, one.moves_as)
                alike.setdefault(what, []).append((runs.key.method, one))
    for (engine, encoding, *_), made in sorted(
        alike.items(), key=lambda one: one[0][2] not in WRONG
    ):
        methods = ", ".join(method for method, _ in made)
        method, furthest = max(made, key=lambda one: _distance(one[1]))
        most = f"; most with {method}" if len({one.reason for _, one in made}) > 1 else ""
        yield f"{engine} {methods}, {encoding}: {encoding_sentence(furthest)}{most}"
    left_out: dict[str, dict[str, None]] = {}
    for runs in of_scene:
        for one in runs.each:
            if one.word == "left out":
                left_out.setdefault(one.reason, {})[one.encoding] = None
    for reason, names in left_out.items():
        yield f"left out: {', '.join(names)}: {reason}"


def _distance(one: EncodedRun) -> float:
    """The largest distance of a run from that of the scene as it is, of all signals."""
    return max(error for _, error in one.apart) if one.apart else float("inf")


def are_alike(encodings: Sequence[EncodedRuns]) -> bool:
    """Whether no encoding is wrong."""
    return not any(one.word in WRONG for runs in encodings for one in runs.each)
