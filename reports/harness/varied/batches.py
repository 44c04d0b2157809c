"""Tests whether the motion of a world in a batch depends on the other worlds, and times a step.

A world is one copy of a scene; a batch steps many worlds at once. A motion must depend neither on
the number of worlds, nor on the world's place in the batch, nor on its neighbours, the other
worlds. The worlds at the first, middle and last place are compared with the same world in a session
of its own, with each other, and with the same places of a batch with odd neighbours: worlds of
other scenes, of which one blows up, one is at rest, and one has another body.
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

#: Approximate wall time that the steps of a batch may take, s. If steps are expensive, only a part
#: of the window is compared.
BUDGET = 10.0
#: Number of steps from which that time is estimated; number of MuJoCo's steps that are timed
#: together, and how often this is repeated.
TRIED, TIMED, TIMES = 10, 2000, 5
#: Every component of ω of a neighbour that blows up, rad/s: its motion overflows at once in single
#: precision, and after a few steps in double precision.
BLOWING_UP = 1e60
#: Names of what a motion may depend on, besides the kinds of odd neighbours. The first two are
#: found without odd neighbours; the last one means that it depends on all kinds together, but on no
#: kind alone.
NUMBER, PLACE, TOGETHER = "the number of worlds", "its place", "its neighbours together"


@dataclass(frozen=True)
class Apart:
    """The difference between two runs of the same worlds.

    Attributes
    ----------
    step : the number of steps at the first comparison in which they differ; they are compared after
        1, 2, 4, 8, … steps and at the end
    ulp : at that step, the largest of the distances in attitude, ω, position, velocity and spins,
        each relative to the quantity's size, in ulp of the engine's precision
    degrees : angle between the attitudes at the end; infinite if an attitude is not finite
    """

    step: int
    ulp: float
    degrees: float


#: The difference if an odd neighbour stops all worlds, and the words that say so.
STOPPED, STOPS = Apart(1, math.inf, math.inf), ", which stops all worlds"


@dataclass(frozen=True)
class BatchRow:
    """A batch of worlds of one scene: what their motions depend on, and the cost of a step.

    A world is a copy of the scene in the batch, and its place is its index.

    Attributes
    ----------
    scene, engine, method : names
    timestep : s
    worlds : number of worlds
    device : the device that steps the worlds; as long as no steps are made, the device asked for
    steps : number of steps of the comparison
    until : time at the end of these steps, s
    alone : difference of the world at the first place from the world in a session of its own
    place : largest difference of the world at the middle or last place from that at the first
    neighbours : largest difference of the world at the first, middle or last place from that at the
        same place of a batch whose other places have odd worlds (`neighbours_of`); `STOPPED` if
        these stop all worlds. `alone`, `place` and `neighbours` are None if the compared motions
        agree to the last bit
    has_neighbours : whether the batch has places besides the first, the middle and the last
    because : what the motions depend on, in words; empty if they agree to the last bit
    seconds_per_step : wall time of a step of all worlds, s; None if nothing was compared
    beside : wall time of a step of one world on one core, s, by `beside_by`
    beside_by : an engine and a method for comparison
    outcome : `ok` if the worlds were compared, else `unsupported` or `failed`
    reason : why nothing could be compared; empty if `ok`
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
    """Call `batch_of` by an executor, and return its row; a `failed` row if the call fails.

    Parameters
    ----------
    row : the row to be completed; it states method, timestep, number of worlds and device
    """
    answer = executor.call_at(engine.site, batch_of, scenario, engine, row)
    if isinstance(answer.value, CallFailed):
        return replace(row, outcome="failed", reason=answer.value.reason)
    return answer.value


def batch_of(scenario: Scenario, engine: Engine, row: BatchRow) -> BatchRow:
    """Compare the worlds of a batch, time its steps, and return its row.

    The row is `unsupported` if the engine refuses the scene, the device or the batch, and `failed`
    if the engine fails.

    Parameters
    ----------
    row : the row to be completed; it states scene, engine, method, timestep, number of worlds and
        device
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
    """Return in words why an engine cannot step on a device; empty if it can.

    An executor calls the engine to find out.

    Parameters
    ----------
    name : name of the device, as the engine knows it
    """
    answer = executor.call_at(engine.site, _refused, engine, name)
    return answer.value.reason if isinstance(answer.value, CallFailed) else answer.value


def _refused(engine: Engine, name: str) -> str:
    """Return why an engine cannot step on the device `name`, in words; empty if it can."""
    try:
        engine.use_device(name)
    except UnsupportedError as error:
        return str(error)
    return ""


def neighbours_of(scenario: Scenario) -> dict[str, Scenario]:
    """Return odd scenes, with which a batch of worlds of one scene is mixed, by their descriptions.

    A scene's motion must not depend on such neighbours: one blows up, one is at rest, and one has
    another body.
    """

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
    """The motions of the worlds at the compared places of a batch.

    Attributes
    ----------
    ends : the numbers of steps after which snapshots are taken, ascending
    snapshots : for each of these, one snapshot of the world at each place
    seconds_per_step : wall time of a step of all worlds, s; 0 if not measured
    device : the device that stepped the worlds; empty for a world in a session of its own
    """

    ends: Sequence[int]
    snapshots: Sequence[Sequence[object]]
    seconds_per_step: float = 0.0
    device: str = ""


@dataclass(frozen=True, eq=False)
class _Study:
    """The comparison of a batch's worlds.

    Attributes
    ----------
    begun : the row to be completed
    session : a session of one world of the scene, outside any batch
    """

    scenario: Scenario
    engine: Engine
    method: Method
    begun: BatchRow
    session: Session

    def row(self) -> BatchRow:
        """Run the batches that are compared, and return the completed row.

        In one batch all worlds are alike; another one also has worlds of all three odd scenes
        (`neighbours_of`). If these change a motion, further batches are run, each with one of the
        odd scenes only.
        """
        begun, odd = self.begun, neighbours_of(self.scenario)
        alike = self._batch(())
        alone = self._alone(alike.ends)
        self._check_finite(alike, alone)
        apart = partial(_difference, states=self.session.states, ulp=self.engine.ulp)
        # The motion at the first place, repeated, so that each place is compared with the first.
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
        """Raise `EngineError` if a motion is finite in a session of its own but not in the batch.

        Only the world at the first place is checked.

        Parameters
        ----------
        alike : the motion in the batch
        alone : the motion in the session
        """
        for steps, *both in zip(alike.ends, alike.snapshots, alone.snapshots, strict=True):
            there, beside = (np.hstack(self.session.states(row[:1]).columns) for row in both)
            if np.isfinite(beside).all() and not np.isfinite(there).all():
                words = f"its batch returned numbers that are not finite, after step {steps}"
                raise EngineError(words, "not-finite")

    @property
    def _places(self) -> list[int]:
        """The indices of the compared places: the first, the middle and the last, each once."""
        worlds = self.begun.worlds
        return sorted({0, worlds // 2, worlds - 1})

    @property
    def _free(self) -> list[int]:
        """The indices of the places that are not compared, where worlds of odd scenes are put."""
        return [k for k in range(self.begun.worlds) if k not in self._places]

    def _batch(self, odd: Sequence[Scenario], ends: Sequence[int] = ()) -> _Motion:
        """Run a batch, and return the motions at the compared places.

        Parameters
        ----------
        odd : odd scenes, whose worlds fill in turn the places that are not compared; if empty, all
            worlds are of the same scene
        ends : numbers of steps after which snapshots are taken; chosen by `_ends` if empty
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
        """Return the numbers of steps after which worlds are compared: 1, 2, 4, 8, … and the last.

        The last is the number of steps in the window, or that which takes `BUDGET` seconds to
        compute, whichever is smaller.

        Parameters
        ----------
        scenes : the scenes of the batch, whose steps are timed for that
        """
        with closing(self.engine.open_batch(scenes, self.method, self.begun.timestep)) as batch:
            batch.advance(1)
            a_step = batch.timed(TRIED) / TRIED
        window = round(self.scenario.window.duration / self.begun.timestep)
        last = max(1, min(window, round(BUDGET / a_step)))
        return [1 << k for k in range(last.bit_length()) if 1 << k < last] + [last]

    def _alone(self, ends: Sequence[int]) -> _Motion:
        """Run one world in `session`, outside any batch; return its motion once for each place.

        Parameters
        ----------
        ends : numbers of steps after which snapshots are taken
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
    first, second : the motions, with snapshots after the same numbers of steps
    states : function that returns the states in snapshots
    ulp : relative spacing of the engine's floating-point numbers
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
    """Return n snapshots, which are states or arrays of numbers, as one array of n rows."""
    each = [np.hstack(one.columns) if isinstance(one, State) else one for one in snapshots]
    return np.asarray(each)


def _distance(first: State, second: State) -> float:
    """Return the largest distance of n states from n others in any quantity; inf if not finite.

    Each distance is relative to the quantity's size in `first`; where this is zero, the quantity is
    left out.

    Parameters
    ----------
    first, second : n states each
    """
    found = [0.0]
    for a, b in zip(first.columns, second.columns, strict=True):
        size, deviation = (np.linalg.norm(x, axis=1) for x in (a, b - a))
        apart = (size > 0) & (deviation != 0)
        found += (deviation[apart] / size[apart]).tolist()
    most = float(np.max(found))
    return most if math.isfinite(most) else math.inf


def _degrees(first: State, second: State) -> float:
    """Return the largest angle between the attitudes of n states and those of n others, degrees.

    It is infinite if a quaternion is not finite, or zero.

    Parameters
    ----------
    first, second : n states each
    """
    both = first.q_world_body_wxyz, second.q_world_body_wxyz
    if not all(np.isfinite(q).all() and q.any(axis=1).all() for q in both):
        return math.inf
    a, b = (Rotation.from_quat(q, scalar_first=True) for q in both)
    return math.degrees(float((a.inv() * b).magnitude().max()))


def _mujoco(scenario: Scenario, method: Method, timestep: float) -> tuple[str, float]:
    """Return MuJoCo's name with a method of similar order, and the wall time of its step, s.

    One world is stepped on one core.

    Parameters
    ----------
    method : the method with which MuJoCo's is compared
    timestep : s
    """
    mujoco = engines()["mujoco"]
    by = mujoco.method("RK4" if method.order > 1 else "Euler")
    with mujoco.open(scenario, by, timestep) as session:
        walls = [wall for _, wall in (session.timed(TIMED) for _ in range(TIMES))]
    return f"{mujoco.name} {by.name}", min(walls) / TIMED
