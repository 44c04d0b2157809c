"""A batch by which a world's motion depends on it is found out, with what it depends on.

Verified: planted dependence on number, place and each kind of neighbour, with its size; that of the
installed engines' batches each world holds its own body and start.
Not verified: GPUs, of which a made-up engine stands for one; times, but that they are there.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from quiet_session import QuietSession
from spincheck.engine import (
    Batch,
    BodyReading,
    Engine,
    EngineError,
    FloatArray,
    Method,
    Scenario,
    State,
    UnsupportedError,
)
from spincheck.engines.checks.read_back import stacked
from spincheck.reports.harness.varied.batches import (
    NUMBER,
    PLACE,
    TOGETHER,
    BatchRow,
    batch_of,
    neighbours_of,
)
from spincheck.suite.contract_scenes import SCENES

TIMESTEP, WORLDS = 2.0**-6, 8
#: rad, by which a planted fault turns a world too far whenever it is stepped.
FAULT = 2.0**-20
#: Whether a world turns too far, by its place and the rates of all worlds, rad/s.
Fault = Callable[[int, FloatArray], bool]
SCENE = SCENES["free"]
ROW = BatchRow(SCENE.name, "turning", "exact", TIMESTEP, WORLDS)
RATE = float(SCENE.start.omega_body[2])


class Turning(QuietSession):
    """A body that turns about z at the rate at which it starts."""

    def __init__(self, rate: float) -> None:
        self.numbers = np.array([0.0, rate])

    def advance(self, steps: int) -> None:
        self.numbers[0] += steps * TIMESTEP * self.numbers[1]

    def snapshot(self) -> FloatArray:
        return self.numbers.copy()

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        angle, rate = np.array(snapshots).T
        still = np.zeros((len(angle), 3))
        omega = np.stack([0 * rate, 0 * rate, rate], axis=1)
        q = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
        return State(q, omega, still, still)

    def read_body(self) -> BodyReading:
        raise NotImplementedError

    def read_state(self) -> State:
        raise NotImplementedError


class TurningBatch(Batch):
    def __init__(self, rates: Sequence[float], fault: Fault) -> None:
        self.worlds = [Turning(rate) for rate in rates]
        self.faulty = [k for k in range(len(rates)) if fault(k, np.array(rates))]

    def advance(self, steps: int) -> None:
        for world in self.worlds:
            world.advance(steps)
        for k in self.faulty:
            self.worlds[k].numbers[0] += FAULT

    def snapshots(self, places: Sequence[int]) -> list[FloatArray]:
        return [self.worlds[place].snapshot() for place in places]

    def close(self) -> None:
        pass


class TurningEngine(Engine):
    interface = 2
    name = version = "turning"
    methods = (Method("exact", 1, 1, "made up", frozenset()),)

    def __init__(self, fault: Fault = lambda *_: False) -> None:
        self.fault = fault

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Turning:
        return Turning(float(scenario.start.omega_body[2]))

    def open_batch(
        self, scenarios: Sequence[Scenario], method: Method, timestep: float
    ) -> TurningBatch:
        rates = [float(scenario.start.omega_body[2]) for scenario in scenarios]
        return TurningBatch(rates, self.fault)


class OnDevices(TurningEngine):
    """Steps on what it is told to; its only other device is there."""

    def use_device(self, name: str) -> None:
        if name != "made-up:0":
            raise UnsupportedError(f"there is no device '{name}'")
        TurningBatch.device = f"a device ({name})"


def is_another(rates: FloatArray) -> FloatArray:
    return (rates != RATE) & (rates != 0) & (np.abs(rates) < 1e9)


@each_case(
    ("engine", "asked", "outcome", "device"),
    [
        (TurningEngine(), "CPU", "ok", "CPU"),
        (OnDevices(), "CPU", "ok", "CPU"),
        (OnDevices(), "made-up:0", "ok", "a device (made-up:0)"),
        (OnDevices(), "made-up:1", "unsupported", "made-up:1"),
        (TurningEngine(), "made-up:0", "unsupported", "made-up:0"),
    ],
)
def test_a_batch_is_stepped_where_asked_and_its_row_names_the_device(
    monkeypatch: pytest.MonkeyPatch, engine: Engine, asked: str, outcome: str, device: str
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(TurningBatch, "device", Batch.device)
        row = batch_of(SCENE, engine, replace(ROW, device=asked))
    assert (row.outcome, row.device) == (outcome, device)
    assert bool(row.reason) == (outcome != "ok")
    assert not row.reason or asked in row.reason


@each_case("name", ["newton", "mujoco-warp"])
def test_warp_says_which_devices_there_are(name: str) -> None:
    with pytest.raises(UnsupportedError, match=r"no device 'cuda:99' here; Warp has cpu"):
        installed(name).use_device("cuda:99")


FAULTS: dict[str, Fault] = {
    NUMBER: lambda _, rates: len(rates) > 1,
    PLACE: lambda place, rates: place == len(rates) - 1 > 0,
    "one that blows up": lambda _, rates: (np.abs(rates) > 1e9).any(),
    "one at rest": lambda _, rates: (rates == 0).any(),
    TOGETHER: lambda _, rates: (rates == 0).any() and is_another(rates).any(),
    "another body": lambda _, rates: is_another(rates).any(),
}


@each_case(("what", "fault"), [*FAULTS.items()])
def test_what_a_motion_depends_on_is_named_with_its_size(what: str, fault: Fault) -> None:
    row = batch_of(SCENE, TurningEngine(fault), ROW)
    assert row.because == (what,), what
    apart = {NUMBER: row.alone, PLACE: row.place}.get(what, row.neighbours)
    assert apart is not None
    assert apart.step == 1
    # Half an angle in the quaternion.
    assert apart.ulp == pytest.approx(FAULT / 2 / TurningEngine().ulp, rel=1e-3)
    looked_at = len(bin(row.steps - 1)) - 1
    assert np.radians(apart.degrees) == pytest.approx(looked_at * FAULT, rel=1e-3)


def test_worlds_that_depend_on_nothing_have_the_same_bits() -> None:
    row = batch_of(SCENE, TurningEngine(), ROW)
    assert (row.because, row.alone, row.place, row.neighbours) == ((), None, None, None)
    assert row.has_neighbours
    assert row.until == SCENE.window.duration
    assert row.seconds_per_step
    assert row.beside


class OfStates(Turning):
    """Its snapshots are states, as those of a session that does not say otherwise."""

    def snapshot(self) -> State:
        return super().states([self.numbers]).rows(0)

    def states(self, snapshots: Sequence[State]) -> State:
        return stacked(snapshots)


class EngineOfStates(TurningEngine):
    def open(self, scenario: Scenario, method: Method, timestep: float) -> OfStates:
        return OfStates(float(scenario.start.omega_body[2]))

    def open_batch(
        self, scenarios: Sequence[Scenario], method: Method, timestep: float
    ) -> TurningBatch:
        batch = super().open_batch(scenarios, method, timestep)
        batch.worlds = [self.open(scenario, method, timestep) for scenario in scenarios]
        return batch


@each_case(("fault", "because"), [(lambda *_: False, ()), (FAULTS[PLACE], (PLACE,))])
def test_snapshots_may_be_states(fault: Fault, because: tuple[str, ...]) -> None:
    row = batch_of(SCENE, EngineOfStates(fault), ROW)
    assert (row.outcome, row.because) == ("ok", because)


def test_a_batch_that_gives_too_few_snapshots_is_not_said_to_move_otherwise() -> None:
    class Short(TurningBatch):
        def snapshots(self, places: Sequence[int]) -> list[FloatArray]:
            return super().snapshots(places[:-1])

    engine = TurningEngine()
    engine.open_batch = lambda scenarios, *_: Short([RATE] * len(scenarios), engine.fault)
    row = batch_of(SCENE, engine, ROW)
    assert (row.outcome, row.because) == ("failed", ())
    assert row.reason.startswith("its batch gave ")


def test_a_world_that_is_no_longer_finite_is_infinitely_far() -> None:
    class Lost(TurningBatch):
        def advance(self, steps: int) -> None:
            super().advance(steps)
            self.worlds[-1].numbers[0] = np.nan

    engine = TurningEngine()
    engine.open_batch = lambda scenarios, *_: Lost([RATE] * len(scenarios), engine.fault)
    row = batch_of(SCENE, engine, replace(ROW, worlds=2))
    assert row.because == (PLACE,)
    assert row.place is not None
    assert row.place.degrees == row.place.ulp == np.inf
    assert not row.has_neighbours


@each_case("since", [1, 8])
def test_a_batch_that_is_not_finite_where_a_world_alone_is_depends_on_nothing(since: int) -> None:
    class NotFinite(TurningBatch):
        taken = 0

        def advance(self, steps: int) -> None:
            super().advance(steps)
            self.taken += steps
            for world in self.worlds:
                world.numbers[0] = world.numbers[0] if self.taken < since else np.nan

    engine = TurningEngine()
    engine.open_batch = lambda scenarios, *_: NotFinite([RATE] * len(scenarios), engine.fault)
    row = batch_of(SCENE, engine, ROW)
    assert (row.outcome, row.because) == ("failed", ())
    assert row.reason == f"its batch returned numbers that are not finite, after step {since}"


def test_worlds_that_blow_up_alone_as_in_their_batch_have_the_same_bits() -> None:
    class Lost(Turning):
        def snapshot(self) -> FloatArray:
            return super().snapshot() * np.nan

    engine = TurningEngine()
    engine.open = lambda *_: Lost(RATE)
    engine.open_batch = lambda scenarios, *_: batch(len(scenarios))

    def batch(count: int) -> TurningBatch:
        made = TurningBatch([RATE] * count, engine.fault)
        made.worlds = [Lost(RATE) for _ in range(count)]
        return made

    row = batch_of(SCENE, engine, ROW)
    assert (row.outcome, row.because) == ("ok", ())


def test_a_neighbour_that_stops_all_worlds_is_named() -> None:
    class Stops(TurningBatch):
        def advance(self, steps: int) -> None:
            if any(abs(world.numbers[1]) > 1e9 for world in self.worlds):
                raise EngineError("no longer finite")
            super().advance(steps)

    engine = TurningEngine()
    engine.open_batch = lambda scenarios, *_: Stops(
        [float(scenario.start.omega_body[2]) for scenario in scenarios], engine.fault
    )
    row = batch_of(SCENE, engine, ROW)
    assert row.because == ("one that blows up, which stops all worlds",)
    assert (row.alone, row.place) == (None, None)
    assert row.neighbours is not None
    assert row.neighbours.degrees == row.neighbours.ulp == np.inf


@pytest.mark.slow
@each_case(
    ("name", "method"), [("mujoco-warp", "RK4"), ("newton", "mujoco-rk4"), ("mjx-float32", "Euler")]
)
def test_each_world_has_its_own_body_and_start(name: str, method: str) -> None:
    engine, scene = installed(name), SCENES["heavy-top"]
    one, odd = engine.method(method), neighbours_of(scene)
    worlds = [scene, *odd.values(), scene]
    batch = engine.open_batch(worlds, one, TIMESTEP)
    batch.advance(3)
    found = list(batch.snapshots(range(len(worlds))))
    batch.close()
    assert not np.isfinite(found[1]).all(), "it does not blow up"
    for k in (0, 2, 3, 4):
        with engine.open(worlds[k], one, TIMESTEP) as session:
            session.advance(3)
            alone = np.asarray(session.snapshot(), dtype=float)
            off = np.abs(np.asarray(found[k], dtype=float) - alone)
            # MJX's loop over worlds is compiled otherwise: some roundings of the largest number.
            assert off.max() <= 64 * engine.ulp * np.abs(alone).max(), (name, k)
