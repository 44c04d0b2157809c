"""Whether the end of a process, or its timeout, is the engine's fault or the machine's."""

import signal

import psutil
import pytest
from spincheck.engines import lost_process
from spincheck.engines.lost_process import IDLE, MOST_WALL, POLL, Overdue, death, wait_for_answer

#: s.
LIMIT = 10.0
#: s; in which somebody slept.
NIGHT = 600.0
#: A real-time signal, which Python has no name for.
NAMELESS = 40


class Clock:
    """Seconds on the wall."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made_up = Clock()
    monkeypatch.setattr(lost_process, "time", made_up)
    return made_up


class Process:
    """One whose clocks a test sets.

    Parameters
    ----------
    share : of the wall time that it computes
    answers_at : s on the wall
    stopped : whether somebody has stopped it
    sleeps : s, that this process is stopped itself during the first look
    """

    def __init__(
        self,
        clock: Clock,
        share: float,
        answers_at: float = float("inf"),
        *,
        stopped: bool = False,
        sleeps: float = 0.0,
    ) -> None:
        self._clock, self._share, self._answers_at = clock, share, answers_at
        self._stopped, self._sleeps = stopped, sleeps

    def has_answered(self, seconds: float) -> bool:
        self._clock.now += seconds + self._sleeps
        self._sleeps = 0.0
        return self._clock.now >= self._answers_at

    def cpu_times(self) -> tuple[float, float]:
        return self._share * self._clock.now, 0.0

    def children(self) -> list["Process"]:
        return []

    def status(self) -> str:
        return psutil.STATUS_STOPPED if self._stopped else psutil.STATUS_RUNNING


def waited(process: Process) -> Overdue | None:
    return wait_for_answer(process.has_answered, process, LIMIT)


def test_an_answer_that_comes_in_time_is_waited_for(clock: Clock) -> None:
    assert waited(Process(clock, 1.0, LIMIT / 2)) is None


def test_one_that_computes_for_longer_than_the_limit_is_given_up(clock: Clock) -> None:
    assert waited(Process(clock, 1.0)) == ("10 s of CPU time", "time-out")
    # The first reading is after one wait.
    assert LIMIT <= clock.now <= LIMIT + 3 * POLL


def test_one_that_does_nothing_hangs(clock: Clock) -> None:
    words, cause = waited(Process(clock, 0.0))
    assert (words, cause) == ("10 s: it hangs, and used 0 s of CPU time", "time-out")
    assert clock.now <= LIMIT + 2 * POLL


def test_one_that_hangs_after_it_has_computed_is_not_waited_for_longer(clock: Clock) -> None:
    process = Process(clock, 0.0)
    process.cpu_times = lambda: (min(clock.now, LIMIT / 2), 0.0)
    assert waited(process).cause == "time-out"
    assert clock.now <= 1.5 * LIMIT + 3 * POLL


def test_one_that_gets_little_of_a_busy_machine_is_waited_for(clock: Clock) -> None:
    assert waited(Process(clock, 2 * IDLE, MOST_WALL * LIMIT / 2)) is None


def test_one_that_gets_too_little_of_it_for_too_long_is_not_to_blame(clock: Clock) -> None:
    words, cause = waited(Process(clock, 2 * IDLE))
    assert cause == "environment"
    assert "s went by" in words


def test_one_that_somebody_stopped_is_not_to_blame(clock: Clock) -> None:
    """Its process group by SIGSTOP, for longer than the limit."""
    words, cause = waited(Process(clock, 0.0, stopped=True))
    assert (words, cause) == ("10 s: it was stopped from outside", "environment")


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_time_in_which_this_process_was_stopped_is_not_counted(clock: Clock, share: float) -> None:
    """Ctrl-Z, or a laptop that was closed: one look takes a night."""
    process = Process(clock, share, NIGHT + LIMIT / 2, sleeps=NIGHT)
    assert waited(process) is None


@pytest.mark.parametrize(
    ("exit_code", "words", "cause"),
    [
        (3, "ended with exit code 3", "crash"),
        (-signal.SIGSEGV, "was killed by SIGSEGV", "crash"),
        (-signal.SIGABRT, "was killed by SIGABRT", "crash"),
        *(
            (-number, f"was killed from outside by {number.name}", "killed")
            for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGXCPU, signal.SIGUSR1)
        ),
        (-NAMELESS, f"was killed from outside by signal {NAMELESS}", "killed"),
    ],
)
def test_what_ends_a_process_is_its_own_fault_or_somebody_elses(
    exit_code: int, words: str, cause: str
) -> None:
    assert death(exit_code) == (words, cause)
