"""Measures the CPU time of a step. Nothing but the engine's own stepping is timed."""

import math
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cache, partial
from typing import TypeVar

import numpy as np

from ....engines import EngineError, Session
from ....engines.fault import ENVIRONMENTAL
from ....scenarios import Scenario
from ...results.cost_records import Ratio, StepCost
from ..choice import EngineMethod
from ..executors import Answer, CallFailed, Executor, is_environmental

T = TypeVar("T")

#: Least CPU time of a stretch, s: a number of steps that are timed together. It is so short that
#: many stretches fall between two timer interrupts of the operating system.
STRETCH = 0.001
#: Least CPU time of a stretch in units of the measured resolution of the clock.
RESOLUTIONS = 100
#: Largest fraction of a stretch's time that may be the overhead of the call that takes the steps.
SHARE_OF_CALL = 0.02
#: Number of timed stretches of a method. The shortest counts; max − min is the noise.
REPEATS = 9
#: Number of significant binary digits of a stretch's number of steps: engines whose calls take
#: powers of two of steps need at most this many calls.
DIGITS_OF_STEPS = 3
#: Number of steps before the first timed one, to warm up caches, allocations and branch predictors.
#: The stretches that determine the number of steps warm up further.
WARM_UP = 16
#: Number of times that a stretch is tried, to determine its number of steps; the shortest counts.
TRIALS = 3
#: Angle turned in a timed step, rad: so small that no method blows up while it is timed.
TIMED_TURN = 1e-4
#: Number of changes of the clock's value of which the least is taken for its resolution.
CLOCK_TICKS = 100


@dataclass(frozen=True)
class TimingSample:
    """One timed stretch of steps: CPU time and wall time per step, s."""

    cpu: float
    wall: float


class TimingRefused(Exception):
    """The machine prevented the timing; it may succeed the next time."""


def timed(answer: Answer[T]) -> T | CallFailed:
    """Return what a call that times steps has returned, or why it failed.

    Raises
    ------
    TimingRefused
        If the call failed and the machine is to blame.
    """
    if isinstance(answer.value, CallFailed) and is_environmental(answer.value.cause):
        raise TimingRefused(answer.value.reason)
    return answer.value


def measure(
    executor: Executor, scenario: Scenario, pairs: Sequence[EngineMethod]
) -> tuple[list[StepCost | None], list[str]]:
    """Time every method on a scene, by calls of an executor.

    One call times all methods whose engines are installed in the same folder (`Engine.site`), one
    stretch of each in turn. If the call fails, as when a method crashes the process, each of these
    methods is timed by a call of its own, so that only the cost of the failing one is missing.

    Parameters
    ----------
    pairs : the methods to time, with their engines

    Returns
    -------
    The cost of each method, None if it is missing; and a sentence on each method whose own call
    failed

    Raises
    ------
    TimingRefused
        If a cost is missing and the machine is to blame.
    """
    costs: list[StepCost | None] = [None] * len(pairs)
    complaints = []
    for site in dict.fromkeys(engine.site for engine, _ in pairs):
        places = [k for k, (engine, _) in enumerate(pairs) if engine.site == site]
        together = [pairs[k] for k in places]
        measured = timed(executor.call_at(site, step_costs, scenario, together))
        for k in places:
            if not isinstance(measured, CallFailed):
                costs[k] = measured[places.index(k)]
                continue
            engine, method = pairs[k]
            alone = timed(executor.call_at(site, step_costs, scenario, [pairs[k]]))
            if isinstance(alone, CallFailed):
                complaints.append(f"{engine.name} {method.name} could not be timed: {alone.reason}")
            else:
                (costs[k],) = alone
    return costs, complaints


def step_costs(scenario: Scenario, pairs: Sequence[EngineMethod]) -> list[StepCost | None]:
    """Time every method on a scene, interleaved, and return the cost of a step of each.

    The cost is None for a method that the engine cannot load or step.

    Parameters
    ----------
    pairs : engines and their methods. If a method is among them both with an engine and with a
        variant of it (`varied`), the cost with the variant states the ratio of the two costs

    Raises
    ------
    EngineError
        If an engine fails and the machine is to blame.
    """
    timestep = timed_timestep(scenario)
    timed = interleaved(
        [partial(engine.open, scenario, method, timestep) for engine, method in pairs]
    )
    plain = {
        (engine.name, method.name): stretches
        for (engine, method), stretches in zip(pairs, timed, strict=True)
        if not engine.varied
    }
    return [
        _cost(stretches, plain.get((engine.name, method.name), []) if engine.varied else [])
        for (engine, method), stretches in zip(pairs, timed, strict=True)
    ]


def timed_timestep(scenario: Scenario) -> float:
    """Return the timestep at which a scene's steps are timed, s.

    A step turns the body by `TIMED_TURN` at the start. If the body does not turn there, the
    timestep is `TIMED_TURN` seconds.
    """
    speed = float(np.linalg.norm(scenario.start.omega_body))
    return TIMED_TURN / speed if speed else TIMED_TURN


def interleaved(openings: Sequence[Callable[[], Session]]) -> list[list[TimingSample]]:
    """Time one stretch of each session in turn, `REPEATS` times, and return the stretches of each.

    A stretch is a number of steps that are timed together. The list is empty for a session that the
    engine fails to load or to step.

    Parameters
    ----------
    openings : functions that open the sessions

    Raises
    ------
    EngineError
        If an engine fails and the machine is to blame.
    """
    with ExitStack() as stack:
        timed = [_Timed(stack, opening) for opening in openings]
        for _ in range(REPEATS):
            for one in timed:
                one.attempt(one.time)
        for one in timed:
            one.attempt(one.check)
        return [one.stretches for one in timed]


@dataclass
class _Timed:
    """A session that is timed in stretches of steps, until its engine raises an error.

    Attributes
    ----------
    stack : closes the session in the end
    opening : the function that opens the session
    stretches : the timed stretches; empty after an error
    """

    stack: ExitStack
    opening: Callable[[], Session]
    stretches: list[TimingSample] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.gave_up = False
        self.attempt(self.open)

    def attempt(self, action: Callable[[], None]) -> None:
        """Call an action, unless an earlier one has raised `EngineError`.

        If this one raises `EngineError`, all times are discarded, and no further action is called;
        but if the machine is to blame, the error is raised again.
        """
        if self.gave_up:
            return
        try:
            action()
        except EngineError as error:
            if error.cause in ENVIRONMENTAL:
                raise
            self.gave_up = True
            self.stretches.clear()

    def open(self) -> None:
        """Open the session, warm it up, and set the number of steps that are timed together."""
        self.session = self.stack.enter_context(self.opening())
        self.session.advance(WARM_UP)
        short = self._seconds(WARM_UP)
        self.steps = 2 * WARM_UP
        while (seconds := self._seconds(self.steps)) < (least := self._least(short, seconds)):
            # A stretch too short for the clock only shows that it must be much longer.
            longer = least / max(seconds, least / RESOLUTIONS)
            self.steps = _in_few_calls(math.ceil(self.steps * longer))

    def _least(self, short: float, seconds: float) -> float:
        """Return the least CPU time of a stretch, s, that is not dominated by the measurement.

        The clock's resolution and the overhead of a call must be small compared to it.

        Parameters
        ----------
        short : CPU time of a stretch of `WARM_UP` steps, s
        seconds : CPU time of a stretch of `self.steps` steps, s
        """
        a_step = max(0.0, seconds - short) / (self.steps - WARM_UP)
        a_call = max(0.0, short - WARM_UP * a_step)
        return max(STRETCH, RESOLUTIONS * resolution(), a_call / SHARE_OF_CALL)

    def time(self) -> None:
        """Time one stretch, and keep the result."""
        self.stretches.append(self._stretch(self.steps))

    def check(self) -> None:
        """Raise `EngineError` unless the timed steps are valid and the state is finite.

        Clamped steps are valid, as they cost the same.
        """
        try:
            self.session.check()
        except EngineError as error:
            if error.cause != "clamp":
                raise
        state = self.session.read_state()
        if not all(np.isfinite(values).all() for values in vars(state).values()):
            raise EngineError("the state is no longer finite")

    def _seconds(self, steps: int) -> float:
        """Return the least CPU time, s, of `TRIALS` stretches of `steps` steps each."""
        return min(self._stretch(steps).cpu * steps for _ in range(TRIALS))

    def _stretch(self, steps: int) -> TimingSample:
        """Time a number of steps; return the times per step."""
        cpu, wall = self.session.timed(steps)
        return TimingSample(cpu / steps, wall / steps)


def _in_few_calls(steps: int) -> int:
    """Return `steps`, rounded up to `DIGITS_OF_STEPS` significant binary digits."""
    unit = 1 << max(0, steps.bit_length() - DIGITS_OF_STEPS)
    return math.ceil(steps / unit) * unit


@cache
def resolution() -> float:
    """Return the resolution of the CPU clock, s; measured, as some systems report a wrong one."""
    changes: list[float] = []
    before = time.process_time()
    while len(changes) < CLOCK_TICKS:
        now = time.process_time()
        if now > before:
            changes.append(now - before)
        before = now
    return min(changes)


def _cost(stretches: Sequence[TimingSample], plain: Sequence[TimingSample]) -> StepCost | None:
    """Return the cost of a step, given the timed stretches; None if there are none.

    Parameters
    ----------
    stretches : the method's timed stretches
    plain : for a varied engine, the stretches of the unvaried engine that were timed in turn with
        them; empty for other engines, and if there are none
    """
    if not stretches:
        return None
    cpu, wall = [one.cpu for one in stretches], [one.wall for one in stretches]
    ratio = None
    if plain:
        ratios = [own.cpu / other.cpu for own, other in zip(stretches, plain, strict=True)]
        low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75))
        ratio = Ratio(float(middle), float(high - low))
    return StepCost(min(cpu), max(cpu) - min(cpu), min(wall), ratio=ratio)
