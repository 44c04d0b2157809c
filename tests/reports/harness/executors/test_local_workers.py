"""Worker processes: a call that crashes, hangs, exits or is killed costs itself and no other."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress

import calls
import psutil
import pytest
from spincheck.engines.lost_process import LAST_LINE
from spincheck.reports.harness.executors import Answer, CallFailed, ExecutorStopped, LocalWorkers
from spincheck.reports.harness.executors.worker_main import MEMORY_SHARE
from spincheck.reports.harness.executors.worker_process import KEPT_OUTPUT

pytestmark = pytest.mark.processes

#: s; far longer than any test waits.
FOREVER = 600.0
#: s; of CPU time for what uses it, of idleness for what hangs.
TIME_LIMIT = 1.0


@pytest.fixture(scope="module")
def worker():
    """One worker for all tests, replaced whenever one makes it die."""
    with LocalWorkers(jobs=1) as started:
        yield started


def failure(answer: Answer) -> CallFailed:
    assert isinstance(answer.value, CallFailed)
    return answer.value


# What is returned


def test_results_and_arguments_larger_than_any_pipe_arrive(worker):
    assert worker.call(calls.megabytes, 16).value == bytes(16 << 20)
    assert worker.call(len, bytes(16 << 20)).value == 16 << 20


@pytest.mark.parametrize(
    "call", [(calls.unpicklable,), (len, lambda: None)], ids=["result", "argument"]
)
def test_what_cannot_be_pickled_fails_the_call_alone(worker, call):
    pid = worker.call(os.getpid).value
    assert "lambda" in failure(worker.call(*call)).reason
    assert worker.call(os.getpid).value == pid


# What takes the process with it


@pytest.mark.parametrize(
    ("call", "cause", "end"),
    [
        ((calls.crash,), "crash", "was killed by SIGSEGV"),
        ((calls.leave_at_once, 7), "crash", "ended with exit code 7"),
        ((calls.close_everything, 0.0), "crash", "ended with exit code 1"),
        ((calls.close_everything, FOREVER), "crash", "closed its pipes instead of answering"),
        # Through no fault of its own, twice.
        ((calls.killed_by, signal.SIGKILL), "killed", "was killed from outside by SIGKILL"),
    ],
)
def test_what_ended_a_worker_is_said_and_the_next_call_returns(worker, call, cause, end):
    assert failure(worker.call(*call)) == CallFailed(f"the worker process {end}", cause)
    assert worker.call(calls.power, 3).value == 9


@pytest.mark.parametrize("error", [KeyboardInterrupt, calls.Panic])
def test_what_is_no_exception_fails_the_call_alone(worker, error):
    pid = worker.call(os.getpid).value
    assert worker.call(calls.throw, error).value == CallFailed(f"{error.__name__}: thrown", "bug")
    assert worker.call(os.getpid).value == pid


def test_what_c_printed_last_is_reported_even_from_its_buffer_and_cut(worker):
    reason = failure(worker.call(calls.abort_after_c_printed, "y" * 2 * LAST_LINE)).reason
    words = "the worker process was killed by SIGABRT; it last printed: "
    assert reason == words + "y" * LAST_LINE


def test_a_call_whose_worker_is_killed_from_outside_is_made_once_more(worker, tmp_path):
    assert worker.call(calls.killed_once, tmp_path / "mark").value == "second attempt"
    # One killed while idle costs no call.
    psutil.Process(worker.call(os.getpid).value).kill()
    assert worker.call(calls.power, 3).value == 9


def test_a_call_that_holds_too_much_memory_is_refused_it(worker):
    assert "Cannot allocate memory" in failure(worker.call(calls.hold, MEMORY_SHARE)).reason
    assert worker.call(calls.hold, MEMORY_SHARE / 2).value > 0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what a process holds")
def test_a_worker_whose_calls_leak_is_replaced_before_a_call_is_refused_memory(worker):
    first = worker.call(calls.leak, MEMORY_SHARE / 4).value
    assert worker.call(calls.leak, MEMORY_SHARE / 3).value == first
    assert worker.call(calls.leak, MEMORY_SHARE / 4).value != first


def test_of_a_full_disk_and_where_no_process_can_be_started_the_machine_is_to_blame(
    worker, monkeypatch
):
    assert failure(worker.call(calls.find_the_disk_full)).cause == "environment"
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with LocalWorkers(jobs=1) as pool:
        failed = failure(pool.call(calls.power, 3))
    assert failed.cause == "environment"
    assert failed.reason.startswith("no worker process could be started: ")


# What does not end


@pytest.mark.parametrize(
    ("call", "words"),
    [
        ((time.sleep, FOREVER), f"did not finish within {TIME_LIMIT:g} s: it hangs"),
        ((calls.spin,), f"did not finish within {TIME_LIMIT:g} s of CPU time"),
        ((calls.print_for_ever,), f"did not finish within {TIME_LIMIT:g} s of CPU time"),
    ],
    ids=["hangs", "computes", "prints"],
)
def test_what_does_not_end_is_stopped(call, words):
    with LocalWorkers(jobs=1, time_limit=TIME_LIMIT) as pool:
        failed = failure(pool.call(*call))
    assert failed.cause == "time-out"
    assert words in failed.reason


# What is printed


def test_what_is_printed_by_c_and_python_is_kept_with_its_own_call(worker, capfd):
    answers = [worker.call(*call) for call in ((calls.say, "one"), (abs, 1), (calls.say, "two"))]
    assert [answer.value for answer in answers] == [1, 1, 1]
    assert [answer.printed for answer in answers] == ["from C\none\n", "", "from C\ntwo\n"]
    assert capfd.readouterr() == ("", "")


def test_however_much_is_printed_nothing_but_the_end_is_kept(worker):
    printed = worker.call(calls.print_megabytes, 64).printed
    assert printed.endswith("the end")
    assert len(printed) == KEPT_OUTPUT
    # A call that closes its output returns.
    assert worker.call(calls.close_its_output).value == "done"
    assert worker.call(calls.power, 3).value == 9


# What is left behind


MAIN = """
import sys
from operator import mul
from spincheck.reports.harness.executors import LocalWorkers
print("main")
with LocalWorkers(jobs=1) as pool:
    print(pool.call(mul, 6, 7).value, flush=True)
    {then}
"""


def test_a_script_without_a_guard_is_not_run_again_by_its_workers(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(MAIN.format(then=""))
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout == "main\n42\n"


def test_no_worker_outlives_a_parent_that_is_killed(tmp_path):
    script = tmp_path / "script.py"
    then = (
        "import os, time; print(pool.call(os.getpid).value, flush=True); pool.call(time.sleep, 600)"
    )
    script.write_text(MAIN.format(then=then))
    parent = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True)
    with parent.stdout as printed:
        worker = psutil.Process(int([next(printed) for _ in range(3)][-1]))
        parent.kill()
        parent.wait()
    gone, _ = psutil.wait_procs([worker])
    assert gone == [worker]


def test_an_error_in_the_block_ends_what_is_under_way(tmp_path):
    begun, end = tmp_path / "begun", tmp_path / "end"
    stopped: list[bool] = []

    def wait(pool: LocalWorkers) -> None:
        try:
            pool.call(calls.mark_and_wait, begun, end)
        except ExecutorStopped:
            stopped.append(True)

    with suppress(ZeroDivisionError), LocalWorkers(jobs=2) as pool:
        thread = threading.Thread(target=wait, args=(pool,))
        thread.start()
        while not begun.exists():
            time.sleep(0.01)
        raise ZeroDivisionError
    thread.join()
    assert stopped == [True]
