"""Judges the derivatives of a method on a scene, in this process or in another process."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from ....engines import Engine, EngineError, UnsupportedError
from ....engines.engine import read_at_start
from ....reference import ExactMotion
from ....scenarios import Scenario
from ....scenarios.fastest_rate import fastest_rate
from ..executors import CallFailed, Executor
from ..measuring.places import places
from ..measuring.steps import sessions_of
from .compared import OURS, GradientRow, MethodStudy
from .jacobians import units_of
from .verdict import Judged
from .window import counts_to

#: Number of exact states that steps are taken from.
STATES = 4
#: Number of steps of a window, if its length is not given.
STEPS = 512
#: Index of a window's timestep among the halved ones, if none is given: some 0.05 rad a step.
FINE = 2


def offered_by(executor: Executor, scenario: Scenario, engine: Engine, method: str) -> list[str]:
    """Return the names of a method's derivatives that can be judged, found in another process.

    The last one is `OURS`, spincheck's own differences. It is the only one if the call fails.
    """
    answer = executor.call_at(engine.site, offered, scenario, engine, method)
    return [OURS] if isinstance(answer.value, CallFailed) else answer.value


def gradient_by(
    executor: Executor,
    scenario: Scenario,
    engine: Engine,
    method: str,
    derivative: str,
    timestep: float | None = None,
    window: float | None = None,
) -> GradientRow:
    """Judge one derivative in another process, and return its row.

    If the call fails, as when that process dies, the row's verdict is `failed`.

    Parameters
    ----------
    derivative : its name, one of `offered`
    timestep : timestep of the window's steps, s; chosen by the motion's fastest rate if None
    window : length of the window, s; of 512 steps if None
    """
    began, how = time.perf_counter(), (timestep, window, derivative)
    answer = executor.call_at(engine.site, gradients_of, scenario, engine, method, *how)
    if isinstance(answer.value, CallFailed):
        failed = Judged("failed", answer.value.reason)
        seconds = time.perf_counter() - began
        return GradientRow(scenario.name, engine.name, method, derivative, failed, seconds=seconds)
    return answer.value[0]


def offered(scenario: Scenario, engine: Engine, method_name: str) -> list[str]:
    """Return the names of a method's derivatives that can be judged.

    The last one is `OURS`, spincheck's own differences. It is the only one if the engine cannot be
    opened.
    """
    try:
        with _study(scenario, engine, method_name, None, None) as study:
            return study.names()
    except EngineError:
        return [OURS]


def gradients_of(
    scenario: Scenario,
    engine: Engine,
    method_name: str,
    timestep: float | None = None,
    window: float | None = None,
    derivative: str | None = None,
) -> list[GradientRow]:
    """Judge a method's derivatives, and return a row for each.

    If the engine cannot be opened, one row is returned whose verdict says why.

    Parameters
    ----------
    timestep : timestep of the window's steps, s; chosen by the motion's fastest rate if None
    window : length of the window, s; of 512 steps if None
    derivative : one of `offered`; all of them if None
    """
    began = time.perf_counter()
    try:
        with _study(scenario, engine, method_name, timestep, window) as study:
            rows = [study.row(name) for name in study.names() if derivative in (None, name)]
            if not rows:
                raise EngineError(f"it does not offer '{derivative}' any more")
            return rows
    except EngineError as error:
        is_unsupported = isinstance(error, UnsupportedError)
        one = Judged("unsupported" if is_unsupported else "failed", str(error))
        names = scenario.name, engine.name, method_name, derivative or OURS
        return [GradientRow(*names, one, seconds=time.perf_counter() - began)]


@contextmanager
def _study(
    scenario: Scenario,
    engine: Engine,
    method_name: str,
    timestep: float | None,
    window: float | None,
) -> Iterator["MethodStudy"]:
    """Open an engine, and yield the study of a method's derivatives at exact states of a scene.

    Parameters
    ----------
    timestep : timestep of the window's steps, s; chosen by the motion's fastest rate if None
    window : length of the window, s; of 512 steps if None

    Raises
    ------
    EngineError
        If the engine cannot be opened or read; `UnsupportedError` if it cannot simulate the scene.
    """
    method = engine.method(method_name)
    if reason := engine.unsupported(scenario, method):
        raise UnsupportedError(reason)
    outline = ExactMotion(scenario).outline(scenario.times)
    at = places(scenario, outline, None).thinned(STATES)
    rate = fastest_rate(scenario, outline.omega_body) or 1 / scenario.window.duration
    with sessions_of(engine, method, scenario, float(at.timesteps[0])) as sessions:
        read_at_start(sessions.first, scenario)
        h = timestep or float(at.timesteps[FINE])
        counts = counts_to(STEPS if window is None else max(1, round(window / h)))
        yield MethodStudy(sessions, engine, method, at, units_of(engine, rate), h, counts)
