"""An engine whose steps take as long as a test says, by a clock that only they move."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np
import pytest
from quiet_session import QuietSession
from scene_texts import sphere_text
from spincheck.engines import BodyReading, Engine, EngineError, Method, Session, State, session
from spincheck.reports.harness.costs import step_cost as cost
from spincheck.scenarios import Scenario, loads

#: s; what the clocks can tell apart. A look takes a quarter of that.
RESOLUTION = 2.0**-22
METHOD = Method("turn", 1, 1, "turns", frozenset())
SCENE = loads(sphere_text(), "sphere")


@dataclass
class Clock:
    """CPU seconds, and seconds on the wall."""

    cpu: float = 0.0
    wall: float = 0.0
    resolution: float = RESOLUTION

    def process_time(self) -> float:
        self.cpu += self.resolution / 4
        return self.cpu // self.resolution * self.resolution

    def perf_counter(self) -> float:
        self.wall += self.resolution / 4
        return self.wall


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Put in place of the system's clocks."""
    made_up = Clock()
    monkeypatch.setattr(cost, "time", made_up)
    # Where a session times its own steps.
    monkeypatch.setattr(session, "time", made_up)
    cost.resolution.cache_clear()
    yield made_up
    cost.resolution.cache_clear()


@dataclass(eq=False)
class Clockwork(QuietSession):
    """Takes its time, and keeps a diary.

    Attributes
    ----------
    seconds : CPU seconds of the next steps, given how many they are and how many there were
    wall : seconds on the wall a CPU second
    drift : rad/s that every step adds to ω
    gives_up_after : steps
    """

    clock: Clock
    seconds: Callable[[int, int], float]
    wall: float = 1.0
    drift: float = 0.0
    gives_up_after: float = np.inf
    name: str = ""
    diary: list[tuple[str, str, int]] = field(default_factory=list)
    steps: int = 0

    def advance(self, steps: int) -> None:
        taken = self.seconds(steps, self.steps)
        self.clock.cpu += taken
        self.clock.wall += taken * self.wall
        self.steps += steps
        self.diary.append((self.name, "advance", steps))
        if self.steps > self.gives_up_after:
            raise EngineError("it gives up")

    def read_body(self) -> BodyReading:
        body = SCENE.body
        return BodyReading(body.mass, body.com, body.inertia_com)

    def read_state(self) -> State:
        self.diary.append((self.name, "read", 0))
        omega = np.array([0.0, 0.0, 1.0 + self.drift * self.steps])
        return State(np.array([1.0, 0.0, 0.0, 0.0]), omega, np.zeros(3), np.zeros(3))

    def check(self) -> None:
        self.diary.append((self.name, "check", 0))


def steadily(seconds_per_step: float) -> Callable[[int, int], float]:
    """Every step alike."""
    return lambda steps, _: steps * seconds_per_step


class Works(Engine):
    """Opens what it is given: a session, or for a test of what is left out, one by what is in."""

    name = "clockwork"
    version = "1"
    methods = (METHOD,)

    def __init__(
        self,
        make: Callable[[Collection[str]], Session],
        left_out: tuple[str, ...] = (),
    ) -> None:
        self._make, self._left_out = make, left_out

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        return self._make(())

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        return self._left_out

    def open_with(
        self, scenario: Scenario, method: Method, timestep: float, *, left_in=(), **_: object
    ) -> Session:
        return self._make(left_in)
