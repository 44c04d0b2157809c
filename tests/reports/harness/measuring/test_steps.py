"""Single steps that are taken in one batch are those of sessions, to the last bit.

Verified: a made-up engine, with and without settling; those of the installed engines that restart
batches, on three scenes.
"""

from collections.abc import Sequence

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from library_scenes import library_scene
from spincheck.engines import Batch, Engine, EngineError, Method, Session, State, UnsupportedError
from spincheck.reference import ExactMotion
from spincheck.reports.harness.measuring.places import places
from spincheck.reports.harness.measuring.steps import Steps, sessions_of, steps_from
from spincheck.scenarios import FloatArray, Scenario
from spincheck.suite.contract_scenes import SCENES
from stepped import Stepped, SteppedEngine

HEAVY = library_scene("nutation-loops")


class Row(Batch):
    """Sessions in a row, each stepped by itself."""

    def __init__(self, sessions: Sequence[Session]) -> None:
        self.sessions, self.is_open = sessions, True

    def restart(self, states: State, timestep: float) -> None:
        for k, session in enumerate(self.sessions):
            session.restart(states.rows(k), timestep)

    def advance(self, steps: int) -> None:
        for session in self.sessions:
            session.advance(steps)

    def snapshots(self, places: Sequence[int]) -> list[object]:
        return [self.sessions[place].snapshot() for place in places]

    def close(self) -> None:
        self.is_open = False


class Batched(SteppedEngine):
    """Restarts batches; its own sessions are never restarted."""

    has_batches = restarts_batches = True

    def __init__(self) -> None:
        super().__init__(Stepped)
        self.batches: list[Row] = []

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        session = super().open(scenario, method, timestep)
        session.restart = None
        return session

    def open_batch(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Row:
        opened = [super(Batched, self).open(one, method, timestep) for one in scenarios]
        self.batches.append(Row(opened))
        return self.batches[-1]


def taken(engine: Engine, method: str, scene: Scenario, settle: int) -> Steps:
    at = places(scene, ExactMotion(scene).outline(scene.times), None)
    timesteps: FloatArray = at.timesteps[:3]
    with sessions_of(engine, engine.method(method), scene, float(timesteps[0])) as sessions:
        return steps_from(sessions, at.states.rows(slice(9)), timesteps, settle)


def assert_the_same(first: Steps, second: Steps) -> None:
    for one, other in ((first.before, second.before), (first.after, second.after)):
        for a, b in zip(one.columns, other.columns, strict=True):
            assert np.array_equal(a, b)


@pytest.mark.parametrize("settle", [0, 5])
def test_steps_are_taken_in_one_batch_which_is_closed(settle: int) -> None:
    engine = Batched()
    found = taken(engine, "RK4", HEAVY, settle)
    assert_the_same(found, taken(SteppedEngine(Stepped), "RK4", HEAVY, settle))
    (batch,) = engine.batches
    assert len(batch.sessions) == 9
    assert not batch.is_open


def test_a_batch_is_closed_if_a_step_raises() -> None:
    class Raises(Row):
        def restart(self, states: State, timestep: float) -> None:
            raise EngineError("no longer finite")

    engine = Batched()
    engine.open_batch = lambda *_: engine.batches.append(Raises([])) or engine.batches[-1]
    with pytest.raises(EngineError, match="no longer finite"):
        taken(engine, "RK4", HEAVY, 0)
    assert not engine.batches[0].is_open


@pytest.mark.slow
@each_case("name", ["newton", "mujoco-warp", "genesis"])
def test_batches_of_engines_step_as_their_sessions_do(name: str) -> None:
    engine = installed(name)
    assert engine.restarts_batches
    compared = 0
    for method in engine.methods:
        for scene in (SCENES[one] for one in ("heavy-top", "free-drag", "free-torque-world")):
            if engine.unsupported(scene, method) or method.as_shipped:
                continue
            try:
                together = taken(engine, method.name, scene, 3)
            except UnsupportedError:
                continue
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(type(engine), "restarts_batches", False)
                one_by_one = taken(engine, method.name, scene, 3)
            assert_the_same(together, one_by_one)
            compared += 1
    assert compared
