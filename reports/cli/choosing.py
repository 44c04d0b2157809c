"""Determines which engines, methods, timesteps and executor a command uses, from its options."""

import re
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from pkgutil import resolve_name
from tempfile import gettempdir

from ...engines import Engine, NameTaken, add, engines, missing
from ...engines.interface import misfit
from ...scenarios import Scenario, did_you_mean
from ..harness.choice import Choice
from ..harness.executors import Executor, LocalWorkers
from ..harness.timesteps.ladder import MOST_STEPS
from .stopping import Stopped
from .terminal import BAD_INPUT, NOT_RUN, Complaint, as_complaint, say


@contextmanager
def executor_for(jobs: int, choice: Choice) -> Iterator[Executor]:
    """Yield an executor with worker processes, which end with the `with` block.

    A `Complaint` is raised if there is no temporary folder.

    Parameters
    ----------
    jobs : number of worker processes
    choice : what the workers will run; its time limit holds for each run
    """
    check_temporary_folder()
    with LocalWorkers(jobs, choice.time_limit) as executor:
        yield executor


def say_if_compiling() -> None:
    """Print that the solver of exact motions is about to be compiled, if it is not yet compiled."""
    from ...reference.compiled import is_compiled
    from ..harness.executors.compiling import notice

    if not is_compiled():
        say(notice())


def compile_first() -> None:
    """Compile the solver of exact motions if necessary, after a message that says so.

    Commands that solve motions in this process call it first.
    """
    from ..harness.executors import compiling

    compiling.compile_first(say)


def check_temporary_folder() -> None:
    """Raise a `Complaint` if there is no temporary folder, which engines need for their files."""
    try:
        gettempdir()
    except FileNotFoundError as error:
        raise Complaint(f"{error.strerror}; 'TMPDIR' names another", NOT_RUN) from None


#: Prefix that marks the value of '--engine' as the command that starts an engine in a process of
#: its own: docs/reference/engine-protocol.md.
CHILD = "child:"
#: Pattern of MODULE:NAME, which names a class or an object in a Python module.
_OBJECT = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_][\w.]*")
#: Name for every engine that is installed, optional ones too.
ALL = "all"
#: Largest time limit, s. It is below 2³¹ ms, the longest that operating systems can wait at once.
MOST_TIME = 1e6


def choose(
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    *,
    scenarios: Sequence[Scenario] = (),
    python: str = "",
    time_limit: float | None = None,
) -> Choice:
    """Return the choice of the engines, methods and timesteps that a user named.

    An engine that the user gives as a version, a class or a command is added to the list of
    engines.

    Parameters
    ----------
    engine_names : names as typed; if empty, all engines are chosen that can load the body of any of
        the scenes, except optional ones
    methods : names in upper or lower case; if empty, the choice stands for all methods that the
        engines offer for a scene
    timesteps : s; if empty, the command decides on timesteps
    scenarios : scenes to be run; engines that load users' model files are left out if no scene
        names such a file
    python : the command of the interpreter that other versions of engines run under; the
        interpreter of this process if empty
    time_limit : CPU time that a run may take, s; the default if None

    Raises
    ------
    Complaint
        If there is no engine or method of some name, if an engine cannot be used or none is
        installed, or if a number is out of range.
    """
    if time_limit is not None and not 0 < time_limit <= MOST_TIME:
        raise Complaint(
            f"'--time-limit' must be positive and at most {MOST_TIME:g} s, got {time_limit:g} s"
        )
    names = dict.fromkeys(engine_names)
    if python and not any("@" in name for name in names):
        raise Complaint("'--python' is for versions, such as '--engine mujoco@3.1.6'")
    chosen = [engine for name in names for engine in _engines(name, python, time_limit, scenarios)]
    if not names:
        for absent in missing():
            if not (absent.package or absent.family):
                say(f"{absent.name} cannot be used: {absent.reason}.")
        chosen = [one for one in _applying(scenarios) if not one.is_optional]
    if not chosen:
        raise Complaint("no engine is installed; 'pip install mujoco pybullet'", NOT_RUN)
    by_lower = {method.name.lower(): method.name for engine in chosen for method in engine.methods}
    for name in methods:
        if name.lower() not in by_lower:
            raise Complaint(
                f"'--method' must be one of {', '.join(sorted(by_lower.values()))}, got '{name}'"
                f"{did_you_mean(name, by_lower.values())}"
            )
    methods = [by_lower[name.lower()] for name in methods]
    for timestep in timesteps:
        if not 0 < timestep < float("inf"):
            raise Complaint(f"'--timestep' must be positive, got {timestep:g} s")
    engines_once = tuple({engine.name: engine for engine in chosen}.values())
    return Choice(engines_once, tuple(methods), tuple(timesteps), time_limit=time_limit)


def _applying(scenarios: Sequence[Scenario]) -> list[Engine]:
    """Return the installed engines that can load the body of any of the scenes.

    An engine that loads users' model files is returned if a scene names such a file; any other if a
    scene gives the numbers of its body. If there are no scenes, all engines but those that load
    model files are returned.
    """
    return [
        engine
        for engine in engines().values()
        if any(map(engine.applies_to, scenarios)) or not (scenarios or engine.of_file)
    ]


def _engines(
    name: str, python: str, time_limit: float | None, scenarios: Sequence[Scenario]
) -> Sequence[Engine]:
    """Return the engines that a value of '--engine' names: several for 'all' or a family, else one.

    'all' means all engines that can load the body of any of the scenes. A family is a name that
    several adapters share, such as 'node', and means those of these engines that have it. Case
    matters only in 'MODULE:CLASS', 'child:COMMAND' and 'ENGINE@VERSION'.

    Parameters
    ----------
    name : the value
    python : the command of the interpreter that another version of an engine runs under; the
        interpreter of this process if empty
    time_limit : CPU time that an engine started by a command may take to answer, s; at most
        `ANSWER_LIMIT`, which is also the default if None

    Raises
    ------
    Complaint
        If the value names no engine, or one that cannot be used.
    """
    if name.startswith(CHILD):
        return [_child(name.removeprefix(CHILD), time_limit)]
    if _OBJECT.fullmatch(name):
        return [_of_module(name)]
    if "@" in name and name not in engines():
        return [_at_version(name, python)]
    lower = name.lower()
    families = {one.family for one in engines().values()} | {one.family for one in missing()}
    families.discard("")
    if lower == ALL or lower in families:
        several = [one for one in _applying(scenarios) if lower in (ALL, one.family)]
        if several:
            return several
    for engine in engines().values():
        if engine.name.lower() == lower:
            return [engine]
    for absent in missing():
        if lower and lower in (absent.name.lower(), absent.family):
            raise Complaint(f"engine '{name}' cannot be used: {absent.reason}", NOT_RUN)
    known = [*engines(), *sorted(families), ALL]
    raise Complaint(
        f"'--engine' must be one of {', '.join(known)}, or of your own MODULE:CLASS, got '{name}'"
        f"{did_you_mean(lower, known)}"
    )


def _at_version(name: str, python: str) -> Engine:
    """Return the engine of a name such as mujoco@3.1.6, and add it to the list of engines.

    A `Complaint` is raised if that version cannot be installed.

    Parameters
    ----------
    python : the command of the interpreter that this version runs under; the interpreter of this
        process if empty
    """
    from ...engines.versions import VersionError, versioned

    try:
        engine = versioned(name, python, say)
    except VersionError as error:
        raise Complaint(str(error), BAD_INPUT if error.is_usage else NOT_RUN) from None
    add(engine)
    return engine


def _child(command: str, time_limit: float | None) -> Engine:
    """Return the engine that a command starts, and add it to the list of engines.

    The list has it under the name that the program reports. If the list has an engine of the same
    command already, that one is returned. A `Complaint` is raised if the command starts no engine.

    Parameters
    ----------
    time_limit : CPU time that the program may take to answer, s; at most `ANSWER_LIMIT`, which is
        also the default if None
    """
    from ...engines import EngineError
    from ...engines.child import ANSWER_LIMIT, ChildEngine, child_engine

    before = f"'--engine' {CHILD}{command}: "
    try:
        words = words_of(command)
        for known in engines().values():
            if isinstance(known, ChildEngine) and known.command == tuple(words):
                return known
        engine = child_engine(words, min(time_limit or ANSWER_LIMIT, ANSWER_LIMIT))
        add(engine)
        return engine
    except ValueError as error:
        raise Complaint(f"{before}{error}") from None
    except EngineError as error:
        # A program that breaks the protocol counts as bad input, like a wrong adapter in Python.
        code = BAD_INPUT if error.cause == "protocol" else NOT_RUN
        raise Complaint(f"{before}{error}", code) from None


def _of_module(name: str) -> Engine:
    """Return the engine that MODULE:NAME names, and add it to the list of engines.

    NAME is a subclass of `Engine` or an object of one. The module may be in the current folder.
    That folder is put at the end of `sys.path`, so that its modules hide no others.

    Raises
    ------
    Complaint
        If nothing has this name or it is no engine, if the engine is written for another version of
        the interface or declares something wrong, or if another engine has the same name.
    """
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.append(here)
    before = f"'--engine' {name}: "
    try:
        found = resolve_name(name)
        engine = found() if isinstance(found, type) else found
    except (KeyboardInterrupt, Stopped):
        raise
    # An engine's package may raise anything when it is imported: a panic of Rust's code is no
    # `Exception`.
    except BaseException as error:
        raise Complaint(f"{before}{type(error).__name__}: {error}") from None
    if not isinstance(engine, Engine):
        raise Complaint(
            f"'--engine' {name} must be a subclass of spincheck.engine.Engine, or an object of "
            f"one, got {found!r}"
        )
    from ...engines.declared import misdeclared

    if reason := misfit("interface", getattr(engine, "interface", None)) or misdeclared(engine):
        raise Complaint(f"{before}{reason}")
    with as_complaint(NameTaken, before=before):
        add(engine)
    return engine


def words_of(command: str) -> list[str]:
    """Return the words of a command, split by the quoting rules of a shell.

    Raises
    ------
    ValueError
        If a quotation does not end, or there is no word.
    """
    if not (words := shlex.split(command)):
        raise ValueError("must be a command, got nothing")
    return words


def check_timesteps(scenarios: Sequence[Scenario], choice: Choice) -> None:
    """Raise a `Complaint` if a timestep is longer than a scene's window, or far too short.

    It is too short if a run would take `MOST_STEPS` steps or more.
    """
    for scenario in scenarios:
        for timestep in choice.timesteps:
            if timestep > scenario.window.duration:
                raise Complaint(
                    f"'--timestep' must be shorter than the window of {scenario.name}, "
                    f"{scenario.window.duration:g} s, got {timestep:g} s"
                )
            if not scenario.window.duration / timestep < MOST_STEPS:
                raise Complaint(
                    f"'--timestep' must be longer: on {scenario.name} {timestep:g} s make more "
                    f"than {MOST_STEPS:.1e} steps"
                )
