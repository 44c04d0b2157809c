"""Faults of the machine give no verdict on an engine; the same command runs it again."""

import errno
import os
import resource
from contextlib import contextmanager

import pytest
from box import BOX
from failing_calls import FailingCalls, of_function
from planted import METHOD, HeunSession, Planted, planted
from spincheck.engines import EngineError
from spincheck.engines.fault import ENVIRONMENTAL
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.costs.step_cost import step_costs
from spincheck.reports.harness.executors import CallFailed, cause_of
from spincheck.reports.harness.executors.worker_main import NO_THREAD
from spincheck.reports.harness.prepared import prepare
from spincheck.scenarios import loads
from studies import study

pytestmark = pytest.mark.slow

#: Rungs of a ladder as short as one may be.
SHORT = 1 << 7


KILLED = EngineError("it was killed from outside by SIGKILL", "killed")
FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class Spoilt(Planted):
    """Every session of it raises at one call of the run loop's."""

    name = "spoilt"

    def __init__(self, call: str, error: Exception) -> None:
        self._call, self._error = call, error

    def open(self, scenario, method, timestep):
        session = HeunSession(scenario, timestep)

        def spoilt(*_):
            raise self._error

        setattr(session, self._call, spoilt)
        return session


@pytest.mark.parametrize("call", ["read_body", "advance", "check", "active"])
@pytest.mark.parametrize("error", [KILLED, FULL], ids=["a child is killed", "a full disk"])
def test_a_run_that_the_machine_spoilt_has_no_cause_of_the_engines(path, call, error):
    choice = Choice((Spoilt(call, error),), max_steps=SHORT, timed=False)
    causes = {row.cause for row in study(path, [loads(BOX, "box")], choice).rows}
    assert causes
    assert causes <= ENVIRONMENTAL


def test_a_solver_that_was_killed_by_whatever_signal_is_tried_again(path):
    choice = Choice((planted(HeunSession),), max_steps=SHORT)
    killed = CallFailed("the worker process was killed by SIGSEGV", "crash")
    executor, scenes = FailingCalls(of_function(prepare, killed)), [loads(BOX, "box")]
    (row,) = study(path, scenes, choice, executor).rows
    assert (row.outcome, row.cause) == ("failed", "killed")
    assert "could not be found: the worker process was killed by SIGSEGV" in row.reason
    assert {row.outcome for row in study(path, scenes, choice).rows} == {"ok"}


@pytest.mark.parametrize("cause", sorted(ENVIRONMENTAL))
def test_steps_that_the_machine_did_not_let_be_timed_are_timed_by_the_next_run(path, cause):
    lines = []
    choice = Choice((planted(HeunSession),), max_steps=SHORT)

    def run(executor=None) -> list[float | None]:
        found = study(path, [loads(BOX, "box")], choice, executor, lines.append)
        return [row.seconds_per_step for row in found.rows if row.outcome == "ok"]

    refused = CallFailed("no worker process could be started", cause)
    assert set(run(FailingCalls(of_function(step_costs, refused)))) == {None}
    assert "not timed, the same command times it: no worker process could be started" in lines[-1]
    assert None not in run()


def test_a_child_killed_while_it_is_timed_is_not_one_that_cannot_be():
    with pytest.raises(EngineError) as error:
        step_costs(loads(BOX, "box"), [(Spoilt("advance", KILLED), METHOD)])
    assert cause_of(error.value) == "killed"


def chained(cause: BaseException, error: BaseException) -> BaseException:
    error.__cause__ = cause
    return error


FULL_DISK = OSError(errno.ENOSPC, "full")
NO_FILE = "libbullet.so: cannot open shared object file: "
NO_DESCRIPTORS = ImportError(NO_FILE + os.strerror(errno.EMFILE))
CAUSES = {
    "a full disk": (FULL_DISK, "environment"),
    "a full disk, told as another error": (
        chained(FULL_DISK, ValueError("cannot be saved")),
        "environment",
    ),
    "no file": (OSError(errno.ENOENT, "no such file"), "bug"),
    "a library when descriptors are out": (NO_DESCRIPTORS, "environment"),
    "a library that is not there": (ImportError(NO_FILE + os.strerror(errno.ENOENT)), "bug"),
    "no thread": (RuntimeError(NO_THREAD), "environment"),
    "another error": (RuntimeError("no such body"), "bug"),
    "memory that an engine has filled": (MemoryError(), "bug"),
}


@pytest.mark.parametrize(("error", "cause"), CAUSES.values(), ids=CAUSES)
def test_an_error_is_the_machines_or_the_calls(error, cause):
    assert cause_of(error) == cause


@contextmanager
def allowed(kind: int, size: int):
    """No more memory than that, as `ulimit` has it."""
    before = resource.getrlimit(kind)
    resource.setrlimit(kind, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(kind, before)


@pytest.mark.parametrize("kind", [resource.RLIMIT_DATA, resource.RLIMIT_AS])
def test_memory_that_somebody_else_bounds_is_the_machines(kind):
    # More than this process has, less than half of what there is of it.
    bound = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 4
    with allowed(kind, bound):
        assert cause_of(MemoryError()) == "environment"
