"""What a step costs: native stepping, nothing recorded, nothing but steps in the timed region."""

import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass

from ..engines import Engine, EngineError, Session
from ..scenarios import Scenario

#: s of CPU time a timed stretch must last, far above the clock's resolution.
STRETCH = 0.02
#: Timed stretches a method; the least is quoted, the rest tell the noise.
REPEATS = 5
#: Steps before the first timed one: caches, lazy allocation, branch predictors.
WARM_UP = 200
#: Steps are timed at a timestep this small, 1/rad, so that no method blows up while it is timed.
TIMED_TURN = 1e-4


@dataclass(frozen=True)
class StepCost:
    """CPU seconds a step: the least over the repeats, and the largest less the least."""

    seconds_per_step: float
    spread: float


def step_costs(scenario: Scenario, pairs: Sequence[tuple[Engine, str]]) -> list[StepCost | None]:
    """Time every method on a scene, interleaved; None for one that does not load.

    Parameters
    ----------
    pairs : engines and names of their methods
    """
    speed = float((scenario.start.omega_body**2).sum() ** 0.5)
    timestep = TIMED_TURN / speed if speed else TIMED_TURN
    with ExitStack() as stack:
        sessions: list[Session | None] = []
        for engine, method in pairs:
            try:
                opened = engine.open(scenario, engine.method(method), timestep)
            except EngineError:
                sessions.append(None)
            else:
                sessions.append(stack.enter_context(opened))
        counts = [_steps_that_last(session) if session else 0 for session in sessions]
        stretches: list[list[float]] = [[] for _ in sessions]
        for _ in range(REPEATS):
            for session, count, seconds in zip(sessions, counts, stretches, strict=True):
                if session:
                    seconds.append(_seconds(session, count) / count)
    return [StepCost(min(s), max(s) - min(s)) if s else None for s in stretches]


def _steps_that_last(session: Session) -> int:
    """A number of steps that takes at least `STRETCH`, after a warm-up."""
    session.advance(WARM_UP)
    count = WARM_UP
    while (seconds := _seconds(session, count)) < STRETCH:
        count = int(count * max(2.0, STRETCH / max(seconds, STRETCH / 100)))
    return count


def _seconds(session: Session, steps: int) -> float:
    start = time.process_time()
    session.advance(steps)
    return time.process_time() - start
