"""Each planted fault of an engine is detected by the check of the contract made for it."""

from dataclasses import replace

import numpy as np
import pytest
from adapter_checks import CHECKS, Check
from interface_1.free_body.toy_engine import Toy, ToySession
from planted import LyingAboutBodySession, LyingAboutStartSession
from spincheck.engines import Engine, Method, Session, State
from spincheck.scenarios import Scenario
from spincheck.suite import test_adapter

pytestmark = pytest.mark.slow

RANDOM = np.random.default_rng(3)


class GravityUncalledFor(ToySession):
    """Says so, too."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.gravity = self.gravity - [0.0, 0.0, 9.81]


class GravityInSecret(GravityUncalledFor):
    def active(self) -> frozenset[str]:
        return frozenset({"gravity"} if (self.gravity != [0.0, 0.0, -9.81]).any() else ())


class GravityLeftOut(ToySession):
    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.gravity = np.zeros(3)


class DegreesPerSecond(ToySession):
    """Takes ω for degrees a second where it turns the attitude."""

    def rates(self, y):
        rates = super().rates(y)
        return np.concatenate([np.deg2rad(rates[:4]), rates[4:]])


class WorldOmega(ToySession):
    """Takes ω along the body's axes for one along the world's."""

    def rates(self, y):
        w, v, omega = y[0], y[1:4], y[4:7]
        turning = np.concatenate([[-v @ omega], w * omega - np.cross(v, omega)]) / 2
        return np.concatenate([turning, super().rates(y)[4:]])


class FirstOrder(ToySession):
    def advance(self, steps: int) -> None:
        for _ in range(steps):
            self.y = self.y + self.timestep * self.rates(self.y)
            self.y[:4] /= np.linalg.norm(self.y[:4])


class Noisy(ToySession):
    def advance(self, steps: int) -> None:
        super().advance(steps)
        self.y *= 1 + 1e-15 * RANDOM.normal()


class OneStepShort(ToySession):
    """Of a call of many steps it takes one too few."""

    def advance(self, steps: int) -> None:
        super().advance(steps if steps < 100 else steps - 1)


class DisturbedByReading(ToySession):
    def read_state(self) -> State:
        state = super().read_state()
        self.y[4:7] *= 1 + 1e-15
        return state


class SharesItsState(ToySession):
    """One array for all sessions that are open."""

    everybodys = np.zeros(13)

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.everybodys[:] = self.y

    def advance(self, steps: int) -> None:
        self.y = self.everybodys.copy()
        super().advance(steps)
        self.everybodys[:] = self.y


class GivesItsOwnArrays(ToySession):
    """Reads out views of what the next step writes to."""

    def advance(self, steps: int) -> None:
        before = self.y
        super().advance(steps)
        before[:] = self.y
        self.y = before

    def read_state(self) -> State:
        return State(*np.split(self.y, (4, 7, 10)))


class ReadsIntoOneBuffer(ToySession):
    """Reads out views of an array that each session fills again when it is read."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.buffer = np.zeros(13)

    def read_state(self) -> State:
        self.buffer[:] = self.y
        return State(*np.split(self.buffer, (4, 7, 10)))


class ReadsIntoEverybodysBuffer(ReadsIntoOneBuffer):
    """The same with one array for all sessions."""

    shared = np.zeros(13)

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.buffer = self.shared


class RecordsAStepLate(ToySession):
    def record(self, strides, keep) -> None:
        for steps in strides:
            if steps:
                self.advance(steps - 1)
            keep(self.snapshot())
            if steps:
                self.advance(1)


class RestartForgetsOmega(ToySession):
    """Restarts at its new attitude and place, with the ω it had."""

    kept = "omega_body", slice(4, 7)

    def restart(self, state: State, timestep: float | None = None) -> None:
        name, numbers = self.kept
        old = {name: self.y[numbers].copy()} if hasattr(self, "y") else {}
        super().restart(replace(state, **old), timestep)


class RestartKeepsVelocity(RestartForgetsOmega):
    """The same with its velocity."""

    kept = "velocity_world", slice(10, 13)


class RestartKeepsTimestep(ToySession):
    """Restarts with the timestep it was opened with."""

    def restart(self, state: State, timestep: float | None = None) -> None:
        super().restart(state)


class RestartIsWarm(ToySession):
    """Reads back as it was restarted, and moves on a little as it did before."""

    memory = 0.0

    def advance(self, steps: int) -> None:
        super().advance(steps)
        self.y[4:7] += self.memory
        self.memory = 1e-14 * self.y[4]


FAULTS: list[tuple[type[Session], Check]] = [
    (LyingAboutBodySession, test_adapter.test_holds_the_scene_and_only_its_effects_act),
    (LyingAboutStartSession, test_adapter.test_holds_the_scene_and_only_its_effects_act),
    (GravityUncalledFor, test_adapter.test_holds_the_scene_and_only_its_effects_act),
    (GravityInSecret, test_adapter.test_begins_as_the_equations_of_motion_say),
    (GravityLeftOut, test_adapter.test_holds_the_scene_and_only_its_effects_act),
    (GravityLeftOut, test_adapter.test_begins_as_the_equations_of_motion_say),
    (DegreesPerSecond, test_adapter.test_begins_as_the_equations_of_motion_say),
    (WorldOmega, test_adapter.test_begins_as_the_equations_of_motion_say),
    (FirstOrder, test_adapter.test_order_of_accuracy),
    (Noisy, test_adapter.test_repeats_to_the_last_bit),
    (OneStepShort, test_adapter.test_many_steps_at_once_equal_single_steps),
    (DisturbedByReading, test_adapter.test_reading_does_not_disturb),
    (SharesItsState, test_adapter.test_shares_no_memory_between_sessions),
    (GivesItsOwnArrays, test_adapter.test_shares_no_memory_between_sessions),
    (ReadsIntoOneBuffer, test_adapter.test_shares_no_memory_between_sessions),
    (ReadsIntoEverybodysBuffer, test_adapter.test_shares_no_memory_between_sessions),
    (RecordsAStepLate, test_adapter.test_records_what_it_reads),
    (RestartForgetsOmega, test_adapter.test_restarts_as_it_opens),
    (RestartKeepsVelocity, test_adapter.test_restarts_as_it_opens),
    (RestartKeepsTimestep, test_adapter.test_restarts_as_it_opens),
    (RestartIsWarm, test_adapter.test_restarts_as_it_opens),
]


def toy_of(kind: type[Session]) -> Engine:
    class Lying(Toy):
        def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
            return kind(scenario, timestep)

    return Lying()


@pytest.mark.parametrize(
    ("kind", "check"), [pytest.param(k, c, id=f"{k.__name__}-{c.__name__}") for k, c in FAULTS]
)
def test_a_planted_fault_is_caught(kind: type[Session], check: Check) -> None:
    engine = toy_of(kind)
    with pytest.raises(pytest.fail.Exception, match="toy RK4"):
        check(engine, engine.methods[0])


def test_a_method_that_is_another_by_name_only_is_caught() -> None:
    class Twice(Toy):
        methods = (Toy.methods[0], replace(Toy.methods[0], name="RK45"))

    engine = Twice()
    with pytest.raises(pytest.fail.Exception, match="it never differs from RK45"):
        test_adapter.test_differs_from_every_other_method(engine, engine.methods[0])


def test_a_method_that_is_better_than_declared_is_reported_so() -> None:
    class Modest(Toy):
        methods = (replace(Toy.methods[0], order=2, attitude_order=2),)

    engine = Modest()
    with pytest.raises(pytest.fail.Exception, match="declared are less"):
        test_adapter.test_order_of_accuracy(engine, engine.methods[0])


def test_a_method_that_can_simulate_nothing_is_caught() -> None:
    class Idle(Toy):
        methods = (replace(Toy.methods[0], requires=frozenset({"pivot"})),)

    engine = Idle()
    for check in CHECKS[:-1]:
        with pytest.raises(pytest.fail.Exception, match="none of the contract's scenes"):
            check(engine, engine.methods[0])


def test_every_check_catches_something() -> None:
    assert {check for _, check in FAULTS} | {
        test_adapter.test_differs_from_every_other_method
    } == set(CHECKS)
