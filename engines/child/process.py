"""A child process: it reads calls, a line each, from standard input, and answers in another pipe.

So output that the engine prints does not interfere: standard output and error are read from a pipe
of their own, and the end of what was printed is quoted if the process dies.
"""

import atexit
import errno
import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, TypeVar

import psutil
from spincheck.engine import EngineError

from ...scenarios import printable
from ..lost_process import death, last_line, wait_for_answer
from ..start_process import kill, start
from .messages import ChildAnswer, Hello, Misanswer, Refusal, parse

#: Name of the environment variable with the descriptor that a child writes its answers to.
ANSWERS = "SPINCHECK_ANSWERS"
#: CPU time that an answer may take, s; a few thousand steps take a fraction of a second.
ANSWER_LIMIT = 60.0
#: Time that a child may take to end after its standard input is closed, s.
END_LIMIT = 1.0
#: Largest number of bytes of an answer; regular answers have a few thousand.
LONGEST_ANSWER = 1 << 20
#: Largest number of bytes read at once: as many as a pipe holds (pipe(7), Linux).
PIPE_SIZE = 1 << 16
#: Number of bytes that are kept of a child's output: the last ones.
KEPT_OUTPUT = 4096

#: Errors of the system that say that a command does not exist or cannot be run.
NOT_A_PROGRAM = frozenset(
    {
        errno.ENOENT,
        errno.EACCES,
        errno.EPERM,
        errno.ENOEXEC,
        errno.ENOTDIR,
        errno.ELOOP,
        errno.ENAMETOOLONG,
    }
)

A = TypeVar("A", bound=ChildAnswer)


class ProtocolError(EngineError):
    """The child died, does not answer, or breaks the protocol: it is not called again."""


class ChildProcess:
    """A running process of an engine, which is sent calls and answers them.

    Parameters
    ----------
    command : the program and its arguments
    limit : CPU time that an answer may take, s

    Attributes
    ----------
    hello : the engine's description of itself; None until the process has been asked for it
    is_used : whether the process has been given back (`given_back`) after an earlier use

    Raises
    ------
    ProtocolError
        If the command cannot be run.
    OSError
        If the system refuses to start a process.
    """

    def __init__(self, command: Sequence[str], limit: float) -> None:
        self.command = command
        self.hello: Hello | None = None
        self.is_used = self._has_refused = False
        self._limit = limit
        self._number = 0
        self._received = b""
        self._printed = b""
        self._broken: ProtocolError | None = None
        if sys.platform == "win32":
            words = f"'{printable(command[0], 100)}' needs a pipe that Windows cannot hand on"
            raise ProtocolError(words, "refused")
        self._answers, theirs = os.pipe()
        try:
            self._process = start(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                bufsize=0,
                pass_fds=(theirs,),
                env=os.environ | {ANSWERS: str(theirs)},
            )
        except OSError as error:
            os.close(self._answers)
            if error.errno not in NOT_A_PROGRAM:
                raise
            words = f"'{printable(command[0], 100)}' cannot be started: {error.strerror}"
            raise ProtocolError(words, "refused") from None
        finally:
            os.close(theirs)
        assert self._process.stdin is not None, "it is a pipe"
        assert self._process.stdout is not None, "it is a pipe"
        self._of_system = psutil.Process(self._process.pid)
        self._request = ""
        self._calls, self._output = self._process.stdin, self._process.stdout
        self._streams = selectors.DefaultSelector()
        self._streams.register(self._answers, selectors.EVENT_READ)
        self._streams.register(self._output.fileno(), selectors.EVENT_READ)

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    @property
    def usable(self) -> bool:
        """Whether the child may be called again: no call has raised `ProtocolError` yet."""
        return self._broken is None

    @property
    def can_open(self) -> bool:
        """Whether the child may be given another scene.

        This is false after an answer with an error: the engine may be out of memory, or broken.
        """
        return self.usable and not self._has_refused

    def ask(self, expected: type[A], do: str, /, **arguments: Any) -> A:
        """Send a call to the child, and return its answer.

        Parameters
        ----------
        expected : class of the answer to this call
        do : name of the call
        arguments : the call's further keys

        Raises
        ------
        EngineError
            If the child answers with an error; the message is the child's.
        ProtocolError
            If the answer breaks the protocol, none comes in time, or the child has died. The child
            is then killed, and all further calls raise the same error.
        """
        if self._broken is not None:
            raise self._broken
        try:
            return self._ask(expected, do, arguments)
        except ProtocolError as error:
            self._broken = error
            self.end()
            raise

    def _ask(self, expected: type[A], do: str, arguments: dict[str, Any]) -> A:
        """Send the call `do` to the child, and return its answer, of the class `expected`.

        `arguments` has the call's further keys. The errors are those of `ask`, but a child that
        breaks the protocol is not ended here.
        """
        self._number += 1
        call = json.dumps({"id": self._number, "do": do} | arguments, allow_nan=False)
        if self._received:
            raise ProtocolError(f"it sent a line unasked, before '{do}'", "protocol")
        with suppress(BrokenPipeError):  # the child has died; the message below says how
            self._calls.write(call.encode() + b"\n")
        line = self._line(do)
        try:
            answer = parse(line, self._number, expected)
        except Misanswer as error:
            raise ProtocolError(f"its answer to '{do}' {error}", "protocol") from None
        if isinstance(answer, Refusal):
            self._has_refused = True
            raise EngineError(printable(" ".join(answer.error.split())))
        return answer

    def _line(self, do: str) -> bytes:
        """Return the next line of the answers' pipe; `do` is the name of the call.

        Output that the child prints meanwhile is read and kept, so that printing never blocks it.
        `ProtocolError` is raised if no line comes in time, or the child has died.
        """
        self._request = do
        if overdue := wait_for_answer(self._has_answered, self._of_system, self._limit):
            words = f"it did not answer '{do}' within {overdue.words}{self._last_printed()}"
            raise ProtocolError(words, overdue.cause)
        line, _, self._received = self._received.partition(b"\n")
        return line

    def _has_answered(self, seconds: float) -> bool:
        """Wait at most some seconds for an answer; return whether a whole line has arrived.

        Output that the child prints meanwhile is read and kept.

        Raises
        ------
        ProtocolError
            If the child has died, or the line is too long.
        """
        until = time.monotonic() + seconds
        while b"\n" not in self._received:
            left = until - time.monotonic()
            if left < 0:
                # The pipe of a dead child may still be open in a process that the child started.
                if self._process.poll() is not None and not self._streams.select(0):
                    raise self._ended(self._request)
                return False
            for key, _ in self._streams.select(left):
                self._take(key.fd, self._request)
        return True

    def is_running(self) -> bool:
        """Return whether the child still runs; an idle one may have been killed from outside."""
        return self._process.poll() is None

    def _take(self, descriptor: int, do: str) -> None:
        """Read from the pipe with a given descriptor: either that of answers or that of output.

        `ProtocolError` is raised at the end of the answers' pipe, or if an answer is too long; `do`
        is the name of the call.
        """
        part = os.read(descriptor, PIPE_SIZE)
        if descriptor != self._answers:
            self._printed = (self._printed + part)[-KEPT_OUTPUT:]
            if not part:
                self._streams.unregister(descriptor)
            return
        if not part:
            raise self._ended(do)
        self._received += part
        if len(self._received) > LONGEST_ANSWER:
            raise ProtocolError(
                f"its answer to '{do}' is longer than {LONGEST_ANSWER} bytes", "protocol"
            )

    def _ended(self, do: str) -> ProtocolError:
        """Return the error that says how the child ended before it answered the call `do`."""
        self._calls.close()
        try:
            code = self._process.wait(END_LIMIT)
        except subprocess.TimeoutExpired:
            return ProtocolError(f"it closed its pipe instead of answering '{do}'", "protocol")
        with suppress(OSError):
            os.set_blocking(self._output.fileno(), False)
            self._printed += os.read(self._output.fileno(), PIPE_SIZE)
        how, cause = death(code)
        return ProtocolError(f"it {how} instead of answering '{do}'{self._last_printed()}", cause)

    def _last_printed(self) -> str:
        """Return words that quote the last line that the child printed; empty if there is none."""
        printed = self._printed.decode(errors="replace").strip()
        # The child may have printed its answer instead of writing it to the answers' pipe.
        is_answer = printed.rpartition("\n")[2].startswith("{")
        where = f" (answers go to the descriptor in {ANSWERS})" if is_answer else ""
        return f"{last_line(printed)}{where}"

    def end(self) -> None:
        """Close the child's input, and kill the child if it does not end within `END_LIMIT`.

        A child that broke the protocol is killed at once.
        """
        if self._streams.get_map() is None:
            return
        self._streams.close()
        self._calls.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(END_LIMIT if self.usable else 0)
        kill(self._process)
        self._output.close()
        os.close(self._answers)


_idle: dict[tuple[str, ...], list[ChildProcess]] = {}


def taken(command: tuple[str, ...], limit: float) -> ChildProcess:
    """Return a process of a command: an idle one that still runs, or else a new one.

    Parameters
    ----------
    command : the program and its arguments
    limit : CPU time that an answer of a new process may take, s; an idle one keeps its own limit

    Raises
    ------
    ProtocolError
        If the command cannot be run.
    OSError
        If the system refuses to start a process.
    """
    idle = _idle.get(command, [])
    while idle:
        child = idle.pop()
        if child.is_running():
            return child
        child.end()
    return ChildProcess(command, limit)


def given_back(child: ChildProcess) -> None:
    """Keep a child for the next scene, or end it if it may not be given another one."""
    child.is_used = True
    if not child.can_open:
        child.end()
    else:
        _idle.setdefault(tuple(child.command), []).append(child)


@atexit.register
def end_idle() -> None:
    """End all idle children."""
    for children in _idle.values():
        while children:
            children.pop().end()
