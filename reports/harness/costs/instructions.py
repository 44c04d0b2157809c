"""Counts the instructions that a step takes, under valgrind: equal from run to run, as no time is.

Only what is executed inside the engine's own function that steps counts: callgrind switches
collecting on where that is entered and off where it is left (`--toggle-collect`, Valgrind User
Manual, chapter 6). Until the steps begin the program runs without being instrumented, which takes
a fraction of the time.
"""

import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from threading import Timer

from ....engines import Engine, Method
from ....engines.start_process import kill, run, start
from ....scenarios import Scenario, loads
from ....scenarios.regular_files import write_new

#: Steps that are counted, and those before, which fill caches.
STEPS, WARM_UP = 256, 16
#: s that a count may take, of which most is starting.
LIMIT = 300.0
#: What the program says when the steps are next.
READY = "ready\n"
#: Hashes of words would differ from process to process.
ENVIRONMENT = {"PYTHONHASHSEED": "0"}
_TOTAL = re.compile(r"^(?:summary|totals): (\d+)", re.MULTILINE)


def why_not_counted() -> str:
    """Why nothing can be counted here; empty if it can."""
    return "" if which("callgrind_control") else "valgrind is not installed"


def instructions_per_step(
    scenario: Scenario, engine: Engine, method: Method, timestep: float
) -> float | None:
    """The instructions of a step; None if the engine does not name what steps, or it fails."""
    if not engine.steps_in or engine.site:
        return None
    kind = type(engine)
    with TemporaryDirectory() as folder:
        text, counts = Path(folder) / "scene.toml", Path(folder) / "counts"
        write_new(text, scenario.text)
        opening = [str(text), scenario.name, str(scenario.path), kind.__module__, kind.__qualname__]
        program = [sys.executable, "-P", "-m", __name__, *opening, method.name, repr(timestep)]
        collect = f"--toggle-collect={engine.steps_in}"
        tool = ["valgrind", "--tool=callgrind", "--instr-atstart=no", collect]
        try:
            _run([*tool, f"--callgrind-out-file={counts}", *program])
            found = _TOTAL.search(counts.read_text(encoding="utf-8"))
        except (OSError, subprocess.TimeoutExpired):
            return None
    # Without a call of that function the total is 0.
    return int(found[1]) / STEPS or None if found else None


def _run(command: list[str]) -> None:
    """Run a program, instrumented from where it says that it is ready."""
    process = start(
        command,
        env=os.environ | ENVIRONMENT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    too_long = Timer(LIMIT, kill, [process])
    too_long.start()
    try:
        if process.stdout and process.stdout.readline() == READY:
            run(["callgrind_control", "--instr=on", str(process.pid)], LIMIT)
            process.communicate("\n")
    finally:
        too_long.cancel()
        kill(process)


def main(text: str, name: str, path: str, module: str, kind: str, method: str, dt: str) -> None:
    """Open a scene, say so, and step when told to."""
    scenario = loads(Path(text).read_text(encoding="utf-8"), name, Path(path))
    engine = getattr(import_module(module), kind)()
    with engine.open(scenario, engine.method(method), float(dt)) as session:
        session.advance(WARM_UP)
        print(READY, end="", flush=True)
        if sys.stdin.readline():
            session.advance(STEPS)


if __name__ == "__main__":
    main(*sys.argv[1:])
