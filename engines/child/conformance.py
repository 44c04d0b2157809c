"""Checks that a command keeps the protocol: every call, on scenes of every set of effects."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...scenarios import Scenario
from ..checks.read_back import EngineError, start_state
from ..fault import Cause
from ..method import Method
from ..run import Run
from .engine import ChildEngine, child_engine
from .messages import Done, Hello
from .process import ChildProcess, ProtocolError

#: Steps of a run, and of a timed stretch.
STEPS = 64
#: Angle turned in a step, rad; so small that no method blows up.
TURN = 1e-2
#: Causes that are faults in any method, even of an engine as shipped.
BROKEN: frozenset[Cause] = frozenset({"protocol", "crash", "killed", "time-out", "clock", "bug"})


@dataclass(frozen=True)
class ConformanceCheck:
    """One thing that was checked.

    Attributes
    ----------
    what : in words
    problem : how it breaks the protocol; empty if it does not
    remark : additional information
    physics : how its first steps break the equations of motion, though it keeps the protocol
    """

    what: str
    problem: str = ""
    remark: str = ""
    physics: str = ""


#: How the single steps of a method break a scene's equations of motion, in words; else empty.
Physics = Callable[[ChildEngine, Scenario, Method], str]


def conformance(
    command: Sequence[str], scenes: Sequence[Scenario], limit: float, physics: Physics
) -> Iterator[ConformanceCheck]:
    """Make every check; ends early if the child can no longer be asked.

    Parameters
    ----------
    scenes : to open and run, each by every method that can simulate it
    limit : s that an answer may take
    physics : compares single steps with the equations of motion

    Raises
    ------
    ProtocolError
        If the command cannot be started.
    """
    child = ChildProcess(command, limit)
    try:
        try:
            hello = child.ask(Hello, "hello")
        except EngineError as error:
            yield ConformanceCheck("hello", str(error))
            return
        yield ConformanceCheck(
            "hello", remark=f"{hello.name} {hello.version}, {hello.precision} precision"
        )
        yield _repeats_itself(child, hello)
        yield _answers_nonsense(child)
    finally:
        ended = child.end()
    yield ConformanceCheck(
        "ends with its standard input", "" if ended else "it did not, and was killed"
    )
    if not ended:
        return
    engine = child_engine(command, limit)
    for method in engine.methods:
        for scenario in scenes:
            if not engine.unsupported(scenario, method):
                check = _runs(engine, method, scenario, physics)
                yield check
                if check.problem:
                    break


def _repeats_itself(child: ChildProcess, hello: Hello) -> ConformanceCheck:
    what = "hello a second time"
    try:
        same = child.ask(Hello, "hello") == hello
    except EngineError as error:
        return ConformanceCheck(what, str(error))
    return ConformanceCheck(what, "" if same else "it describes itself differently than before")


def _answers_nonsense(child: ChildProcess) -> ConformanceCheck:
    what = "an unknown call"
    try:
        child.ask(Done, "nonsense")
    except ProtocolError as error:
        return ConformanceCheck(what, str(error))
    except EngineError:
        return ConformanceCheck(what)
    return ConformanceCheck(what, "must be answered by an 'error'")


def timestep_for(scenario: Scenario) -> float:
    """A timestep, s, in which the body and each of its parts turn by `TURN` at the most."""
    fastest = max(np.linalg.norm(scenario.start.omega_body), *abs(scenario.start_spins), 0.0)
    return TURN / float(fastest) if fastest else scenario.window.duration / STEPS


def _runs(
    engine: ChildEngine, method: Method, scenario: Scenario, physics: Physics
) -> ConformanceCheck:
    what = f"{method.name} on {scenario.name}"
    timestep = timestep_for(scenario)
    steps = np.arange(STEPS + 1, dtype=np.int64)
    first = engine.run(scenario, method, timestep, steps)
    if problem := _problem(first, method):
        return ConformanceCheck(what, problem)
    if not _same(first, engine.run(scenario, method, timestep, steps)):
        return ConformanceCheck(what, "a second run of it gives another motion")
    try:
        with engine.open(scenario, method, timestep) as session:
            session.timed(STEPS)
    except EngineError as error:
        return ConformanceCheck(what, str(error))
    if problem := _restarts(engine, method, scenario, timestep):
        return ConformanceCheck(what, problem)
    residuals = physics(engine, scenario, method)
    if method.as_shipped:
        return ConformanceCheck(what, remark="; ".join(filter(None, (first.reason, residuals))))
    return ConformanceCheck(what, remark=first.reason, physics=residuals)


def _restarts(engine: ChildEngine, method: Method, scenario: Scenario, timestep: float) -> str:
    """How a restart after a run differs from a scene that is opened; empty if it does not."""
    if not engine.hello.restart:
        return ""
    try:
        with (
            engine.open(scenario, method, timestep / 2) as session,
            engine.open(scenario, method, timestep) as opened,
        ):
            session.advance(STEPS)
            session.read_state()
            session.restart(start_state(scenario), timestep)
            for one in (session, opened):
                one.advance(STEPS)
            states = vars(session.read_state()).values(), vars(opened.read_state()).values()
    except EngineError as error:
        return str(error)
    same = all(np.array_equal(one, other) for one, other in zip(*states, strict=True))
    return "" if same else "restarted from its start it moves in another way"


def _problem(run: Run, method: Method) -> str:
    excused = method.as_shipped and run.cause not in BROKEN
    return "" if run.outcome == "ok" or excused else f"{run.outcome}: {run.reason}"


def _same(first: Run, second: Run) -> bool:
    if first.trajectory is None or second.trajectory is None:
        return first.trajectory is second.trajectory
    return all(
        np.array_equal(values, getattr(second.trajectory, name))
        for name, values in vars(first.trajectory).items()
    )
