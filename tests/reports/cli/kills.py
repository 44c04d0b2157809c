"""Kills `spincheck run` again and again, at random moments, and looks at what is left.

A worker, the run itself, or its whole process group is killed with SIGKILL. Afterwards no process
may be left, the result file must be whole, and the same command must go on from there to results
that are those of an undisturbed run to the last bit, times aside, without making a run again that
was stored.

    PYTHONPATH=tests/support python tests/reports/cli/kills.py [ROUNDS]
"""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

from default_signals import WITH_DEFAULT_SIGNALS
from same_results import differences
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store

COMMAND = Path(sys.executable).with_name("spincheck")
#: A scene of short ladders, all steps timed.
STUDY = ("gazebo-box-tumbling", "--engine", "mujoco", "--method", "Euler", "--method", "RK4")
ROUNDS = 24
SEED = 20260101
#: s; for what ends at once, on a machine that is busy with other things.
PATIENCE = 30.0
#: s; far more than the study takes.
HANGS = 200.0

Target = Literal["worker", "run", "group"]
TARGETS: tuple[Target, ...] = ("worker", "run", "group")


@dataclass(frozen=True)
class Kill:
    """What was killed, when, and what came of it.

    Attributes
    ----------
    seconds : from the start
    rows, timed : how many runs were stored by then, and methods timed
    faults : what is wrong, in words; nothing if all is well
    """

    target: Target
    seconds: float
    rows: int
    timed: int
    faults: tuple[str, ...]


def start(path: Path, *options: str, jobs: int = 2) -> subprocess.Popen[str]:
    """`spincheck run` in a process group of its own."""
    command = [COMMAND, "run", *STUDY, "--jobs", str(jobs), "--out", path, *options]
    return subprocess.Popen(
        [*WITH_DEFAULT_SIGNALS, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # Should it hang, SIGABRT has it tell where.
        env=os.environ | {"PYTHONFAULTHANDLER": "1"},
    )


def finish(path: Path, *options: str) -> str:
    """Run to the end; returns stderr."""
    run = start(path, *options, jobs=1)
    _, err = run.communicate()
    assert run.returncode == 0, err
    return err


def read(path: Path) -> Results:
    with open_store(path) as store:
        return store.read()


def rounds(folder: Path, number: int, seed: int = SEED) -> Iterator[Kill]:
    """Kill so many studies, each once, the targets in turn."""
    other = folder / "undisturbed.sqlite"
    began = time.monotonic()
    finish(other)
    lasts = time.monotonic() - began
    expected, moments = read(other), random.Random(seed)
    for k, target in enumerate(islice(cycle(TARGETS), number)):
        while (kill := one_round(folder / f"{k}.sqlite", target, lasts, moments, expected)) is None:
            # It ended before it was killed; another moment will do.
            (folder / f"{k}.sqlite").unlink()
        yield kill


def one_round(
    path: Path, target: Target, lasts: float, moments: random.Random, expected: Results
) -> Kill | None:
    """Kill one study and go on with it; None if it ended before."""
    run = start(path)
    seconds = moments.uniform(0, lasts)
    time.sleep(seconds)
    workers = children(run.pid)
    if run.poll() is not None or (target == "worker" and not workers):
        run.communicate()
        return None
    before = stored(path)
    if target == "group":
        os.killpg(run.pid, signal.SIGKILL)
    else:
        os.kill(run.pid if target == "run" else moments.choice(workers), signal.SIGKILL)
    err = ended(run)
    faults = [] if is_gone(run.pid) else ["a process is left over"]
    if target == "worker" and run.returncode != 0:
        faults.append(f"exit code {run.returncode}: {err}")
    faults += after(path, expected)
    timed = sum(table == "costs" for table, *_ in before)
    return Kill(target, seconds, len(before) - timed, timed, tuple(faults))


def ended(run: subprocess.Popen[str]) -> str:
    """What a run has printed to stderr when it ends; of one that hangs, where it does."""
    try:
        return run.communicate(timeout=HANGS)[1]
    except subprocess.TimeoutExpired:
        run.send_signal(signal.SIGABRT)
        return f"hangs: {run.communicate()[1]}"


def after(path: Path, expected: Results, go_on: Callable[[Path], object] = finish) -> Iterator[str]:
    """What is wrong with a file when its study was killed, and when it has been gone on with."""
    if path.exists():
        with closing(sqlite3.connect(path)) as connection:
            (integrity,) = connection.execute("PRAGMA integrity_check").fetchone()
            if integrity != "ok":
                yield f"integrity: {integrity}"
    before = stored(path)
    go_on(path)
    # A record that is written again gets another row id.
    missing = before - stored(path)
    yield from (f"made again: {record}" for record in missing)
    yield from differences(read(path), expected)


def stored(path: Path) -> set[tuple[object, ...]]:
    """The runs and timings in a file that is perhaps just being begun, with their row ids."""
    runs = "SELECT 'rows', rowid, scenario, engine, method, timestep FROM rows"
    costs = "SELECT 'costs', rowid, scenario, engine, method, 0 FROM costs"
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as connection:
            return set(connection.execute(f"{runs} UNION ALL {costs}").fetchall())
    except sqlite3.OperationalError:
        return set()


def children(parent: int) -> list[int]:
    """Its workers, each a child of one of its threads."""
    pids = []
    for thread in Path(f"/proc/{parent}/task").glob("*"):
        try:
            pids += [int(child) for child in (thread / "children").read_text().split()]
        except OSError:
            # The thread has ended.
            continue
    return pids


def is_gone(group: int) -> bool:
    """Whether a process group has no process left, dead ones to be reaped by others aside."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if not any(_belongs(process, group) for process in Path("/proc").glob("[0-9]*")):
            return True
        time.sleep(0.01)
    return False


def _belongs(process: Path, group: int) -> bool:
    try:
        # proc(5), stat: after the name in parentheses come state, parent and process group.
        state, _, pgrp = (process / "stat").read_text().rpartition(")")[2].split()[:3]
    except OSError:
        return False
    return int(pgrp) == group and state != "Z"


def main() -> None:
    """Kill, and print a line each; exit code 1 if anything is wrong."""
    number = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    wrong = 0
    with TemporaryDirectory() as folder:
        for k, kill in enumerate(rounds(Path(folder), number), start=1):
            at = f"{kill.target} killed after {kill.seconds:.2f} s"
            outcome = "; ".join(kill.faults) or "ended as undisturbed"
            print(
                f"[{k}/{number}] {at}, {kill.rows} runs, {kill.timed} timed: {outcome}", flush=True
            )
            wrong += bool(kill.faults)
    print(f"{number} kills, {wrong} of them with something wrong")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
