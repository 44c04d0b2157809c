"""The sampling loop: the samples and the cause of runs that end early.

The engines here are made up: a body that spins about z at one radian a second, and a fault.
"""

from dataclasses import replace

import numpy as np
import pytest
from quiet_session import QuietSession
from spincheck.engines import BodyReading, Engine, EngineError, Fault, Method, Run, State
from spincheck.engines.checks.faults import Bounds
from spincheck.engines.sampling import BLOCK, BLOCK_STEPS, FIRST_BLOCK, sample
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import scene

TIMESTEP = 0.125
SPIN = "\nquaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\nomega_body = [0.0, 0.0, 1.0]\n"
SCENE = scene("spin", start=SPIN)
STRIDE = 2
SAMPLES = np.arange(0, STRIDE * BLOCK + 40, STRIDE)
#: Steps after which a faulty one goes wrong: in the first block, and in the second.
EARLY, LATE = 21, STRIDE * BLOCK + 21
MOST_TURN = 0.5
METHOD = Method("turn", 1, 1, "turns", frozenset(), max_rotation_per_step=MOST_TURN)


class Turning(QuietSession):
    """The faultless one."""

    def __init__(self, fault_after: int) -> None:
        self.steps, self.fault_after = 0, fault_after

    @property
    def is_wrong(self) -> bool:
        return self.steps >= self.fault_after

    def read_body(self) -> BodyReading:
        return BodyReading(SCENE.body.mass, SCENE.body.com, SCENE.body.inertia_com)

    def read_state(self) -> State:
        half = self.steps * TIMESTEP / 2
        q = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
        return State(q, np.array([0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))

    def advance(self, steps: int) -> None:
        self.steps += steps


class Warns(Turning):
    def check(self) -> None:
        if self.is_wrong:
            raise EngineError("it warns")


class Misread(Turning):
    """Reads a number that it should not."""

    column, value = "omega_body", np.nan

    def read_state(self) -> State:
        state = super().read_state()
        if self.is_wrong:
            getattr(state, self.column)[0] = self.value
        return state


class NotFinite(Misread):
    pass


class Infinite(Misread):
    column, value = "com_world", np.inf


class TooFast(Misread):
    value = 1.5 * MOST_TURN / TIMESTEP


class NoRotation(Misread):
    column, value = "q_world_body_wxyz", 2.0


class BlownUpInAStep(Turning):
    """Stops in the middle of its steps, its state no number."""

    stopped = False

    def advance(self, steps: int) -> None:
        super().advance(steps)
        if self.is_wrong:
            self.stopped = True
            raise EngineError("a step was not possible")

    def read_state(self) -> State:
        state = super().read_state()
        if self.stopped:
            state.omega_body[:] = np.nan
        return state


class GaveUpInAStep(Turning):
    """Stops for a reason of its own: the motion is in order."""

    error: Exception = EngineError("out of memory")

    def advance(self, steps: int) -> None:
        super().advance(steps)
        if self.is_wrong:
            raise self.error


class KeptTheLastState(GaveUpInAStep):
    """Stops as its accelerations are no numbers; its state is that of before."""

    error = EngineError("accelerations are nan", "not-finite")


class GaveUpWithASpin(GaveUpInAStep):
    """The same, with a part that turns."""

    def read_state(self) -> State:
        return replace(super().read_state(), spins=np.ones(1))


class Buggy(GaveUpInAStep):
    error = ZeroDivisionError("a bug")


class BuggyWithoutWords(GaveUpInAStep):
    error = AssertionError()


class LateFault(Turning):
    """Takes snapshots without looking, and finds its fault in them later."""

    def snapshot(self) -> tuple[State, bool]:
        return self.read_state(), self.is_wrong

    def states(self, snapshots: list[tuple[State, bool]]) -> State:
        return super().states([state for state, _ in snapshots])

    def first_fault(self, snapshots: list[tuple[State, bool]], states: State) -> Fault | None:
        wrong = [is_wrong for _, is_wrong in snapshots]
        return Fault(wrong.index(True), "reset", "it was reset") if any(wrong) else None


class Spinner(Engine):
    name = "spinner"
    version = "1"
    methods = (METHOD,)

    def __init__(self, kind: type[Turning], fault_after: int) -> None:
        self.kind, self.fault_after = kind, fault_after

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Turning:
        self.session = self.kind(self.fault_after)
        return self.session


def run(kind: type[Turning], fault_after: int, scenario: Scenario = SCENE) -> Run:
    return Spinner(kind, fault_after).run(scenario, METHOD, TIMESTEP, SAMPLES)


FAULTS = {
    Warns: ("diverged", "warning", "it warns"),
    NotFinite: ("diverged", "not-finite", "no longer finite"),
    Infinite: ("diverged", "not-finite", "no longer finite"),
    TooFast: ("diverged", "clamp", "the rotation a step, 43.6°, is beyond 28.6°"),
    NoRotation: ("diverged", "not-unit", "quaternion is of norm 2"),
    LateFault: ("diverged", "reset", "it was reset"),
    BlownUpInAStep: ("diverged", "not-finite", "a step was not possible"),
    GaveUpInAStep: ("failed", "refused", "out of memory"),
    KeptTheLastState: ("diverged", "not-finite", "accelerations are nan"),
    Buggy: ("failed", "bug", "ZeroDivisionError: a bug"),
}


def test_an_exception_without_a_message_is_named_alone() -> None:
    assert not run(BuggyWithoutWords, EARLY).reason.startswith("AssertionError:")
    assert run(BuggyWithoutWords, EARLY).reason.startswith("AssertionError")


def test_a_run_without_a_fault_has_every_sample() -> None:
    done = run(Turning, SAMPLES[-1] + 1)
    assert (done.outcome, done.reason, done.stopped_at) == ("ok", "", None)
    assert done.steps == SAMPLES[-1]
    assert done.trajectory is not None
    assert np.array_equal(done.trajectory.t, SAMPLES * TIMESTEP)


@pytest.mark.parametrize("fault_after", [EARLY, LATE], ids=["first block", "second block"])
@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: kind.__name__)
def test_a_run_that_goes_wrong_keeps_what_was_right(kind: type[Turning], fault_after: int) -> None:
    done = run(kind, fault_after)
    outcome, cause, words = FAULTS[kind]
    assert (done.outcome, done.cause) == (outcome, cause)
    assert words in done.reason
    good = SAMPLES[: np.searchsorted(SAMPLES, fault_after)]
    assert done.steps == good[-1]
    assert done.stopped_at == SAMPLES[len(good)] * TIMESTEP
    assert done.trajectory is not None
    assert np.array_equal(done.trajectory.t, good * TIMESTEP)
    # At its last sample it is as little ok as at another.
    assert run(kind, int(SAMPLES[-1])).outcome == outcome
    assert run(kind, int(SAMPLES[-1]) + 1).outcome == "ok"


@pytest.mark.parametrize("kind", [Warns, BlownUpInAStep], ids=lambda kind: kind.__name__)
def test_an_engine_that_stops_is_not_stepped_on(kind: type[Turning]) -> None:
    engine = Spinner(kind, EARLY)
    engine.run(SCENE, METHOD, TIMESTEP, SAMPLES)
    assert engine.session.steps == SAMPLES[np.searchsorted(SAMPLES, EARLY)]


def test_an_engine_with_parts_may_stop_at_any_step() -> None:
    # So far apart that blocks begin among them, of which there is no state then.
    samples = np.arange(0, 2 * FIRST_BLOCK * BLOCK_STEPS, BLOCK_STEPS)
    bounds = Bounds(TIMESTEP, MOST_TURN)
    for stops_at in samples[1:]:
        sampled = sample(GaveUpWithASpin(int(stops_at)), samples, bounds)
        assert (sampled.outcome, sampled.reason) == ("failed", "out of memory")


#: Samples as far apart as blocks are long.
APART = np.arange(0, 100 * BLOCK_STEPS, BLOCK_STEPS)
LONG = np.arange(0, 5 * STRIDE * BLOCK, STRIDE)
LOOKED_AT = min(BLOCK, int(np.searchsorted(SAMPLES, BLOCK_STEPS))) - 1


@pytest.mark.parametrize(
    ("samples", "fault_after", "least", "most"),
    [
        (APART, int(APART[FIRST_BLOCK + 1]), 0, APART[2 * (FIRST_BLOCK + 1)]),
        (SAMPLES, EARLY, SAMPLES[LOOKED_AT], SAMPLES[LOOKED_AT]),
        (LONG, LATE, LATE, LATE + STRIDE * BLOCK),
    ],
    ids=["no longer than it has gone", "no look that is not worth it", "a block at most"],
)
def test_what_goes_wrong_unnoticed_is_stepped_on_no_longer_than(
    samples: np.ndarray, fault_after: int, least: int, most: int
) -> None:
    engine = Spinner(NotFinite, fault_after)
    engine.run(SCENE, METHOD, TIMESTEP, samples)
    assert least <= engine.session.steps <= most


class CheckedAtTheEnd(Turning):
    """Its check is not part of its snapshots, so the time of the fault is not known."""

    def snapshot(self) -> State:
        return self.read_state()

    def check(self) -> None:
        if self.is_wrong:
            raise EngineError("the clock was set by somebody else")


def test_a_block_that_went_wrong_nobody_knows_when_is_not_kept() -> None:
    done = run(CheckedAtTheEnd, LATE)
    assert (done.outcome, done.reason) == ("diverged", "the clock was set by somebody else")
    wrong = np.searchsorted(SAMPLES, LATE)
    assert SAMPLES[wrong - BLOCK] <= done.steps < LATE
    assert run(CheckedAtTheEnd, int(SAMPLES[FIRST_BLOCK - 1])).trajectory is None


class Unauditable(Turning):
    def active(self) -> frozenset[str]:
        raise EngineError("no answer")


def test_a_run_that_cannot_be_audited_fails_with_its_samples_unless_it_diverged() -> None:
    class Both(Warns, Unauditable):
        pass

    done = run(Unauditable, 0)
    assert (done.outcome, done.reason) == ("failed", "cannot be audited: no answer")
    assert done.trajectory is not None
    assert run(Both, EARLY).reason == "it warns"
