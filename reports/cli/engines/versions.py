"""What the command `versions` does: the changes from one version of an engine to the next."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from ...pages.analysis.changes import Change, changes
from ...results.store import Results

#: The default scenes: a free body, a heavy top, and one whose spin decays.
SCENES = ("tennis-racket", "fast-top", "book-with-drag")


def changes_between_versions(results: Results, names: Sequence[str]) -> list[Change]:
    """All changes between neighbours; the engine of a change is such as "mujoco@3.3.0 → 4.0.0".

    Parameters
    ----------
    names : engine@version, oldest first
    """
    return [
        change
        for older, newer in pairwise(names)
        for change in _changes(results, older, newer, f"{older} → {newer.partition('@')[2]}")
    ]


def _changes(results: Results, older: str, newer: str, name: str) -> list[Change]:
    return changes(*(_alone(results, engine, name) for engine in (older, newer)))


def _alone(results: Results, engine: str, name: str) -> Results:
    """The results of one engine, under a name that is shared with what they are compared with."""
    rows = [row for row in results.rows if row.key.engine == engine]
    verdicts = [verdict for verdict in results.verdicts if verdict.key.engine == engine]
    return replace(
        results,
        rows=[replace(row, key=replace(row.key, engine=name)) for row in rows],
        verdicts=[replace(one, key=replace(one.key, engine=name)) for one in verdicts],
    )
