"""Workers as an executor: they wait, cancel and stop as executors do, from any process."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, wait
from contextlib import suppress
from pathlib import Path

import pytest
from spincheck.reports.harness.executors.local_workers import Workers
from spincheck.reports.harness.executors.worker_slot import CallFailed

#: s; far longer than any test waits.
FOREVER = 600.0
#: s; what a stop may take, on a machine that is busy with other tests.
PATIENCE = 10.0


def square(x: int, *, plus: int = 0) -> int:
    return x * x + plus


def started(mark: Path) -> None:
    mark.touch()
    time.sleep(FOREVER)


def test_it_maps_like_any_executor():
    with Workers(jobs=2) as pool:
        assert isinstance(pool, Executor)
        assert list(pool.map(square, range(5))) == [0, 1, 4, 9, 16]


def test_keywords_travel():
    with Workers(jobs=1) as pool:
        assert pool.submit(square, 3, plus=1).result() == 10


def test_leaving_waits_for_what_is_under_way():
    with Workers(jobs=1) as pool:
        calls = [pool.submit(square, x) for x in range(3)]
    assert [call.result(timeout=0) for call in calls] == [0, 1, 4]


def test_a_lost_call_raises_where_its_result_is_asked_for():
    with Workers(jobs=1) as pool, pytest.raises(CallFailed, match="exit code 5"):
        pool.submit(os._exit, 5).result()


def test_after_the_end_nothing_is_taken():
    pool = Workers(jobs=1)
    pool.shutdown()
    with pytest.raises(RuntimeError, match="'submit' must come before 'shutdown'"):
        pool.submit(square, 1)


def test_killed_it_ends_at_once_and_nobody_waits_in_vain(tmp_path):
    pool = Workers(jobs=1)
    hanging, waiting = pool.submit(started, tmp_path / "mark"), pool.submit(square, 1)
    while not (tmp_path / "mark").exists():
        time.sleep(0.01)
    began = time.monotonic()
    pool.kill()
    assert time.monotonic() - began < PATIENCE
    assert waiting.cancelled()
    assert isinstance(hanging.outcome(), CallFailed)


def test_an_error_in_the_block_kills_what_is_under_way():
    hanging = []
    with suppress(ZeroDivisionError), Workers(jobs=1) as pool:
        hanging += [pool.submit(time.sleep, FOREVER) for _ in range(2)]
        raise ZeroDivisionError
    assert wait(hanging, timeout=PATIENCE).done == set(hanging)


def test_a_cancelled_call_is_never_made(tmp_path):
    with Workers(jobs=1) as pool:
        first = pool.submit(square, 1)
        second = pool.submit(Path.touch, tmp_path / "mark")
        cancelled = second.cancel()
        first.result()
    assert not (cancelled and (tmp_path / "mark").exists())


def in_a_daemon(answer) -> None:
    with Workers(jobs=1) as pool:
        answer.send(pool.submit(square, 4).result())


def test_a_daemonic_process_may_have_workers():
    """As the processes of a cluster are; multiprocessing's own children are refused there."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=in_a_daemon, args=(theirs,), daemon=True)
    process.start()
    assert ours.recv() == 16
    process.join()


MAIN = """
from operator import mul
from spincheck.reports.harness.executors.local_workers import Workers
print("main")
with Workers(jobs=1) as pool:
    print(pool.submit(mul, 6, 7).result())
"""


def test_a_script_without_a_guard_is_not_run_again_by_its_workers(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(MAIN)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout == "main\n42\n"


INTERRUPTED = """
import sys, time
from pathlib import Path
from spincheck.reports.harness.executors.local_workers import Workers
try:
    with Workers(jobs=2) as pool:
        pool.submit(Path.touch, Path(sys.argv[1])).result()
        pool.submit(time.sleep, 600).result()
except KeyboardInterrupt:
    print("stopped")
"""


def test_ctrl_c_ends_the_wait_and_the_workers(tmp_path):
    mark = tmp_path / "mark"
    parent = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, mark],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    while not mark.exists():
        time.sleep(0.01)
    began = time.monotonic()
    os.killpg(parent.pid, signal.SIGINT)
    out, _ = parent.communicate()
    assert time.monotonic() - began < PATIENCE
    assert (parent.returncode, out) == (0, "stopped\n")
