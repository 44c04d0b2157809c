"""Compares two result files: lists all changes, and which of them are regressions.

An error counts as unchanged if it differs by no more than rounding and the reference's uncertainty
explain; a cost, if it differs by no more than timings scatter.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Literal

from ....engines import Outcome
from ...results.records import Key, Row
from ...results.results import Results
from ...results.verdict_words import RANKS
from ...results.verdicts import Verdict
from .observed_order import ASYMPTOTIC
from .report_data import MethodRuns, SceneRuns, report_data

#: Factor by which an error must differ to count as changed. An engine that computes the same makes
#: the same error at the same timestep, up to rounding.
ERROR_FACTOR = 1.1
#: Factor by which a cost must differ to count as changed. It must also differ by more than the sum
#: of both spreads. When 497 methods were timed three times each on a processor that was busy with
#: other work, no two times of a method differed by a factor of more than 1.18; up to 12 % of the
#: pairs differed by more than both spreads. Of steps that cost twice as much, 99 % are detected.
COST_FACTOR = 1.25
#: The outcomes of runs, from good to bad.
OUTCOMES: tuple[Outcome, ...] = ("ok", "unsupported", "diverged", "failed")

Kind = Literal[
    "environment", "scene", "method", "verdict", "order", "expectation", "outcome", "error", "cost"
]
Direction = Literal["worse", "better", "other"]


@dataclass(frozen=True)
class Change:
    """One difference between two result files.

    Attributes
    ----------
    kind : the kind of thing that has changed, such as "verdict"
    name : the thing that has changed: an entry of the environment, a scene, a method, the signal of
        an error, or an expectation; "seconds_per_step" for a cost; for other kinds, the kind itself
    old, new : the values in the two files; None if missing
    direction : whether the change is for the worse, for the better, or neither
    regression : whether the change is for the worse, and due to the engine or program under test
    scenario, engine, method, timestep : scene, engine, method and timestep, s, of what has changed;
        None for each that the change is not specific to
    """

    kind: Kind
    name: str
    old: str | float | None
    new: str | float | None
    direction: Direction = "other"
    regression: bool = False
    scenario: str | None = None
    engine: str | None = None
    method: str | None = None
    timestep: float | None = None


def changes(old: Results, new: Results) -> list[Change]:
    """Return all changes between two result files.

    Changes of the environment, of scenes and of methods come first, then changes of results.
    Runs and costs are compared only on scenes whose motion is the same in both files.
    """
    edited = {name for name in old.scenes.keys() & new.scenes.keys() if _edited(name, old, new)}
    differences = [*_environment(old.environment, new.environment), *_scenes(old, new, edited)]
    differences += _methods(old, new)
    before, after = _by_key(old), _by_key(new)
    same_machine = old.environment.get("processor") == new.environment.get("processor")
    for key in sorted(before.keys() & after.keys(), key=str):
        verdicts = before[key][1].verdict, after[key][1].verdict
        for of_verdicts in (_verdict, _order, _expectations):
            differences += of_verdicts(key, *verdicts)
        if key.scenario not in edited:
            differences += _runs(key, before[key], after[key])
            differences += _cost(key, before[key], after[key], same_machine)
    return differences


#: A scene, and the runs of one method on it, in one file.
_OfKey = tuple[SceneRuns, MethodRuns]


def _by_key(results: Results) -> dict[Key, _OfKey]:
    """Return pairs of a scene and the runs of one method on it, by scene, engine and method."""
    scenes = report_data(results).scenes
    return {Key(one.name, *runs.pair): (one, runs) for one in scenes for runs in one.methods}


def _environment(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[Change]:
    """Yield a change for each entry of the environment that differs; the date is left out."""
    for name in sorted((old.keys() | new.keys()) - {"date"}):
        if old.get(name) != new.get(name):
            yield Change("environment", name, old.get(name), new.get(name))


def _edited(name: str, old: Results, new: Results) -> bool:
    """Return whether a scene's motion differs between two files; titles and comments may differ."""
    return old.scenes[name].scenario.digest != new.scenes[name].scenario.digest


def _scenes(old: Results, new: Results, edited: set[str]) -> Iterator[Change]:
    """Yield a change for each scene that is in one file only, or whose motion differs.

    Parameters
    ----------
    edited : names of the scenes whose motion differs between the files
    """
    before, after = ({key.scenario for key in _by_key(r)} for r in (old, new))
    for name in sorted(before ^ after):
        yield Change("scene", name, *_presence(name in before), scenario=name)
    for name in sorted(edited):
        was, now = (r.scenes[name].scenario.digest[:8] for r in (old, new))
        yield Change("scene", name, f"motion {was}", f"motion {now}", scenario=name)


def _methods(old: Results, new: Results) -> Iterator[Change]:
    """Yield a change for each method that is in one file only."""
    before, after = ({key.pair for key in _by_key(r)} for r in (old, new))
    for engine, method in sorted(before ^ after):
        presence = _presence((engine, method) in before)
        yield Change("method", f"{engine} {method}", *presence, engine=engine, method=method)


def _presence(before: bool) -> tuple[str | None, str | None]:
    """Return the old and the new value for a scene or method that only one file has.

    The value is "there" for the file that has it, and None for the other file.

    Parameters
    ----------
    before : whether the old file has the scene or method
    """
    return ("there", None) if before else (None, "there")


def _verdict(key: Key, old: Verdict | None, new: Verdict | None) -> Iterator[Change]:
    """Yield a change if the words of the verdicts differ, or if only one file has a verdict."""
    before, after = old.verdict if old else None, new.verdict if new else None
    if before != after:
        yield _change_of_word(key, "verdict", before, after, tuple(RANKS))


def _order(key: Key, old: Verdict | None, new: Verdict | None) -> Iterator[Change]:
    """Yield a change if both verdicts are `converges` but gains vanish with different orders.

    Nothing is yielded unless both orders are known.
    """
    before, after = (v.order if v and v.verdict == "converges" else None for v in (old, new))
    if before is None or after is None or before == after:
        return
    yield _judged(key, "order", "order", before, after, after < before)


def _expectations(key: Key, old: Verdict | None, new: Verdict | None) -> Iterator[Change]:
    """Yield a change for each expectation that was met in one file and is unmet in the other.

    Nothing is yielded unless both files have a verdict.
    """
    if old is None or new is None:
        return
    unmet = [
        {what: size for what, _, size in (line.partition(": ") for line in verdict.unmet)}
        for verdict in (old, new)
    ]
    for expected in sorted(unmet[0].keys() ^ unmet[1].keys()):
        was, now = (one.get(expected, "kept") for one in unmet)
        yield _judged(key, "expectation", expected, was, now, expected in unmet[1])


def _runs(key: Key, old: _OfKey, new: _OfKey) -> Iterator[Change]:
    """Yield changes of outcomes and errors at the timesteps that are in both files.

    Errors are compared if both runs are ok and the scene was solved in both files. `old` and `new`
    are, from each file, the scene and the runs of one method on it.
    """
    old_rows, new_rows = ({row.timestep: row for row in runs.rows} for _, runs in (old, new))
    for timestep in sorted(old_rows.keys() & new_rows.keys(), reverse=True):
        before, after = old_rows[timestep], new_rows[timestep]
        if before.outcome != after.outcome:
            yield _change_of_word(key, "outcome", before.outcome, after.outcome, OUTCOMES, timestep)
        elif before.outcome == "ok" and old[0].solved and new[0].solved:
            yield from _errors(before, after, _noise(old[0], before), _noise(new[0], after))


def _errors(
    old: Row, new: Row, old_noise: Mapping[str, float], new_noise: Mapping[str, float]
) -> Iterator[Change]:
    """Yield a change for each signal in which the errors of two runs differ.

    They must differ by more than noise and by more than the factor `ERROR_FACTOR`.

    Parameters
    ----------
    old_noise, new_noise : by signal, the part of each run's errors that rounding and the
        reference's uncertainty may explain
    """
    if old.errors is None or new.errors is None:
        return
    # Older files have no errors of spins.
    for signal in (name for name in old_noise if name in new_noise):
        sizes = old.errors[signal], new.errors[signal]
        if _has_changed(*sizes, old_noise[signal] + new_noise[signal]):
            is_worse = sizes[1] > sizes[0]
            yield _judged(old.key, "error", signal, *sizes, is_worse, old.timestep)


def _noise(scene: SceneRuns, row: Row) -> dict[str, float]:
    """Return the noise of a run's errors, by signal.

    It is the uncertainty of the reference, plus the conditioning times the number of steps, as each
    step rounds by an ulp.
    """
    growth, bound = scene.exact.solution.conditioning, scene.uncertainty(row)
    names = (signal.name for signal in scene.signals)
    return {name: bound[name] + row.steps * growth[name] for name in names}


def _has_changed(old: float, new: float, noise: float) -> bool:
    """Return whether an error has changed by more than noise and the factor `ERROR_FACTOR`.

    Two errors that are both too large for the asymptotic range never count as changed.

    Parameters
    ----------
    noise : difference up to which the errors count as equal
    """
    low, high = sorted((old, new))
    return low != high and low < ASYMPTOTIC and high - low > noise and high > ERROR_FACTOR * low


def _cost(key: Key, old: _OfKey, new: _OfKey, same_machine: bool) -> Iterator[Change]:
    """Yield a change if the cost of a method's steps differs by more than timings scatter.

    The costs must differ by more than the factor `COST_FACTOR`, and by more than the sum of the
    spreads of both timings. Nothing is yielded unless steps were timed in both files.

    Parameters
    ----------
    old, new : from each file, the scene and the runs of one method on it
    same_machine : whether both files come from the same processor; if not, no change of cost is a
        regression
    """
    before, after = _seconds(old[1].rows), _seconds(new[1].rows)
    if before is None or after is None:
        return
    (was, spread), (now, scatter) = before, after
    if abs(now - was) <= spread + scatter or max(was, now) <= COST_FACTOR * min(was, now):
        return
    found = _judged(key, "cost", "seconds_per_step", was, now, now > was)
    yield replace(found, regression=found.regression and same_machine)


def _seconds(rows: Iterable[Row]) -> tuple[float, float] | None:
    """Return a method's CPU seconds a step and their spread, s; None if it was not timed."""
    for row in rows:
        if row.seconds_per_step is not None and row.seconds_spread is not None:
            return row.seconds_per_step, row.seconds_spread
    return None


def _change_of_word(
    key: Key,
    kind: Literal["verdict", "outcome"],
    old: str | None,
    new: str | None,
    scale: Sequence[str],
    timestep: float | None = None,
) -> Change:
    """Return the change of a verdict or an outcome, for the worse or the better by a scale.

    Parameters
    ----------
    old, new : the word in the two files; None if missing, and then the change is neither
    scale : the words from good to bad
    timestep : s; None for a verdict
    """
    if old is None or new is None:
        return Change(kind, kind, old, new, **asdict(key), timestep=timestep)
    return _judged(key, kind, kind, old, new, scale.index(new) > scale.index(old), timestep)


def _judged(
    key: Key,
    kind: Kind,
    name: str,
    old: str | float,
    new: str | float,
    worse: bool,
    timestep: float | None = None,
) -> Change:
    """Return a change for the worse, which counts as a regression, or one for the better.

    Parameters
    ----------
    key : scene, engine and method of the change
    kind, name, old, new : attributes of the `Change`
    worse : whether the change is for the worse
    timestep : s; None if the change is not at one timestep
    """
    direction: Direction = "worse" if worse else "better"
    return Change(kind, name, old, new, direction, worse, **asdict(key), timestep=timestep)
