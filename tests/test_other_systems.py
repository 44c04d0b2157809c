"""On Windows nothing that it lacks is called, as far as that can be seen from Linux."""

import errno
import os
import signal
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import importable_files
import pytest
from spincheck.engines.child.process import ChildProcess, ProtocolError
from spincheck.engines.versions.folders import VersionError, install_for
from spincheck.reports.cli import stopping
from spincheck.reports.harness.executors import worker_main
from spincheck.reports.results.only_writer import only_writer
from spincheck.reports.results.result_file import ResultFileError

#: What the standard library of Windows has none of.
ABSENT = ("fcntl", "resource", "termios", "pwd", "grp")


@pytest.fixture(autouse=True)
def _windows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    for name in ABSENT:
        monkeypatch.setitem(sys.modules, name, None)
    # CPython 3.11; on 3.12 it is there.
    for name in ("set_blocking", "sysconf", "getuid", "killpg"):
        monkeypatch.delattr(os, name)


def test_a_result_file_is_locked_by_its_own_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    locked: list[tuple[int, int]] = []

    def locking(descriptor: int, mode: int, count: int) -> None:
        if locked:
            raise OSError(errno.EACCES, "refused")
        locked.append((mode, count))

    monkeypatch.setitem(sys.modules, "msvcrt", SimpleNamespace(locking=locking, LK_NBLCK=2))
    # A file system of Linux may have no place so far on.
    monkeypatch.setattr("spincheck.reports.results.only_writer._BEYOND", 1 << 40)
    path = tmp_path / "results.sqlite"
    with (
        only_writer(path),
        pytest.raises(ResultFileError, match="another 'spincheck run'"),
        only_writer(path),
    ):
        pass
    assert locked == [(2, 1)]


def test_test_files_that_cannot_be_imported_there_are_skipped(tmp_path: Path) -> None:
    file = tmp_path / "test_it.py"
    for text, why in {
        "import resource\n": importable_files.NO_POSIX,
        "PIPE = (os.mkfifo, '')\n": importable_files.NO_POSIX,
        "import resources\n": "",
    }.items():
        file.write_text(text, encoding="utf-8")
        assert importable_files.why_skipped(file) == why


def test_memory_is_not_bounded() -> None:
    worker_main._bound_memory()
    assert not worker_main._is_memory_limited()


def test_stopping_watches_a_pipe_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    watched: list[int] = []
    monkeypatch.setattr(signal, "set_wakeup_fd", lambda fd, **_: watched.append(fd))
    stopping._watch([signal.SIGINT], threading.Event())
    assert len(watched) == 1


def test_what_needs_another_system_is_refused_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(ProtocolError, match=r"^'my-engine' needs a pipe that Windows cannot hand"):
        ChildProcess(["my-engine"], 1.0)
    with pytest.raises(VersionError, match=r"^'--python' needs an environment as Linux and macOS"):
        install_for("python", "name", [], [])
