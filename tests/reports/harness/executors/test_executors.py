"""Every executor makes calls and runs tasks alike, wherever its calls are made."""

import itertools
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import calls
import pytest
from spincheck.reports.harness.executors import (
    CallFailed,
    Executor,
    ExecutorStopped,
    InProcess,
    LocalWorkers,
)
from spincheck.reports.harness.executors.executor import QUEUED_PER_THREAD

#: Worker processes.
JOBS = 2


def in_process() -> Executor:
    return InProcess()


def local_workers() -> Executor:
    return LocalWorkers(JOBS)


KINDS = [
    in_process,
    pytest.param(local_workers, marks=pytest.mark.processes),
]


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: kind.__name__)
def executor(request) -> Iterator[Executor]:
    """One of each kind, that all tests share: what it starts is started once."""
    with request.param() as opened:
        yield opened


def test_a_call_returns_what_the_function_does(executor):
    assert executor.call(calls.power, 3, exponent=4).value == 81
    # Alone it makes one call at a time.
    alone = executor.alone()
    assert alone.width == 1
    assert alone.call(calls.power, 5).value == 25


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (calls.divide_by_zero, "ZeroDivisionError: a bug in an adapter"),
        (calls.leave_politely, "SystemExit: 3"),
    ],
)
def test_a_call_that_raises_fails_in_words_and_the_next_one_returns(executor, function, reason):
    assert executor.call(function).value == CallFailed(reason, "bug")
    assert executor.call(calls.power, 3).value == 9


def test_each_yields_what_every_task_returns(executor):
    tasks = [partial(executor.call, calls.power, base) for base in range(7)]
    values = sorted(answer.value for answer in executor.each(tasks))
    assert values == [base**2 for base in range(7)]


def test_each_begins_tasks_in_their_order(executor):
    begun: list[int] = []
    all_begun = threading.Event()
    # All threads but one wait for the rest to have gone through that one.
    waiting = [all_begun.wait] * (executor.width - 1)
    numbered = [partial(begun.append, k) for k in range(20)]
    for _ in executor.each([*waiting, *numbered, all_begun.set]):
        pass
    assert begun == list(range(20))


def test_each_takes_tasks_as_threads_become_free(executor_of_its_own):
    taken = itertools.count()
    endless = (partial(int, next(taken)) for _ in itertools.count())
    done = list(itertools.islice(executor_of_its_own.each(endless), 10))
    assert next(taken) <= len(done) + (1 + QUEUED_PER_THREAD) * executor_of_its_own.width


def test_where_a_task_raises_no_further_one_is_begun(executor_of_its_own):
    begun = itertools.count()

    def raising() -> None:
        next(begun)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        list(executor_of_its_own.each(raising for _ in itertools.count()))
    assert next(begun) <= (1 + QUEUED_PER_THREAD) * executor_of_its_own.width


def test_several_threads_may_call_at_once(executor):
    with ThreadPoolExecutor(JOBS) as threads:
        answers = threads.map(partial(executor.call, calls.power), range(JOBS))
        assert [answer.value for answer in answers] == [0, 1]


@pytest.fixture(params=KINDS, ids=lambda kind: kind.__name__)
def executor_of_its_own(request) -> Iterator[Executor]:
    with request.param() as opened:
        yield opened


def test_once_stopped_it_makes_no_call(executor_of_its_own):
    executor_of_its_own.stop()
    with pytest.raises(ExecutorStopped):
        executor_of_its_own.call(calls.power, 2)


@pytest.mark.processes
def test_stopped_they_end_the_call_under_way(tmp_path):
    begun, end = tmp_path / "begun", tmp_path / "end"
    with LocalWorkers(JOBS) as executor:
        stopping = threading.Thread(target=_stop_once_there_is, args=(begun, executor))
        stopping.start()
        with pytest.raises(ExecutorStopped):
            executor.call(calls.mark_and_wait, begun, end)
        stopping.join()


def _stop_once_there_is(mark: Path, executor: Executor) -> None:
    while not mark.exists():
        time.sleep(0.01)
    executor.stop()
