"""A single run of a method, or the judgement of its derivatives, for scripts."""

import atexit
import os
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from spincheck.engines import Engine, engines, missing
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.gradients.compared import GradientRow
from spincheck.reports.harness.gradients.study import gradient_by, offered_by
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_study
from spincheck.reports.results.records import UNSOLVED, Row
from spincheck.reports.results.store import open_store
from spincheck.scenarios import Scenario


def single_run(scenario: Scenario, engine: str, method: str, timestep: float) -> Row:
    """Run a scene in a worker process, which is kept for later runs, and return the run's row.

    Parameters
    ----------
    timestep : s

    Raises
    ------
    ValueError
        If there is no such engine or method, if the engine cannot load the scene's body, or if the
        timestep is not above 0 or is longer than the scene's window.
    """
    chosen = _engine_of(scenario, engine, method)
    if not (
        isinstance(timestep, int | float | np.floating | np.integer)
        and 0 < timestep <= scenario.window.duration
    ):
        longest = scenario.window.duration
        raise ValueError(f"'timestep' must be above 0 and at most {longest:g} s, got {timestep!r}.")
    # Results are kept as JSON, which has no numbers of NumPy's.
    timestep = float(timestep)
    choice = Choice((chosen,), (method,), (timestep,), timed=False)
    executor = _workers(os.getpid())
    with (
        TemporaryDirectory() as folder,
        open_store(Path(folder) / "run.sqlite", create=True) as store,
    ):
        try:
            run_study(plan([scenario], choice, store), choice, store, executor, lambda _: None)
        except BaseException:  # after an interrupt the worker may still be running the call
            executor.close()
            _workers.cache_clear()
            raise
        rows = store.read(choice.timesteps).rows
    return next(row for row in rows if row.timestep in (timestep, UNSOLVED))


def judged_gradients(
    scenario: Scenario, engine: str, method: str, timestep: float | None, window: float | None
) -> list[GradientRow]:
    """Return a row with a verdict for each derivative of a method, and for central differences.

    The derivatives are computed in the worker process that `single_run` uses.

    Parameters
    ----------
    timestep : timestep of gradients through many steps, s; if None, it follows from the fastest
        rate
    window : time over which gradients through many steps are compared, s; 512 steps if None

    Raises
    ------
    ValueError
        If there is no such engine or method, if the engine cannot load the scene's body, if the
        timestep or the window is not a finite number above 0, or if the window is shorter than the
        timestep.
    """
    for name, given in {"timestep": timestep, "window": window}.items():
        if given is not None and not 0 < given < float("inf"):
            raise ValueError(f"'{name}' must be above 0, got {given}.")
    if timestep and window and window < timestep:
        raise ValueError(f"'window' must be no shorter than 'timestep', got {window:g} s.")
    of = _workers(os.getpid()), scenario, _engine_of(scenario, engine, method), method
    return [gradient_by(*of, derivative, timestep, window) for derivative in offered_by(*of)]


def _engine_of(scenario: Scenario, engine: str, method: str) -> Engine:
    """Return the engine with a given name, after checking that it has the method.

    Raises
    ------
    ValueError
        If there is no such engine or method, or the engine cannot load the scene's body.
    """
    known = engines()
    if engine not in known:
        why = next((f" ({m.reason})" for m in missing() if m.name == engine), "")
        raise ValueError(f"'engine' must be one of {', '.join(known)}, got '{engine}'{why}.")
    methods = [one.name for one in known[engine].methods]
    if method not in methods:
        raise ValueError(f"'method' must be one of {', '.join(methods)}, got '{method}'.")
    if not known[engine].applies_to(scenario):
        raise ValueError(
            f"'engine' {engine} loads links of users' files, and {scenario.name} names none; "
            "'spincheck import FILE --out DIR' makes such scenes."
        )
    return known[engine]


@cache
def _workers(_process: int) -> LocalWorkers:
    """Return an executor with one worker process, which is kept until this process ends.

    It is kept because starting a worker takes longer than most runs.

    Parameters
    ----------
    _process : id of this process, so that a forked process starts an executor of its own
    """
    executor = LocalWorkers(1)
    atexit.register(executor.close)
    return executor
