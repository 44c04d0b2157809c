"""CPU seconds of `spincheck run` over the bare stepping of the runs it keeps, and where they go.

The ratio is of a run as users start it, with its start-up, worker processes and timing phase. Bare
stepping is the native calls alone, of as many steps as the stored runs took: taken again after the
run, in as many processes at once. Beside it stands what the steps' stored times come to, each the
least of several short stretches, which no long run reaches on a machine that others use too. The
shares of the phases are of one more run of the same scenes in this process.
"""

import json
import multiprocessing
import os
import resource
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Console
from rich.table import Table
from spincheck.engines import engines, sampling
from spincheck.engines.adapters import mujoco, pybullet
from spincheck.reports.harness import convergence_study, study
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.judging import ladder
from spincheck.reports.harness.measuring import richardson
from spincheck.reports.harness.plan import plan
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import Store, open_store
from spincheck.scenarios import find, load

OUT = Path("build/bench/whole_run.json")
SCENES = [
    "fast-top",
    "book-middle-axis",
    "hammer",
    "lopsided-body",
    "kovalevskaya",
    "nutation-loops",
    "sleeping-top",
    "book-with-drag",
    "conical-pendulum",
    "gyroscope-on-a-stand",
]
#: The engines that are always there, whatever else is installed.
ENGINES = ("mujoco", "pybullet")
#: What a phase is spent in: module or class, and the name of the function there. The inner phase
#: counts where one is within another.
PHASES: dict[str, list[tuple[Any, str]]] = {
    "exact motion": [(study, "prepare")],
    "stepping and recording": [
        (session, name)
        for session in (mujoco.engine.MuJoCoSession, pybullet.engine.PyBulletSession)
        for name in ("advance", "record")
    ],
    "loading models": [(engine, "open") for engine in map(engines().get, ENGINES)],
    "checking states": [(sampling, "_checked")],
    "single steps": [(study, "_examine")],
    "comparing": [(convergence_study, "compared")],
    "judging": [(richardson.RichardsonLadder, "add"), (ladder, "judge_signal")],
    "storing": [(Store, "put"), (Store, "put_verdict"), (Store, "put_scene")],
    "timing": [(study, "time_scene")],
}


def main() -> None:
    names = sys.argv[1:] or SCENES
    with TemporaryDirectory() as folder:
        cpu, results = whole_run(names, Path(folder, "whole.sqlite"))
        shares = phases(names, Path(folder, "phases.sqlite"))
    bare = stepping_again(names, results)
    timed = sum(row.steps * (row.seconds_per_step or 0.0) for row in results.rows)
    table = Table("phase", "CPU s", "share", title=f"{len(names)} scenes, in one process")
    total = sum(shares.values())
    for phase, seconds in sorted(shares.items(), key=lambda item: -item[1]):
        table.add_row(phase, f"{seconds:.1f}", f"{seconds / total:.1%}")
    console = Console()
    console.print(table)
    console.print(f"whole run {cpu:.1f} CPU s, bare stepping {bare:.1f}: {cpu / bare:.2f}")
    console.print(f"by the steps' stored times, bare stepping {timed:.1f}: {cpu / timed:.2f}")
    OUT.parent.mkdir(parents=True, exist_ok=True)
    record = {"scenes": names, "cpu": cpu, "bare": bare, "timed": timed, "phases": shares}
    OUT.write_text(json.dumps(record, indent=1))


def whole_run(names: list[str], out: Path) -> tuple[float, Results]:
    """CPU seconds of the command and of all the processes it starts, and what it found."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = Path(sys.executable).with_name("spincheck")
    chosen = [part for name in ENGINES for part in ("--engine", name)]
    subprocess.run(
        [command, "run", *names, *chosen, "--out", out], capture_output=True, check=False
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open_store(out) as store:
        results = store.read()
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, results


def stepping_again(names: list[str], results: Results) -> float:
    """CPU seconds of the native calls alone, for the steps of all stored runs."""
    paths = dict(zip(names, find(names), strict=True))
    runs = [
        (paths[row.key.scenario], row.key.engine, row.key.method, row.timestep, row.steps)
        for row in results.rows
        if row.steps
    ]
    # The longest first, so that all processes are busy to the end, as in the run.
    runs.sort(key=lambda run: -run[-1])
    with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn")) as pool:
        return sum(pool.map(advanced, runs))


def advanced(run: tuple[Path, str, str, float, int]) -> float:
    """CPU seconds of one run's steps, in one call."""
    path, engine_name, method_name, timestep, steps = run
    engine = engines()[engine_name]
    with engine.open(load(path), engine.method(method_name), timestep) as session:
        seconds, _ = session.timed(steps)
    return seconds


def phases(names: list[str], out: Path) -> dict[str, float]:
    """CPU seconds by phase of a run in this process."""
    spent: dict[str, float] = defaultdict(float)
    scenarios = [load(path) for path in find(names)]
    choice = Choice(tuple(engines()[name] for name in ENGINES))
    with clocks(spent), open_store(out, create=True) as store:
        begun = time.process_time()
        left = plan(scenarios, choice, store)
        study.run_study(left, choice, store, InProcess(), lambda _: None)
        whole = time.process_time() - begun
    spent["rest"] = whole - sum(spent.values())
    return dict(spent)


@contextmanager
def clocks(spent: dict[str, float]) -> Iterator[None]:
    """Count CPU seconds of the functions of each phase, without those of phases within."""
    within: list[float] = []

    def clocked(phase: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def counting(*args: Any, **kwargs: Any) -> Any:
            within.append(0.0)
            begun = time.process_time()
            try:
                return function(*args, **kwargs)
            finally:
                seconds = time.process_time() - begun
                spent[phase] += seconds - within.pop()
                if within:
                    within[-1] += seconds

        return counting

    kept = []
    for phase, places in PHASES.items():
        for place, name in places:
            kept.append((place, name, getattr(place, name)))
            setattr(place, name, clocked(phase, getattr(place, name)))
    try:
        yield
    finally:
        for place, name, function in kept:
            setattr(place, name, function)


if __name__ == "__main__":
    main()
