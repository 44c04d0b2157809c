"""An engine in another language, started by a command."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import final

from spincheck.engine import Engine, EngineError, Method, Scenario

from .messages import Hello
from .process import ANSWER_LIMIT, ChildProcess, ProtocolError, given_back, taken
from .session import ChildSession


@final
class ChildEngine(Engine):
    """An engine in another language.

    Parameters
    ----------
    command : the program and its arguments
    hello : the engine's description of itself, which must be the same from each of its processes
    limit : CPU time that an answer may take, s
    sources : files that the engine's results depend on; if None, the files named in the command
    script : returns a script in JavaScript, given a scene and a method; if None, the engine has no
        scripts
    """

    interface = 1
    script_language = "JavaScript"

    def __init__(
        self,
        command: Sequence[str],
        hello: Hello,
        limit: float = ANSWER_LIMIT,
        sources: Sequence[Path] | None = None,
        script: Callable[[Scenario, Method], str] | None = None,
    ) -> None:
        self.command, self.hello, self._limit = tuple(command), hello, limit
        self.name = hello.name
        self.methods = tuple(table.method() for table in hello.methods)
        self.single_precision = hello.precision == "single"
        self.stock_timestep, self.least_turn = hello.stock_timestep, hello.least_turn
        self._sources, self._script = sources, script

    @property
    def version(self) -> str:
        """The engine's version, as its description states it."""
        return self.hello.version

    @property
    def sources(self) -> tuple[Path, ...]:
        """The files that results depend on; runs are made anew when one changes."""
        if self._sources is not None:
            return tuple(self._sources)
        return tuple(Path(word) for word in self.command if _is_file(word))

    @property
    def arguments(self) -> tuple[str, ...]:
        """The words of the command that name no files; runs are made anew when one changes."""
        return tuple(word for word in self.command if not _is_file(word))

    def open(self, scenario: Scenario, method: Method, timestep: float) -> ChildSession:
        """Open the scene in an idle process of the engine, or in a new one if none is idle.

        If a process that was used before refuses the scene, a new process is tried: earlier scenes
        may have left the old one without memory.
        """
        try:
            child = taken(self.command, self._limit)
            if child.is_used:
                with suppress(EngineError):
                    return self._session(child, scenario, method, timestep)
                child = ChildProcess(self.command, self._limit)
            return self._session(child, scenario, method, timestep)
        except ProtocolError as error:
            raise ProtocolError(f"{self.name}: {error}", error.cause) from None

    def _session(
        self, child: ChildProcess, scenario: Scenario, method: Method, timestep: float
    ) -> ChildSession:
        """Open a scene in a process; if that fails, give the process back (`given_back`)."""
        try:
            self._check(child)
            return ChildSession(child, scenario, method.name, timestep)
        except BaseException:
            given_back(child)
            raise

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """Return a script of the run in JavaScript; empty if the engine has no scripts."""
        return self._script(scenario, method) if self._script else ""

    def _check(self, child: ChildProcess) -> None:
        """Raise `ProtocolError` unless a process gives the same description as `hello`."""
        if child.hello is None:
            child.hello = child.ask(Hello, "hello")
        if child.hello != self.hello:
            words = "its engine, version or methods are not those it reported before"
            raise ProtocolError(words, "protocol")


def child_engine(command: Sequence[str], limit: float = ANSWER_LIMIT) -> ChildEngine:
    """Return the engine that a command starts; it is started and asked to describe itself.

    Parameters
    ----------
    command : the program and its arguments
    limit : CPU time that an answer may take, s

    Raises
    ------
    ProtocolError
        If the command cannot be started, or does not answer with a description.
    EngineError
        If the engine answers with an error.
    OSError
        If the system refuses to start a process.
    """
    child = taken(tuple(command), limit)
    try:
        child.hello = hello = child.ask(Hello, "hello")
    finally:
        given_back(child)
    return ChildEngine(command, hello, limit)


def _is_file(word: str) -> bool:
    """Return whether a word of a command is the path of a file; a long text is none."""
    try:
        return Path(word).is_file()
    except (OSError, ValueError):
        return False
