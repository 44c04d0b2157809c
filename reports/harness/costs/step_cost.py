"""Measures the cost of a step. Only the engine's own stepping is in the timed region."""

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

#: Least CPU time of a timed stretch of steps, s: so short that many stretches fall between two
#: ticks of the system's clock.
STRETCH = 0.001
#: Least length of a stretch in units of the measured resolution of the clock.
RESOLUTIONS = 100
#: Largest share of a stretch that a call's own cost, independent of the number of steps, may have.
SHARE_OF_CALL = 0.02
#: Number of timed stretches of a method; the minimum is reported, their spread is the noise.
REPEATS = 9
#: Number of significant binary digits of a stretch's number of steps: engines that take a power of
#: two of steps in a call need at most that many calls.
DIGITS_OF_STEPS = 3
#: Number of steps before the first timed one, to warm up caches, allocations and branch predictors.
#: The stretches that determine the number of steps warm up further.
WARM_UP = 16
#: Number of stretches of one length, of which the shortest counts, while the length is determined.
TRIALS = 3
#: Angle turned in a timed step, rad: so small that no method blows up while it is timed.
TIMED_TURN = 1e-4
#: Number of changes of the clock's value from which its resolution is measured.
CLOCK_TICKS = 100


@dataclass(frozen=True)
class TimingSample:
    """One timed stretch of steps: CPU time and wall time per step, s."""

    cpu: float
    wall: float


class TimingRefused(Exception):
    """The machine prevented the timing; it may succeed the next time."""


def timed(answer: Answer[T]) -> T | CallFailed:
    """Return the result of a call that times steps.

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
    """Time every method on a scene; methods that run in one process are timed together.

    If a method crashes or hangs the process, the methods are timed one by one, no longer
    interleaved, so that only the cost of that method is missing.

    Parameters
    ----------
    pairs : the methods to time, with their engines

    Returns
    -------
    The costs, None for each that is missing, and complaints in words.

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
    """Time every method on a scene, interleaved; None for a method that does not load or step.

    Parameters
    ----------
    pairs : engines and their methods; the ratio of a varied engine's cost to that of the unvaried
        engine is measured if both are among them

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
    """Return the timestep at which a scene's steps are timed, s."""
    speed = float(np.linalg.norm(scenario.start.omega_body))
    return TIMED_TURN / speed if speed else TIMED_TURN


def interleaved(openings: Sequence[Callable[[], Session]]) -> list[list[TimingSample]]:
    """Time sessions in turn, and return `REPEATS` timed stretches of each.

    A session that its engine fails to load or to step has no stretches.

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
    """A session that is timed until its engine refuses something."""

    stack: ExitStack
    opening: Callable[[], Session]
    stretches: list[TimingSample] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.gave_up = False
        self.attempt(self.open)

    def attempt(self, action: Callable[[], None]) -> None:
        """Call an action that the engine may refuse, unless it has refused one before.

        If it refuses, all times are discarded; an error that the machine is to blame for is raised.
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
        """Load the session, warm it up, and determine the number of steps of a stretch."""
        self.session = self.stack.enter_context(self.opening())
        self.session.advance(WARM_UP)
        short = self._seconds(WARM_UP)
        self.steps = 2 * WARM_UP
        while (seconds := self._seconds(self.steps)) < (least := self._least(short, seconds)):
            # A stretch too short for the clock only shows that it must be much longer.
            longer = least / max(seconds, least / RESOLUTIONS)
            self.steps = _in_few_calls(math.ceil(self.steps * longer))

    def _least(self, short: float, seconds: float) -> float:
        """Return how long a stretch must last at least, s, for its time to be trusted.

        The clock's resolution and the cost of a call must be small parts of it.

        Parameters
        ----------
        short, seconds : durations of a stretch of `WARM_UP` steps and of the last one tried, s
        """
        a_step = max(0.0, seconds - short) / (self.steps - WARM_UP)
        a_call = max(0.0, short - WARM_UP * a_step)
        return max(STRETCH, RESOLUTIONS * resolution(), a_call / SHARE_OF_CALL)

    def time(self) -> None:
        """Time one stretch."""
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
        """Return the CPU time of a stretch of some steps, s, the shortest of `TRIALS`."""
        return min(self._stretch(steps).cpu * steps for _ in range(TRIALS))

    def _stretch(self, steps: int) -> TimingSample:
        """Time a number of steps; return the times per step."""
        cpu, wall = self.session.timed(steps)
        return TimingSample(cpu / steps, wall / steps)


def _in_few_calls(steps: int) -> int:
    """Return `steps`, rounded up to a number of `DIGITS_OF_STEPS` significant binary digits."""
    unit = 1 << max(0, steps.bit_length() - DIGITS_OF_STEPS)
    return math.ceil(steps / unit) * unit


@cache
def resolution() -> float:
    """Return the measured resolution of the CPU clock, s, as some systems report a wrong one."""
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
    plain : for a varied engine, stretches of the unvaried engine, timed in turn with these
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
