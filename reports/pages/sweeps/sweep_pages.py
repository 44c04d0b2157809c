"""What pages of maps and of ensembles share: their names, their methods, numbers as typed."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from typing import TypeVar

from ....engines import Method
from ....scenarios.vary import Axis
from ...results.records import Pair
from ...results.store import Results
from ...results.sweep_records import EnsembleResult, MapResult, PointResult

AT_A_TURN = "Timesteps are chosen run by run, so that the body turns equally far in a step."
#: Digits of a number in a command: those that were typed, and none that rounding added.
TYPED_DIGITS = 12

Swept = TypeVar("Swept", MapResult, EnsembleResult)


def numbered(sweeps: Iterable[Swept]) -> Iterator[tuple[str, Swept]]:
    """The sweeps that have any points, with names unique in a report: scene and number."""
    numbers: Counter[str] = Counter()
    for sweep in sweeps:
        if any(point.key.engine for point in sweep.points):
            scene = sweep.scenario.name
            numbers[scene] += 1
            yield f"{scene}-{numbers[scene]}", sweep


def methods_of(points: tuple[PointResult, ...], results: Results) -> dict[Pair, Method | None]:
    """Those that were run, engines by name, their methods as the adapter lists them."""
    pairs = {(point.key.engine, point.key.method) for point in points if point.key.engine}
    listed = {pair: rank for rank, pair in enumerate(results.methods)}
    ordered = sorted(pairs, key=lambda p: (p[0], listed.get(p, len(listed)), p[1]))
    return {pair: results.methods.get(pair) for pair in ordered}


def typed(value: float) -> str:
    """A number as in a command."""
    return f"{value:.{TYPED_DIGITS}g}"


def method_options(pairs: Collection[tuple[str, str]], results: Results) -> list[str]:
    """The words of a command that name engines, and methods if not all of these were run."""
    names = dict.fromkeys(engine for engine, _ in pairs)
    words = [word for name in names for word in ("--engine", name)]
    if set(pairs) >= {pair for pair in results.methods if pair[0] in names}:
        return words
    methods = dict.fromkeys(method for _, method in pairs)
    return words + [word for name in methods for word in ("--method", name)]


def timestep_option(timestep: float | None) -> list[str]:
    """The words of a command that set the timestep; none where each run has its own."""
    return [] if timestep is None else ["--timestep", typed(timestep)]


def timestep_in_words(
    timestep: float | None, axes: tuple[Axis, ...] = (), otherwise: str = AT_A_TURN
) -> str:
    """Which timestep the runs take, where it is not an axis.

    Parameters
    ----------
    otherwise : which it is where none was given
    """
    if any(axis.path == "timestep" for axis in axes):
        return ""
    if timestep is None:
        return otherwise
    return f"Every run takes steps of {timestep:g} s."
