"""Clean sessions step without the clock of MuJoCo's Python package, as-shipped ones with it."""

import ctypes
from collections.abc import Iterator

import pytest
from case_loops import each_case
from spincheck.engines.adapters.mujoco import clock
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.mujoco.session import MuJoCoSession
from spincheck.suite.contract_scenes import SCENES

ENGINE = MuJoCo()
SCENE = SCENES["heavy-top"]
TIMESTEP = 1e-3
STEPS = 10


class CountingClock:
    """Hung into MuJoCo in place of its package's clock: counts how often it is read."""

    def __init__(self) -> None:
        self.reads = 0
        self._function = ctypes.CFUNCTYPE(ctypes.c_double)(self._read)
        self.address = ctypes.cast(self._function, ctypes.c_void_p).value

    def _read(self) -> float:
        self.reads += 1
        return 0.0

    def read_by(self, session: MuJoCoSession) -> int:
        """How often some steps of a session read it."""
        before = self.reads
        session.advance(STEPS)
        return self.reads - before


@pytest.fixture
def counting(monkeypatch: pytest.MonkeyPatch) -> Iterator[CountingClock]:
    shipped = clock.SHIPPED
    counter = CountingClock()
    monkeypatch.setattr(clock, "SHIPPED", counter.address)
    yield counter
    clock.hang(shipped)


def opened(method: str) -> MuJoCoSession:
    return ENGINE.open(SCENE, ENGINE.method(method), TIMESTEP)


CLEAN = [method.name for method in ENGINE.methods if not (method.as_shipped or method.requires)]


@each_case("method", CLEAN)
def test_sessions_of_both_kinds_may_be_stepped_in_turn(
    counting: CountingClock, method: str
) -> None:
    """A clean method reads no clock; as shipped it is read many times a step."""
    with opened(method) as clean, opened("default") as shipped:
        reads = [counting.read_by(session) for session in (clean, shipped, clean, shipped)]
    assert [count and count > 10 * STEPS for count in reads] == [0, True, 0, True]


def test_the_audit_reads_the_clock_of_the_session_that_is_asked() -> None:
    with opened("Euler") as clean, opened("default") as shipped:
        for session in (clean, shipped):
            session.advance(1)
        assert clock.CLOCK not in clean.active()
        assert clock.CLOCK in shipped.active()


def test_a_session_that_is_closed_leaves_the_clock_hung_in() -> None:
    with opened("Euler") as session:
        session.advance(1)
        assert not clock.is_hung()
    assert clock.is_hung()
