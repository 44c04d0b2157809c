"""What changed from one version of an engine to the next: motions, errors, outcomes, speed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...engines import Engine, Method, Run
from ...reference import Solution, solve
from ...scenarios import Errors, Scenario, errors_between
from .executors import CallFailed, Executor
from .ladder import Rung, single
from .step_cost import step_costs
from .study import simulate

#: A free body, a heavy top, and one that is slowed, where nothing else is asked for.
SCENES = ("tennis-racket", "fast-top", "book-with-drag")
EPS = float(np.finfo(float).eps)
#: Roundings a step that two compilations of the same formulas may differ by.
ROUNDINGS = 16
#: An error or a time has changed if it did by this factor: the noise of times is less.
NOTABLE = 1.2
#: Rounds in which versions are timed in turn.
ROUNDS = 5


@dataclass(frozen=True)
class VersionChange:
    """A method on a scene, in two versions.

    Attributes
    ----------
    outcomes : of the older and the newer run
    equal : whether they are one motion, "to the last bit" or "to round-off"; else empty
    errors : by signal, of the older and the newer, where they changed notably
    ratio : of the newer's time a step to the older's, median of rounds in turn; None if not timed
    is_worse : whether the newer is
    words : all of it; empty where nothing changed
    """

    scenario: str
    method: str
    older: str
    newer: str
    outcomes: tuple[str, str]
    equal: str
    errors: dict[str, tuple[float, float]]
    ratio: float | None
    is_worse: bool
    words: str


@dataclass(frozen=True, eq=False)
class _Exact:
    """A scene's runs, and the exact motion at their samples."""

    scenario: Scenario
    rung: Rung
    solution: Solution


def version_changes(
    engines: Sequence[Engine], scenes: Sequence[Scenario], timestep: float, executor: Executor
) -> Iterator[VersionChange]:
    """Compare neighbours among versions, oldest first, method by method.

    Parameters
    ----------
    timestep : s, of every run
    """
    for scenario in scenes:
        rung = single(timestep, scenario.times)
        solution = solve(scenario, np.asarray(rung.sample_steps * timestep, dtype=float))
        exact = _Exact(scenario, rung.until(len(solution.trajectory.t)), solution)
        for method in engines[-1].methods:
            if engines[-1].unsupported(scenario, method):
                continue
            runs = [_run(engine, method, exact, executor) for engine in engines]
            times = _times(engines, method, scenario, executor)
            for k, (older, newer) in enumerate(pairwise(engines)):
                ratios = _ratios(times[k], times[k + 1])
                yield _change(older, newer, method, exact, (runs[k], runs[k + 1]), ratios)


def _run(engine: Engine, method: Method, exact: _Exact, executor: Executor) -> Run | CallFailed:
    return executor.call_at(
        engine.site, simulate, engine, exact.scenario, method.name, exact.rung
    ).value


def _times(
    engines: Sequence[Engine], method: Method, scenario: Scenario, executor: Executor
) -> list[list[float]]:
    """CPU seconds a step of each version, round by round; versions in turn."""
    times: list[list[float]] = [[] for _ in engines]
    for _ in range(ROUNDS):
        for engine, seconds in zip(engines, times, strict=True):
            pairs = [(engine, method)]
            costs = executor.call_at(engine.site, step_costs, scenario, pairs).value
            if not isinstance(costs, CallFailed) and costs[0] is not None:
                seconds.append(costs[0].seconds_per_step)
    return times


def _ratios(older: Sequence[float], newer: Sequence[float]) -> list[float]:
    """Round by round; none where a version could not be timed."""
    if len(older) != ROUNDS or len(newer) != ROUNDS:
        return []
    return [new / old for old, new in zip(older, newer, strict=True)]


def _change(
    older: Engine,
    newer: Engine,
    method: Method,
    exact: _Exact,
    runs: tuple[Run | CallFailed, Run | CallFailed],
    ratios: Sequence[float],
) -> VersionChange:
    outcomes = tuple("failed" if isinstance(run, CallFailed) else run.outcome for run in runs)
    equal, errors = _motions(exact, runs)
    is_less = {name: pair for name, pair in errors.items() if pair[1] > pair[0]}
    # What the older version could not do either is no regression.
    got_worse = outcomes[0] == "ok" != outcomes[1]
    ratio = float(np.median(ratios)) if ratios else None
    # In every round: a single slow one may be the machine's.
    is_slower = bool(ratios) and min(ratios) > NOTABLE
    is_faster = bool(ratios) and max(ratios) < 1 / NOTABLE
    parts = []
    if outcomes[0] != outcomes[1]:
        reason = getattr(runs[1] if got_worse else runs[0], "reason", "")
        parts.append(f"{outcomes[0]} → {outcomes[1]} ({reason})")
    elif outcomes == ("ok", "ok") and equal != "to the last bit":
        parts.append(f"motion equal {equal}" if equal else "another motion")
    parts += [f"{name} error {old:.2g} → {new:.2g}" for name, (old, new) in errors.items()]
    if is_slower or is_faster:
        parts.append(f"a step takes {ratio:.2f} times as long")
    is_worse = bool(is_less) or got_worse or is_slower
    head = f"{exact.scenario.name}, {method.name}, {older.version} → {newer.version}"
    words = f"{head}: {'; '.join(parts)}{'  WORSE' if is_worse else ''}" if parts else ""
    return VersionChange(
        exact.scenario.name,
        method.name,
        older.version,
        newer.version,
        (outcomes[0], outcomes[1]),
        equal,
        errors,
        ratio,
        is_worse,
        words,
    )


def _motions(
    exact: _Exact, runs: tuple[Run | CallFailed, Run | CallFailed]
) -> tuple[str, dict[str, tuple[float, float]]]:
    """How equal two motions are, and the errors that changed beyond round-off."""
    motions = [
        run.trajectory
        for run in runs
        if isinstance(run, Run) and run.outcome == "ok" and run.trajectory is not None
    ]
    if len(motions) < len(runs):
        return "", {}
    older, newer = motions
    rows = [
        np.hstack([m.q_world_body_wxyz, m.omega_body, m.com_world, m.velocity_world])
        for m in motions
    ]
    if np.array_equal(rows[0], rows[1]):
        return "to the last bit", {}
    round_off = ROUNDINGS * EPS * exact.rung.steps
    between = errors_between(exact.scenario, newer, older)
    if max(vars(between).values()) <= round_off:
        return "to round-off", {}
    errors = [errors_between(exact.scenario, m, exact.solution.trajectory) for m in motions]
    return "", _notable(errors[0], errors[1], vars(exact.solution.uncertainty), round_off)


def _notable(
    older: Errors, newer: Errors, uncertainty: dict[str, float], round_off: float
) -> dict[str, tuple[float, float]]:
    """The errors that changed by more than `NOTABLE` and exceed what the reference can resolve."""
    notable = {}
    for name, old in vars(older).items():
        new = vars(newer)[name]
        floor = max(uncertainty.get(name, 0.0), round_off)
        high, low = max(old, new), max(min(old, new), floor)
        if high > NOTABLE * low:
            notable[name] = (old, new)
    return notable
