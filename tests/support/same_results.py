"""Whether two result files say the same, to the last bit; what it took in time is left out."""

from collections.abc import Iterator
from dataclasses import asdict, replace

import numpy as np
from spincheck.reports.results.records import Row
from spincheck.reports.results.results import Results


def differences(a: Results, b: Results) -> list[str]:
    """What the second says otherwise, in words."""
    return [*_rows(a, b), *_verdicts(a, b), *_scenes(a, b), *_left_out(a, b)]


def _rows(a: Results, b: Results) -> Iterator[str]:
    first, second = (
        {(row.key, row.variation, row.timestep): row for row in r.every_row} for r in (a, b)
    )
    yield from (f"row missing or too many: {key}" for key in first.keys() ^ second.keys())
    for key in first.keys() & second.keys():
        if _plain(first[key]) != _plain(second[key]):
            yield f"row differs: {key}: {_plain(first[key])} {_plain(second[key])}"
        if (first[key].seconds_per_step is None) != (second[key].seconds_per_step is None):
            yield f"timed in one only: {key}"
        if not same_arrays(first[key].motion, second[key].motion):
            yield f"samples differ: {key}"


def _verdicts(a: Results, b: Results) -> Iterator[str]:
    first, second = ({verdict.key: verdict for verdict in r.verdicts} for r in (a, b))
    for key in first.keys() | second.keys():
        if first.get(key) != second.get(key):
            yield f"verdict differs: {first.get(key)} {second.get(key)}"


def _scenes(a: Results, b: Results) -> Iterator[str]:
    for name in a.scenes.keys() | b.scenes.keys():
        first, second = a.scenes.get(name), b.scenes.get(name)
        if first is None or second is None:
            yield f"scene in one only: {name}"
            continue
        scenes = [(s.scenario.text, s.solution.method, s.solution.horizon) for s in (first, second)]
        motions = (first.solution.trajectory, second.solution.trajectory)
        if scenes[0] != scenes[1] or not same_arrays(*motions):
            yield f"exact motion differs: {name}"


def _left_out(a: Results, b: Results) -> Iterator[str]:
    """What pruning saves is a matter of time: whether it is there at all."""
    first, second = ([(cost.key, cost.variation) for cost in r.costs] for r in (a, b))
    if first != second:
        yield f"what is left out was timed otherwise: {first} {second}"


def _plain(row: Row) -> dict[str, object]:
    untimed = {"seconds_per_step": None, "seconds_spread": None, "wall_seconds_per_step": None}
    return asdict(replace(row, motion=None, **untimed))


def same_arrays(a: object, b: object) -> bool:
    """Whether two motions, or none, are the same to the last bit."""
    if a is None or b is None:
        return a is b
    pairs = zip(vars(a).values(), vars(b).values(), strict=True)
    return all(np.array_equal(x, y) for x, y in pairs)
