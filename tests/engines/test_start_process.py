"""Processes are started in one place; none outlives the process that started it."""

import ast
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
import sources
from spincheck.engines import start_process
from spincheck.engines.child import ProtocolError, child_engine
from spincheck.engines.versions import VersionError, folders
from spincheck.reports.harness.executors import LocalWorkers

PLANTED = Path(__file__).parent / "child" / "planted_child.py"
#: What starts a process; of `os`, by the beginnings of the names.
STARTERS = ("subprocess", "multiprocessing", "pty", "concurrent.futures.process")
OF_OS = (
    "os.system",
    "os.popen",
    "os.fork",
    "os.exec",
    "os.spawn",
    "os.posix_spawn",
    "os.startfile",
)
#: Those that only name `subprocess.TimeoutExpired`, or its pipes.
NAMED_ONLY = {"TimeoutExpired", "PIPE", "STDOUT", "DEVNULL", "Popen[Any]", "CompletedProcess[str]"}
#: s; for what ends at once, on a machine that is busy with other things.
PATIENCE = 30.0


def starts(node: ast.AST) -> bool:
    if isinstance(node, ast.ImportFrom):
        return (node.module or "").startswith(STARTERS)
    if isinstance(node, ast.Import):
        return any(name.name in STARTERS[1:] for name in node.names)
    if isinstance(node, ast.Attribute):
        name = ast.unparse(node)
        return name.startswith(OF_OS) or (
            name.startswith("subprocess.") and node.attr not in NAMED_ONLY
        )
    return False


def test_nothing_else_starts_a_process() -> None:
    assert sources.files_with(starts) == {"engines/start_process.py"}


#: Modules that every Python imports when it starts, that pip, venv or a worker imports.
SHADOWS = ("pip", "venv", "ensurepip", "json", "ctypes", "struct", "pickle", "signal", "contextlib")


@pytest.fixture
def hostile(tmp_path, monkeypatch) -> Path:
    """The current folder, with modules that leave a mark when they are imported; no network."""
    for name in SHADOWS:
        mark = f"import pathlib\npathlib.Path({str(tmp_path)!r}, 'executed-{name}').touch()\n"
        (tmp_path / f"{name}.py").write_text(mark)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    return tmp_path


def of_pip() -> None:
    with pytest.raises(VersionError, match="pip cannot install"):
        folders.install("mujoco@0.0.1", ["mujoco==0.0.1"])


def of_venv() -> None:
    with pytest.raises(VersionError, match="pip cannot install"):
        folders.install_for(sys.executable, "mujoco@0.0.1", ["mujoco==0.0.1"], [])


def of_worker() -> None:
    with LocalWorkers(1) as workers:
        assert workers.call(int, "1").value == 1


@pytest.mark.processes
@pytest.mark.parametrize("start", [of_pip, of_venv, of_worker])
def test_no_module_of_the_current_folder_is_executed(hostile, start) -> None:
    start()
    assert [path.name for path in hostile.glob("executed-*")] == []


def pids_in(file: Path, count: int) -> list[int]:
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        found = file.read_text().split() if file.exists() else []
        if len(found) == count:
            return [int(pid) for pid in found]
        time.sleep(0.02)
    raise AssertionError(f"{count} processes did not start")


def is_gone(pid: int) -> bool:
    """Whether a process ends in time; one that is dead and that nobody reaps has."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.02)
    return False


#: Starts a process that starts another; neither ever reads or ends.
STARTS_TWO = """
import subprocess, sys, time
from spincheck.engines.start_process import start
process = start(["sh", "-c", "sleep 600 & echo $!; exec sleep 600"], stdout=subprocess.PIPE)
with open(sys.argv[1], "wb") as pids:
    pids.write(b"%d %s" % (process.pid, process.stdout.readline()))
time.sleep(600)
"""


@pytest.mark.processes
def test_what_a_process_has_started_goes_with_it_when_it_is_killed(tmp_path) -> None:
    file = tmp_path / "pids"
    parent = subprocess.Popen([sys.executable, "-c", STARTS_TWO, str(file)])
    pids = pids_in(file, 2)
    parent.kill()
    parent.wait()
    assert all(map(is_gone, pids))


def busy_in_a_child(file: str) -> None:
    """In a worker: call an engine that is busy for ever."""
    child_engine([sys.executable, "-S", str(PLANTED), "busy", file], PATIENCE * 10)


CALLS = f"""
import sys
sys.path += {[str(Path(file).parent) for file in (__file__, sources.__file__)]!r}
from spincheck.reports.harness.executors import LocalWorkers
from test_start_process import busy_in_a_child
with LocalWorkers(1) as workers:
    workers.call(busy_in_a_child, sys.argv[1])
"""


@pytest.mark.processes
def test_an_engine_that_is_busy_goes_with_a_run_that_is_killed(tmp_path) -> None:
    file = tmp_path / "pids"
    run = subprocess.Popen([sys.executable, "-c", CALLS, str(file)])
    pids = pids_in(file, 2)
    run.kill()
    run.wait()
    assert all(map(is_gone, pids))


@pytest.mark.processes
def test_of_a_guard_that_does_not_end_nothing_is_left(monkeypatch) -> None:
    """Nor a warning of Python's that it still runs: on a busy machine it takes long to begin."""
    guard = start_process._Guard()
    monkeypatch.setattr(start_process, "_guard", guard)
    guarded = start_process.start(["sleep", "600"])
    slow = guard._process
    assert slow is not None
    os.kill(slow.pid, signal.SIGSTOP)
    guard.end()
    assert slow.returncode == guarded.wait(PATIENCE) == -signal.SIGKILL
    start_process.kill(guarded)


@pytest.mark.processes
def test_a_guard_that_is_killed_is_replaced(monkeypatch) -> None:
    # With it would go what other tests have started.
    guard = start_process._Guard()
    monkeypatch.setattr(start_process, "_guard", guard)
    first = start_process.start(["sleep", "600"])
    before = guard._process
    assert before is not None
    os.kill(before.pid, signal.SIGKILL)
    assert is_gone(before.pid)
    second = start_process.start(["sleep", "600"])
    assert guard._process is not before
    guard.end()
    for process in (first, second):
        assert process.wait(PATIENCE) == -signal.SIGKILL
        start_process.kill(process)
    guard.end()


@pytest.mark.processes
def test_a_process_that_holds_the_pipe_of_one_that_ended_is_not_waited_for(tmp_path) -> None:
    file = tmp_path / "pids"
    began = time.monotonic()
    with pytest.raises(ProtocolError, match="ended with exit code 0 instead of answering 'hello'"):
        child_engine(["sh", "-c", f"sleep 600 & echo $! > {file}"], PATIENCE * 10)
    assert time.monotonic() - began < PATIENCE
    assert is_gone(*pids_in(file, 1))
