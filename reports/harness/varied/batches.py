"""Tests whether the motion of a world in a batch depends on the other worlds, and times a step.

The motion must depend neither on the number of worlds, nor on the world's place in the batch, nor
on its neighbours. The worlds at the first, middle and last place are compared with the same world
alone, with each other, and with themselves beside odd neighbours: one that blows up, one at rest,
and another body.
"""

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from mpmath import mpf
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ....engines import (
    Batch,
    Engine,
    EngineError,
    Method,
    Outcome,
    Session,
    State,
    UnsupportedError,
    engines,
)
from ....scenarios import Scenario
from ....scenarios.scatter import member
from ..executors import CallFailed, Executor

#: Approximate time that the steps of a batch may take, s. If steps are expensive, only a part of
#: the window is compared.
BUDGET = 10.0
#: Number of steps from which that time is estimated; number of MuJoCo's steps that are timed, and
#: number of repeats.
TRIED, TIMED, TIMES = 10, 2000, 5
#: Spin of a neighbour that blows up, rad/s: it overflows in single precision at once, in double
#: precision after a few steps.
BLOWING_UP = 1e60
#: Names of what a motion depends on, besides kinds of odd neighbours. The first two are found by
#: batches without odd neighbours; the last one means all kinds together, but no kind alone.
NUMBER, PLACE, TOGETHER = "the number of worlds", "its place", "its neighbours together"


@dataclass(frozen=True)
class Apart:
    """The difference of two runs of one world.

    Attributes
    ----------
    step : the first step at which they differ, among those compared, each twice the one before
    ulp : largest relative distance, at that step, of attitude, ω, position, velocity and spins
    degrees : angle between the attitudes at the end; infinite if an attitude is not finite
    """

    step: int
    ulp: float
    degrees: float


#: The difference from a batch in which an odd neighbour stops all worlds; the words that tell it.
STOPPED, STOPS = Apart(1, math.inf, math.inf), ", which stops all worlds"


@dataclass(frozen=True)
class BatchRow:
    """A batch with a number of worlds of one scene: what its motions depend on, and its cost.

    Attributes
    ----------
    device : the device that steps the worlds; the one asked for if nothing was stepped
    steps : number of steps that are compared
    until : time of the last of these steps, s
    alone, place, neighbours : the largest difference of a world in the batch from the world alone,
        from the world at the first place, and from the same place beside odd neighbours; None if
        the motions agree to the last bit, infinite if a neighbour stops all worlds
    has_neighbours : whether the batch has places for odd neighbours
    because : what the motion depends on; empty if it does not depend on its batch
    seconds_per_step : wall time of a step of all worlds, s
    beside : wall time, s, of a step of `beside_by`, an engine and its method, which step one
        world on one core
    outcome, reason : ok; or unsupported or failed, and the reason why nothing could be compared
    """

    scene: str
    engine: str
    method: str
    timestep: float
    worlds: int
    device: str = Batch.device
    steps: int = 0
    until: float = 0.0
    alone: Apart | None = None
    place: Apart | None = None
    neighbours: Apart | None = None
    has_neighbours: bool = False
    because: tuple[str, ...] = ()
    seconds_per_step: float | None = None
    beside: float | None = None
    beside_by: str = ""
    outcome: Outcome = "ok"
    reason: str = ""


def batch_by(executor: Executor, scenario: Scenario, engine: Engine, row: BatchRow) -> BatchRow:
    """Return the row of `batch_of`, run in another process; if it crashes, the row says so."""
    answer = executor.call_at(engine.site, batch_of, scenario, engine, row)
    if isinstance(answer.value, CallFailed):
        return replace(row, outcome="failed", reason=answer.value.reason)
    return answer.value


def batch_of(scenario: Scenario, engine: Engine, row: BatchRow) -> BatchRow:
    """Compare and time a batch, and return its row.

    Parameters
    ----------
    row : names of scene, engine and method, the timestep, the number of worlds, and the device
    """
    method = engine.method(row.method)
    if reason := engine.unsupported(scenario, method):
        return replace(row, outcome="unsupported", reason=reason)
    try:
        if row.device != Batch.device:
            engine.use_device(row.device)
        with engine.open(scenario, method, row.timestep) as session:
            return _Study(scenario, engine, method, row, session).row()
    except UnsupportedError as error:
        return replace(row, outcome="unsupported", reason=str(error))
    except EngineError as error:
        return replace(row, outcome="failed", reason=str(error))


def device_by(executor: Executor, engine: Engine, name: str) -> str:
    """Return why an engine cannot step on a device, tried in another process; empty if it can."""
    answer = executor.call_at(engine.site, _refused, engine, name)
    return answer.value.reason if isinstance(answer.value, CallFailed) else answer.value


def _refused(engine: Engine, name: str) -> str:
    """Return why an engine cannot step on a device, in words; empty if it can."""
    try:
        engine.use_device(name)
    except UnsupportedError as error:
        return str(error)
    return ""


def neighbours_of(scenario: Scenario) -> dict[str, Scenario]:
    """Return the odd neighbours that are stepped beside a scene, by a description of each."""

    def turning(rate: float) -> Scenario:
        # Set directly, since no file may hold such a start.
        start = replace(scenario.start, omega_body_exact=(mpf(rate), mpf(rate), mpf(rate)))
        return replace(scenario, start=start)

    return {
        "one that blows up": turning(BLOWING_UP),
        "one at rest": turning(0.0),
        "another body": member(scenario, 0, 0),
    }


@dataclass(frozen=True, eq=False)
class _Motion:
    """The worlds at some places of a batch, after some numbers of steps.

    Attributes
    ----------
    ends : the numbers of steps, ascending
    snapshots : for each of these, one snapshot for each place
    """

    ends: Sequence[int]
    snapshots: Sequence[Sequence[object]]
    seconds_per_step: float = 0.0
    device: str = ""


@dataclass(frozen=True, eq=False)
class _Study:
    """The comparison of a batch's worlds.

    `session` has one world of the scene, outside any batch; `begun` is the row to be completed.
    """

    scenario: Scenario
    engine: Engine
    method: Method
    begun: BatchRow
    session: Session

    def row(self) -> BatchRow:
        """Return the completed row, from batches without odd neighbours and with all kinds of them.

        If all kinds together change a motion, batches are also run with each kind alone.
        """
        begun, odd = self.begun, neighbours_of(self.scenario)
        alike = self._batch(())
        alone = self._alone(alike.ends)
        self._check_finite(alike, alone)
        apart = partial(_difference, states=self.session.states, ulp=self.engine.ulp)
        # Each place is compared with the first.
        first = replace(alike, snapshots=[[row[0]] * len(row) for row in alike.snapshots])
        by_number, by_place = apart(alone, first), apart(first, alike)
        because = [word for word, is_so in ((NUMBER, by_number), (PLACE, by_place)) if is_so]

        def beside(*scenes: Scenario) -> Apart | None:
            try:
                return apart(alike, self._batch(scenes, alike.ends))
            except EngineError:
                return STOPPED

        by_neighbours = beside(*odd.values()) if self._free else None
        if by_neighbours:
            kinds = {name: found for name, one in odd.items() if (found := beside(one))}
            because += [f"{name}{STOPS * (kinds[name] is STOPPED)}" for name in kinds] or [TOGETHER]
        steps = alike.ends[-1]
        beside_by, seconds = _mujoco(self.scenario, self.method, begun.timestep)
        return replace(
            begun,
            device=alike.device,
            steps=steps,
            until=steps * begun.timestep,
            alone=by_number,
            place=by_place,
            neighbours=by_neighbours,
            has_neighbours=bool(self._free),
            because=tuple(because),
            seconds_per_step=alike.seconds_per_step,
            beside=seconds,
            beside_by=beside_by,
        )

    def _check_finite(self, alike: _Motion, alone: _Motion) -> None:
        """Raise `EngineError` if the first place is no longer finite where the world alone is."""
        for steps, *both in zip(alike.ends, alike.snapshots, alone.snapshots, strict=True):
            there, beside = (np.hstack(self.session.states(row[:1]).columns) for row in both)
            if np.isfinite(beside).all() and not np.isfinite(there).all():
                words = f"its batch returned numbers that are not finite, after step {steps}"
                raise EngineError(words, "not-finite")

    @property
    def _places(self) -> list[int]:
        """The indices of the first, middle and last place, each once."""
        worlds = self.begun.worlds
        return sorted({0, worlds // 2, worlds - 1})

    @property
    def _free(self) -> list[int]:
        """The indices of the places for odd neighbours."""
        return [k for k in range(self.begun.worlds) if k not in self._places]

    def _batch(self, odd: Sequence[Scenario], ends: Sequence[int] = ()) -> _Motion:
        """Run a batch, with the scenes of odd neighbours in turn at the free places.

        Parameters
        ----------
        odd : scenes of the neighbours; none if empty
        ends : numbers of steps after which the worlds are compared; chosen by their cost if empty
        """
        scenes = [self.scenario] * self.begun.worlds
        for number, place in enumerate(self._free if odd else ()):
            scenes[place] = odd[number % len(odd)]
        ends = ends or self._ends(scenes)
        with closing(self.engine.open_batch(scenes, self.method, self.begun.timestep)) as batch:
            snapshots, seconds = [], 0.0
            for steps in np.diff(ends, prepend=0).tolist():
                seconds += batch.timed(steps)
                snapshots.append(list(batch.snapshots(self._places)))
                if (given := len(snapshots[-1])) != len(self._places):
                    places = len(self._places)
                    raise EngineError(f"its batch gave {given} snapshots of {places} worlds", "bug")
            return _Motion(ends, snapshots, seconds / ends[-1], batch.device)

    def _ends(self, scenes: Sequence[Scenario]) -> list[int]:
        """Return the numbers of steps after which worlds are compared: powers of two, and the last.

        The last is the length of the window, or less if that would take longer than `BUDGET`.
        """
        with closing(self.engine.open_batch(scenes, self.method, self.begun.timestep)) as batch:
            batch.advance(1)
            a_step = batch.timed(TRIED) / TRIED
        window = round(self.scenario.window.duration / self.begun.timestep)
        last = max(1, min(window, round(BUDGET / a_step)))
        return [1 << k for k in range(last.bit_length()) if 1 << k < last] + [last]

    def _alone(self, ends: Sequence[int]) -> _Motion:
        """Run the world in a session of its own, as if it were at every place.

        Parameters
        ----------
        ends : numbers of steps after which the world is compared
        """
        snapshots: list[object] = []
        self.session.record(np.diff(ends, prepend=0).tolist(), snapshots.append)
        return _Motion(ends, [[one] * len(self._places) for one in snapshots])


def _difference(
    first: _Motion, second: _Motion, states: Callable[[Sequence[object]], State], ulp: float
) -> Apart | None:
    """Return the largest difference of two motions at any place; None if all bits agree.

    Parameters
    ----------
    states : returns the states of snapshots
    ulp : relative spacing of the engine's numbers
    """
    same = [
        np.array_equal(_numbers(a), _numbers(b), equal_nan=True)
        for a, b in zip(first.snapshots, second.snapshots, strict=True)
    ]
    if all(same):
        return None
    began = same.index(False)
    distance = _distance(states(first.snapshots[began]), states(second.snapshots[began]))
    degrees = _degrees(states(first.snapshots[-1]), states(second.snapshots[-1]))
    return Apart(first.ends[began], distance / ulp, degrees)


def _numbers(snapshots: Sequence[object]) -> NDArray[Any]:
    """Return n snapshots, which are states or numbers, as an array with n rows."""
    each = [np.hstack(one.columns) if isinstance(one, State) else one for one in snapshots]
    return np.asarray(each)


def _distance(first: State, second: State) -> float:
    """Return the largest relative distance of any quantity in any row; infinite if not finite."""
    found = [0.0]
    for a, b in zip(first.columns, second.columns, strict=True):
        size, deviation = (np.linalg.norm(x, axis=1) for x in (a, b - a))
        apart = (size > 0) & (deviation != 0)
        found += (deviation[apart] / size[apart]).tolist()
    most = float(np.max(found))
    return most if math.isfinite(most) else math.inf


def _degrees(first: State, second: State) -> float:
    """Return the largest angle between two attitudes, degrees; infinite if one is not finite."""
    both = first.q_world_body_wxyz, second.q_world_body_wxyz
    if not all(np.isfinite(q).all() and q.any(axis=1).all() for q in both):
        return math.inf
    a, b = (Rotation.from_quat(q, scalar_first=True) for q in both)
    return math.degrees(float((a.inv() * b).magnitude().max()))


def _mujoco(scenario: Scenario, method: Method, timestep: float) -> tuple[str, float]:
    """Return a MuJoCo method of similar order, and the wall time of its step on one core, s.

    Parameters
    ----------
    timestep : s
    """
    mujoco = engines()["mujoco"]
    by = mujoco.method("RK4" if method.order > 1 else "Euler")
    with mujoco.open(scenario, by, timestep) as session:
        walls = [wall for _, wall in (session.timed(TIMED) for _ in range(TIMES))]
    return f"{mujoco.name} {by.name}", min(walls) / TIMED
