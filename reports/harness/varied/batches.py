"""Whether a world's motion depends on the worlds that are stepped with it, and what a step costs.

It must depend neither on the number of worlds, nor on its place, nor on its neighbours. The worlds
at the first, middle and last place are compared with the same world alone, with each other, and
with themselves beside neighbours of which one blows up, one is at rest, and one is another body.
"""

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from mpmath import mpf
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

#: Time that the steps of a batch may take, about, s; if steps are expensive, less than the window
#: is compared.
BUDGET = 10.0
#: Number of steps by which that time is estimated; number of MuJoCo's steps that are timed, and how
#: often.
TRIED, TIMED, TIMES = 10, 2000, 5
#: Spin of a neighbour that blows up, rad/s: it overflows in single precision at once, in double
#: precision after a few steps.
BLOWING_UP = 1e60
#: What a motion depends on if worlds differ without odd neighbours, or only beside all kinds
#: together.
NUMBER, PLACE, TOGETHER = "the number of worlds", "its place", "its neighbours together"


@dataclass(frozen=True)
class Apart:
    """How two runs of one world differ.

    Attributes
    ----------
    step : the first step at which they differ, among those compared, each twice the one before
    ulp : largest relative distance, at that step, of attitude, ω, position, velocity and spins
    degrees : angle between their attitudes at the end; infinite if one is not finite
    """

    step: int
    ulp: float
    degrees: float


@dataclass(frozen=True)
class BatchRow:
    """A batch with a number of worlds of one scene: what its motions depend on, and its cost.

    Attributes
    ----------
    device : the device that steps them; the one asked for if nothing was stepped
    steps : number of steps that are compared
    until : time of the last of these steps, s
    alone, place, neighbours : the largest difference from the world alone, between places, and
        of a world from itself beside other neighbours; None if the motions agree to the last bit
    has_neighbours : whether there is a place for neighbours
    because : what the motion depends on; empty if on nothing of its batch
    seconds_per_step : wall time of a step of all worlds
    beside : wall time of a step of `beside_by`, which steps one world on one core
    outcome, reason : ok; or unsupported or failed, and why nothing could be compared
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
    """Return `batch_of` run in another process; a crash, or too long a time, gives a row too."""
    answer = executor.call_at(engine.site, batch_of, scenario, engine, row)
    if isinstance(answer.value, CallFailed):
        return replace(row, outcome="failed", reason=answer.value.reason)
    return answer.value


def batch_of(scenario: Scenario, engine: Engine, row: BatchRow) -> BatchRow:
    """Compare and time a batch; `row` has its scene, engine, method, timestep, size and device."""
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
    try:
        engine.use_device(name)
    except UnsupportedError as error:
        return str(error)
    return ""


def neighbours_of(scenario: Scenario) -> dict[str, Scenario]:
    """Return scenes that are stepped beside a scene, by a description of each."""

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
    """Worlds at some places after some steps.

    `snapshots` has one entry for each of `ends`, with one snapshot for each place.
    """

    ends: Sequence[int]
    snapshots: Sequence[Sequence[object]]
    seconds_per_step: float = 0.0
    device: str = ""


@dataclass(frozen=True, eq=False)
class _Study:
    scenario: Scenario
    engine: Engine
    method: Method
    begun: BatchRow
    session: Session

    def row(self) -> BatchRow:
        """Return the row, from batches without odd neighbours, with all, or with each kind."""
        begun, odd = self.begun, neighbours_of(self.scenario)
        alike = self._batch(())
        alone = self._alone(alike.ends)
        apart = partial(_apart, states=self.session.states, ulp=self.engine.ulp)
        # Each place is compared with the first.
        first = replace(alike, snapshots=[[row[0]] * len(row) for row in alike.snapshots])
        by_number, by_place = apart(alone, first), apart(first, alike)
        because = [word for word, is_so in ((NUMBER, by_number), (PLACE, by_place)) if is_so]
        by_neighbours = None
        if self._free:
            by_neighbours = apart(alike, self._batch([*odd.values()], alike.ends))
        if by_neighbours:
            kinds = [
                name for name, one in odd.items() if apart(alike, self._batch([one], alike.ends))
            ]
            because += kinds or [TOGETHER]
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

    @property
    def _places(self) -> list[int]:
        """The first, middle and last place, each once."""
        worlds = self.begun.worlds
        return sorted({0, worlds // 2, worlds - 1})

    @property
    def _free(self) -> list[int]:
        """The places that a neighbour may have."""
        return [k for k in range(self.begun.worlds) if k not in self._places]

    def _batch(self, odd: Sequence[Scenario], ends: Sequence[int] = ()) -> _Motion:
        """Run a batch with odd neighbours in turn up to `ends`, chosen by their time if empty."""
        scenes = [self.scenario] * self.begun.worlds
        for number, place in enumerate(self._free if odd else ()):
            scenes[place] = odd[number % len(odd)]
        ends = ends or self._ends(scenes)
        with closing(self.engine.open_batch(scenes, self.method, self.begun.timestep)) as batch:
            snapshots, seconds = [], 0.0
            for steps in np.diff(ends, prepend=0).tolist():
                seconds += batch.timed(steps)
                snapshots.append(list(batch.snapshots(self._places)))
            return _Motion(ends, snapshots, seconds / ends[-1], batch.device)

    def _ends(self, scenes: Sequence[Scenario]) -> list[int]:
        """Return step counts: powers of two, and the window's steps or those there is time for."""
        with closing(self.engine.open_batch(scenes, self.method, self.begun.timestep)) as batch:
            batch.advance(1)
            a_step = batch.timed(TRIED) / TRIED
        window = round(self.scenario.window.duration / self.begun.timestep)
        last = max(1, min(window, round(BUDGET / a_step)))
        return [1 << k for k in range(last.bit_length()) if 1 << k < last] + [last]

    def _alone(self, ends: Sequence[int]) -> _Motion:
        """Run the world in a session of its own, as if it were at every place."""
        snapshots: list[object] = []
        self.session.record(np.diff(ends, prepend=0).tolist(), snapshots.append)
        return _Motion(ends, [[one] * len(self._places) for one in snapshots])


def _apart(
    first: _Motion, second: _Motion, states: Callable[[Sequence[object]], State], ulp: float
) -> Apart | None:
    """Return the largest difference of two motions over places; None if their bits agree."""
    same = [
        np.array_equal(np.asarray(a), np.asarray(b), equal_nan=True)
        for a, b in zip(first.snapshots, second.snapshots, strict=True)
    ]
    if all(same):
        return None
    began = same.index(False)
    distance = _distance(states(first.snapshots[began]), states(second.snapshots[began]))
    degrees = _degrees(states(first.snapshots[-1]), states(second.snapshots[-1]))
    return Apart(first.ends[began], distance / ulp, degrees)


def _distance(first: State, second: State) -> float:
    """Return the largest relative distance of a quantity over all rows; infinite if not finite."""
    found = [0.0]
    for a, b in zip(first.columns, second.columns, strict=True):
        size, off = (np.linalg.norm(x, axis=1) for x in (a, b - a))
        apart = (size > 0) & (off != 0)
        found += (off[apart] / size[apart]).tolist()
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
    """Return a MuJoCo method of similar order, and the wall time of its step on one core, s."""
    mujoco = engines()["mujoco"]
    by = mujoco.method("RK4" if method.order > 1 else "Euler")
    with mujoco.open(scenario, by, timestep) as session:
        walls = [wall for _, wall in (session.timed(TIMED) for _ in range(TIMES))]
    return f"{mujoco.name} {by.name}", min(walls) / TIMED
