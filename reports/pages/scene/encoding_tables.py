"""Tables, on a scene's page, of its body described otherwise."""

import math

from ....scenarios import Errors
from ...results.encoding_records import EncodedRuns
from ..analysis.encoding_words import PHRASES, encoding_sentence
from ..analysis.report_data import SceneRuns
from ..analysis.wording import NOTHING, duration
from ..tables import Captioned, Cell, Table, figure, table


def encoding_tables(scene: SceneRuns) -> list[Captioned]:
    """One table for each engine and timestep that encodings were run with."""
    by_engine: dict[tuple[str, str, float], list[EncodedRuns]] = {}
    for runs in scene.encodings:
        by_engine.setdefault((runs.key.engine, runs.engine_version, runs.timestep), []).append(runs)
    return [
        Captioned(f"{engine}, at {duration(timestep)}", _sentence(made), _table(made))
        for (engine, _, timestep), made in by_engine.items()
    ]


def _sentence(made: list[EncodedRuns]) -> str:
    words = [one.word for runs in made for one in runs.each if one.word != "left out"]
    missing = [f"{runs.key.method} ({runs.plain})" for runs in made if runs.plain]
    text = f"{words.count('same')} of {len(words)} runs are the same to round-off."
    return f"{text} Not compared: {'; '.join(missing)}." if missing else text


def _table(made: list[EncodedRuns]) -> Table:
    rows = [
        [
            Cell(one.encoding, "name"),
            Cell(runs.key.method),
            *_errors(one.apart),
            *_errors(one.errors),
            Cell(encoding_sentence(one)),
        ]
        for runs in made
        for one in runs.each
        if one.word in PHRASES
    ]
    headings = [
        f"{signal} {which}"
        for which in ("from the scene's own description", "from the exact motion")
        for signal in ("ω, relative,", "attitude, °,")
    ]
    return table(("described as", "method", *headings, "what it does"), rows)


def _errors(errors: Errors | None) -> list[Cell]:
    if errors is None:
        return [figure(NOTHING), figure(NOTHING)]
    return [figure(f"{errors.omega:.1e}"), figure(f"{math.degrees(errors.attitude):.2g}")]
