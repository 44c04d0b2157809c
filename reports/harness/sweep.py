"""Runs what is missing of a sweep, on whatever executes calls: local workers or a cluster.

One call makes all the points of a place: its scene is solved once, and a call costs little beside
them. Where such a call is lost, its points are run one by one, so that a crash costs one.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from queue import SimpleQueue

from ...scenarios import Scenario
from ..results.environment import environment
from ..results.fingerprints import digests
from ..results.store import Store
from ..results.sweep_records import Ensemble, Map, Point
from ..results.sweep_tables import NO_SCENE
from .choice import Choice
from .executors.worker_slot import Lost
from .sweep_points import Place, places
from .sweep_run import Pair, lost_point, run_place

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Left:
    """A place, and the methods whose points are missing there."""

    place: Place
    pairs: Sequence[Pair]


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """What is left of a sweep.

    Attributes
    ----------
    there : places that are complete
    """

    left: list[Left]
    there: int

    def __str__(self) -> str:
        """What is used again, in words; empty where that is nothing."""
        total = len(self.left) + self.there
        return f"{self.there} of {total} points are there already" if self.there else ""


def plan_sweep(asked: Map | Ensemble, base: Scenario, choice: Choice, store: Store) -> SweepPlan:
    """Record what is asked for, drop what is out of date, and see what is missing."""
    store.keep_made_by(base.name, digests(base, choice.engines))
    store.put_environment(environment(choice.engines))
    store.put_methods(choice.engines)
    store.sweeps.put(asked, base)
    pairs = [(engine, method.name) for engine, method in choice.pairs()]
    there = store.sweeps.there(base.name, choice.time_limit)
    left, total = [], 0
    for place in places(asked):
        total += 1
        known = there.get(place.known_by, set())
        missing = [pair for pair in pairs if not {(pair[0].name, pair[1]), NO_SCENE} & known]
        if missing:
            left.append(Left(place, missing))
    return SweepPlan(left, total - len(left))


def carry_out_sweep(
    plan: SweepPlan, base: Scenario, store: Store, executor: Executor, progress: Progress
) -> None:
    """Run what is left, storing every point as soon as it is there."""
    sweep = _Sweep(base, store, executor, progress)
    for left in plan.left:
        sweep.start(left)
    sweep.drain()


@dataclass(frozen=True, eq=False)
class _Call:
    """A call under way.

    Attributes
    ----------
    pairs : methods it runs; none where it only solves the scene
    lost : how the call went that this one is to find out about; None for the first one of a place
    """

    left: Left
    pairs: Sequence[Pair]
    lost: Lost | None = None


class _Sweep:
    """The calls under way, and what to do when each ends."""

    def __init__(
        self, base: Scenario, store: Store, executor: Executor, progress: Progress
    ) -> None:
        self._base = base
        self._store = store
        self._executor = executor
        self._progress = progress
        self._under_way: dict[Future[list[Point]], _Call] = {}
        self._done: SimpleQueue[Future[list[Point]]] = SimpleQueue()

    def start(self, left: Left) -> None:
        """Run what is missing of a place."""
        self._submit(_Call(left, left.pairs))

    def drain(self) -> None:
        """Store what comes back, until nothing is under way."""
        while self._under_way:
            future = self._done.get()
            call = self._under_way.pop(future)
            try:
                points = future.result()
            except Lost as lost:
                self._look_into(call, lost)
                continue
            if call.pairs:
                self._put(call.left, points)
            else:
                self._blame_methods(call)

    def _submit(self, call: _Call) -> None:
        base = self._base
        future = self._executor.submit(run_place, base.text, base.name, call.left.place, call.pairs)
        self._under_way[future] = call
        future.add_done_callback(self._done.put)

    def _look_into(self, call: _Call, lost: Lost) -> None:
        """A call gave no result: see whether it can solve the scene alone, and run each method."""
        if call.lost is None:
            self._submit(_Call(call.left, (), lost))
            return
        if not call.pairs:
            reason = f"the reference could not be solved: {lost.reason}"
            lost, call = Lost(reason, "unsolved"), replace(call, pairs=call.left.pairs)
        self._put(call.left, [self._lost(call.left, pair, lost) for pair in call.pairs])

    def _blame_methods(self, call: _Call) -> None:
        """The scene can be solved: it was a method that took the process with it."""
        assert call.lost is not None
        if len(call.left.pairs) == 1:
            self._put(call.left, [self._lost(call.left, call.left.pairs[0], call.lost)])
            return
        for pair in call.left.pairs:
            self._submit(_Call(Left(call.left.place, [pair]), [pair], call.lost))

    def _lost(self, left: Left, pair: Pair, lost: Lost) -> Point:
        return lost_point(self._base.text, self._base.name, left.place, pair, lost)

    def _put(self, left: Left, points: list[Point]) -> None:
        self._store.sweeps.put_points(left.place, points)
        self._progress(str(left.place))
