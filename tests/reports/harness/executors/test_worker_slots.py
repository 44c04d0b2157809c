"""Workers: a call that crashes, hangs, exits or is killed costs itself and nothing else."""

import ctypes
import mmap
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from spincheck.reports.harness.executors import local_workers as workers
from spincheck.reports.harness.executors.local_workers import Workers
from spincheck.reports.harness.executors.worker_process import KEPT_OUTPUT, MEMORY_SHARE
from spincheck.reports.harness.executors.worker_slot import LAST_WORDS, CallFailed

LIBC = ctypes.CDLL(None)
#: s; far longer than any test waits.
FOREVER = 600.0


def double(x: int) -> int:
    return 2 * x


def abort_with_last_words() -> None:
    os.write(2, b"first line\nassertion `mass > 0` failed\n")
    os.abort()


def abort_with_words_in_a_buffer() -> None:
    LIBC.printf(b"said by C, no newline")
    os.abort()


def say(text: str) -> int:
    LIBC.puts(b"from C")
    print(text)
    return 1


def crash() -> None:
    ctypes.string_at(0)


def leave(code: int) -> None:
    os._exit(code)


def exit_politely() -> None:
    raise SystemExit(3)


def killed_the_first_time(mark: Path) -> str:
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "second attempt"


def killed_every_time() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def unpicklable() -> object:
    return lambda: None


def big() -> bytes:
    return bytes(1 << 24)


@pytest.fixture
def pool():
    with Workers(jobs=1) as started:
        yield started


def reason(pool: Workers, call, *arguments) -> str:
    lost = pool.submit(call, *arguments).outcome()
    assert isinstance(lost, CallFailed)
    return lost.reason


def test_a_call_returns(pool):
    assert pool.submit(double, 21).outcome() == 42


def test_a_result_larger_than_any_pipe_arrives(pool):
    assert pool.submit(big).outcome() == big()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (crash, "killed by SIGSEGV"),
        (abort_with_last_words, "killed by SIGABRT; it last printed: assertion `mass > 0` failed"),
        (abort_with_words_in_a_buffer, "killed by SIGABRT; it last printed: said by C, no newline"),
        (exit_politely, "SystemExit: 3"),
        (unpicklable, "lambda"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_a_lost_call_says_why_and_the_next_one_runs(pool, call, words):
    assert words in reason(pool, call)
    assert pool.submit(double, 1).outcome() == 2


def test_a_call_that_leaves_tells_its_exit_code(pool):
    assert reason(pool, leave, 7) == "the worker process ended with exit code 7"


def test_arguments_that_cannot_travel_lose_the_call_alone(pool):
    assert "lambda" in reason(pool, double, lambda: None)


def test_a_call_that_hangs_is_stopped(monkeypatch):
    monkeypatch.setattr(workers, "TIME_LIMIT", 5.0)
    with Workers(jobs=1) as pool:
        assert reason(pool, time.sleep, FOREVER) == "did not finish within 5 s"


def test_a_time_limit_of_ones_own_is_kept():
    with Workers(jobs=1, time_limit=4.0) as pool:
        assert reason(pool, time.sleep, FOREVER) == "did not finish within 4 s"


def test_what_is_printed_by_c_and_python_is_kept_with_its_own_call(pool):
    tasks = [pool.submit(say, "one"), pool.submit(double, 1), pool.submit(say, "two")]
    assert [task.outcome() for task in tasks] == [1, 2, 1]
    assert [task.printed for task in tasks] == ["from C\none\n", "", "from C\ntwo\n"]


def test_nothing_printed_reaches_the_terminal(capfd, pool):
    pool.submit(say, "secret").outcome()
    assert capfd.readouterr() == ("", "")


def test_of_much_output_the_end_is_kept(pool):
    task = pool.submit(say, "x" * KEPT_OUTPUT + "the end")
    task.outcome()
    assert len(task.printed) == KEPT_OUTPUT
    assert task.printed.endswith("the end\n")


def print_megabytes(count: int) -> None:
    for _ in range(count):
        os.write(1, bytes(1 << 20))
    os.write(1, b"the end")


def test_however_much_is_printed_nothing_but_the_end_is_kept(pool):
    call = pool.submit(print_megabytes, 256)
    assert call.outcome() is None
    assert call.printed.endswith("the end")
    assert len(call.printed) == KEPT_OUTPUT


def print_for_ever() -> None:
    while True:
        os.write(1, bytes(1 << 20))


def test_a_call_that_prints_for_ever_is_stopped(monkeypatch):
    monkeypatch.setattr(workers, "TIME_LIMIT", 5.0)
    with Workers(jobs=1) as pool:
        assert "did not finish within 5 s" in reason(pool, print_for_ever)


def close_its_output() -> str:
    os.close(1)
    os.close(2)
    time.sleep(0.1)
    return "done"


def test_a_call_that_closes_its_output_returns(pool):
    assert pool.submit(close_its_output).outcome() == "done"
    assert pool.submit(double, 1).outcome() == 2


def hold(share: float) -> int:
    """Of the machine's memory; the system gives what is not written to on credit."""
    bytes_there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return len(mmap.mmap(-1, int(share * bytes_there), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS))


def test_a_call_that_holds_too_much_memory_is_refused_it(pool):
    assert "Cannot allocate memory" in reason(pool, hold, MEMORY_SHARE)
    assert pool.submit(hold, MEMORY_SHARE / 2).outcome() > 0


def test_a_long_last_line_is_cut(pool):
    words = reason(pool, _abort_saying, "y" * 2 * LAST_WORDS)
    assert words.endswith(": " + "y" * LAST_WORDS)


def _abort_saying(text: str) -> None:
    os.write(1, text.encode())
    os.abort()


def test_a_call_whose_worker_is_killed_from_outside_is_tried_again(tmp_path, pool):
    task = pool.submit(killed_the_first_time, tmp_path / "mark")
    assert task.outcome() == "second attempt"


def test_a_call_that_is_killed_again_is_lost_through_no_fault_of_its_own(pool):
    lost = pool.submit(killed_every_time).outcome()
    assert lost.killed
    assert "SIGKILL" in lost.reason


def test_a_crash_is_its_own_fault(pool):
    assert not pool.submit(crash).outcome().killed


def test_a_worker_killed_while_idle_costs_no_call(pool):
    pid = pool.submit(os.getpid).outcome()
    os.kill(pid, signal.SIGKILL)
    assert pool.submit(killed_every_time).outcome().killed
    assert pool.submit(os.getpid).outcome() != pid


def test_of_calls_that_wait_the_least_rank_is_called_first(pool):
    tasks = {rank: pool.submit_ranked(rank, time.monotonic) for rank in (3, 1, 2)}
    called = {rank: task.outcome() for rank, task in tasks.items()}
    assert sorted(called, key=called.__getitem__) == [1, 2, 3]


def test_calls_run_side_by_side():
    with Workers(jobs=2) as pool:
        tasks = [pool.submit(os.getpid) for _ in range(2)] + [pool.submit(time.sleep, 0.1)]
        for task in tasks:
            task.outcome()
    assert tasks[0].result() != tasks[1].result()


PARENT = """
import os, sys, time
from spincheck.reports.harness.executors.local_workers import Workers
if __name__ == "__main__":
    pool = Workers(jobs=2)
    print(pool.submit(os.getpid).outcome(), flush=True)
    pool.submit(time.sleep, 600.0).outcome()
"""


def test_no_worker_outlives_a_parent_that_is_killed(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    parent = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True)
    assert parent.stdout
    worker = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()
    deadline = time.monotonic() + 5
    while Path(f"/proc/{worker}").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not Path(f"/proc/{worker}").exists()
