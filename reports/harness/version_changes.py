"""Compares versions of an engine: motions, errors, verdicts, speed.

A newer version is worse if a run no longer comes to its end, the verdict on a method is of a higher
rank, an error at the timestep asked for grew by a fifth or more, or a step takes longer by a fifth
or more in every round of timing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...engines import Engine, Method
from ...scenarios import SIGNAL, Scenario, errors_between
from ..results.verdict_words import RANKS, VerdictWord
from .executors import Executor
from .version_runs import SolvedScene, VersionRun, solved, version_runs

#: The default scenes: a free body, a heavy top, and one whose spin decays.
SCENES = ("tennis-racket", "fast-top", "book-with-drag")
EPS = float(np.finfo(float).eps)
#: Roundings a step by which two compilations of the same formulas may differ.
ROUNDINGS = 16
#: An error or a time counts as changed from this factor on: the noise of times is smaller.
NOTABLE = 1.2


@dataclass(frozen=True)
class VersionChange:
    """A method on a scene, in two versions.

    Attributes
    ----------
    outcomes, verdicts : of the older and the newer
    equal : "to the last bit" or "to round-off" if the two motions are equal; else empty
    errors : by signal, of the older and the newer, where they changed notably
    ratio : time a step of the newer over that of the older, median of rounds; None if not timed
    is_worse : whether the newer is
    what : all changes in words; empty if nothing changed
    is_round_off : whether nothing changed but round-off
    """

    scenario: str
    method: str
    older: str
    newer: str
    outcomes: tuple[str, str]
    verdicts: tuple[VerdictWord, VerdictWord]
    equal: str
    errors: dict[str, tuple[float, float]]
    ratio: float | None
    is_worse: bool
    what: str
    is_round_off: bool

    def __str__(self) -> str:
        worse = "  WORSE" if self.is_worse else ""
        return f"{self.scenario}, {self.method}, {self.older} → {self.newer}: {self.what}{worse}"


@dataclass(frozen=True, eq=False)
class OverVersions:
    """A method on a scene in all versions, and the changes between neighbouring versions."""

    scenario: str
    method: str
    runs: list[VersionRun]
    changes: list[VersionChange]


def over_versions(
    engines: Sequence[Engine], scenes: Sequence[Scenario], timestep: float, executor: Executor
) -> Iterator[OverVersions]:
    """Compare neighbours among versions, oldest first, scene by scene and method by method.

    Parameters
    ----------
    timestep : s, of the runs that are compared; verdicts are of ladders of their own
    """
    for scenario in scenes:
        scene = solved(scenario, timestep)
        for method in engines[-1].methods:
            if not engines[-1].unsupported(scenario, method):
                runs = version_runs(engines, method, scene, executor)
                changes = [_change(scene, method, *pair) for pair in pairwise(runs)]
                yield OverVersions(scenario.name, method.name, runs, changes)


def _change(
    scene: SolvedScene, method: Method, older: VersionRun, newer: VersionRun
) -> VersionChange:
    equal = _equal(scene, older, newer)
    errors = {} if equal else _notable(scene, older, newer)
    ratios = [new / old for old, new in zip(older.seconds, newer.seconds, strict=False)]
    # In every round: a single slow round may be due to the machine.
    is_slower = bool(ratios) and min(ratios) > NOTABLE
    is_faster = bool(ratios) and max(ratios) < 1 / NOTABLE
    ratio = float(np.median(ratios)) if ratios else None
    ended_before = older.outcome == "ok"
    # What the older version could not do either is no regression.
    is_worse = is_slower or (ended_before and newer.outcome != "ok")
    is_worse |= any(new > old for old, new in errors.values())
    words = (older.verdict.verdict, newer.verdict.verdict)
    is_worse |= ended_before and RANKS[words[1]] > RANKS[words[0]]
    parts = [*_in_words(older, newer, equal, errors)]
    if is_slower or is_faster:
        parts.append(f"a step takes {ratio:.2f} times as long")
    return VersionChange(
        scene.scenario.name,
        method.name,
        older.version,
        newer.version,
        (older.outcome, newer.outcome),
        words,
        equal,
        errors,
        ratio,
        is_worse,
        "; ".join(parts),
        is_round_off=len(parts) == 1 and equal == "to round-off",
    )


def _in_words(
    older: VersionRun, newer: VersionRun, equal: str, errors: dict[str, tuple[float, float]]
) -> Iterator[str]:
    if older.outcome != newer.outcome:
        reason = newer.reason if older.outcome == "ok" else older.reason
        yield f"{older.outcome} → {newer.outcome} ({reason})"
    elif older.outcome == "ok" and equal != "to the last bit":
        yield f"motion equal {equal}" if equal else "another motion"
    if older.verdict.verdict != newer.verdict.verdict:
        yield f"{older.verdict.verdict} → {newer.verdict.verdict}"
    for name, (old, new) in errors.items():
        yield f"{SIGNAL[name].label} error {old:.2g} → {new:.2g}"


def _equal(scene: SolvedScene, older: VersionRun, newer: VersionRun) -> str:
    """How equal two motions are, in words; empty if they differ, or one is incomplete."""
    if older.motion is None or newer.motion is None:
        return ""
    first, second = (
        np.hstack([m.q_world_body_wxyz, m.omega_body, m.com_world, m.velocity_world])
        for m in (older.motion, newer.motion)
    )
    if np.array_equal(first, second):
        return "to the last bit"
    apart = errors_between(scene.scenario, newer.motion, older.motion)
    return "to round-off" if max(value for _, value in apart) <= _round_off(scene) else ""


def _notable(
    scene: SolvedScene, older: VersionRun, newer: VersionRun
) -> dict[str, tuple[float, float]]:
    """The errors that changed by more than `NOTABLE` and exceed what the reference can resolve."""
    if older.errors is None or newer.errors is None:
        return {}
    notable = {}
    for name, old in older.errors:
        new = newer.errors[name]
        floor = max(scene.solution.uncertainty[name], _round_off(scene))
        high, low = max(old, new), max(min(old, new), floor)
        if high > NOTABLE * low:
            notable[name] = (old, new)
    return notable


def _round_off(scene: SolvedScene) -> float:
    """Bound on the round-off of a run, relative."""
    return ROUNDINGS * EPS * scene.rung.steps
