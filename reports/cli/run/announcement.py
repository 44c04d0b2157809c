"""The line printed before a run: its engines, and roughly how long it takes."""

from collections.abc import Iterable

from ....engines import Engine
from ...harness.choice import Choice
from ...harness.executors.compiling import share_of_a_core
from ...harness.ladder import QUICK_STEPS
from ...harness.plan import Plan
from ...pages.analysis.wording import plural
from ..terminal import in_words

#: Typical number of steps of all runs of one verdict: on short ladders, and on whole ones.
STEPS_QUICK, STEPS = 35_000, 50_000
#: s, that a verdict takes besides its steps; s, that the timing of a method on a scene takes.
OVERHEAD, TIMING = 0.3, 0.06


def announcement(left: Plan, choice: Choice, jobs: int) -> str:
    """Engines, number of verdicts to be made, estimated time; empty for one verdict at most."""
    pairs = [pair for scene in left.scenes for pair in scene.to_run]
    if len(pairs) < 2:
        return ""
    names = dict.fromkeys(engine.name for engine, _ in pairs)
    timings = sum(len(scene.to_run) for scene in left.scenes if scene.to_time)
    seconds = _seconds((engine for engine, _ in pairs), choice) / jobs + TIMING * timings
    seconds /= share_of_a_core(jobs)
    return (
        f"{plural(len(pairs), 'verdict')} of {plural(len(names), 'engine')} ({', '.join(names)}) "
        f"on {plural(len(left.scenes), 'scene')}: roughly {in_words(seconds)} "
        f"with {plural(jobs, 'worker')}{'; --engine names fewer' if len(names) > 2 else ''}"
    )


def _seconds(engines: Iterable[Engine], choice: Choice) -> float:
    steps = STEPS_QUICK if choice.max_steps <= QUICK_STEPS else STEPS
    if choice.timesteps:
        steps = 0
    return sum(steps * engine.step_seconds + OVERHEAD for engine in engines)
