"""Which engines, methods and timesteps a command is to use, from what was typed."""

import shlex
from collections.abc import Sequence
from dataclasses import replace

from ...engines import Engine, add, engines, missing
from ...scenarios import Scenario, did_you_mean
from ..harness.choice import Choice
from .terminal import BAD_INPUT, NOT_RUN, Complaint

#: Begins the name of an engine that is a command: docs/engine-protocol.md.
CHILD = "child:"
#: s; a system's clocks wait for no more than 2³¹ ms at once.
MOST_TIME = 1e6


def choose(
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    python: str = "",
) -> Choice:
    """The engines, methods and timesteps that were asked for.

    Parameters
    ----------
    python : the command of the interpreter that versions run under; this one if empty

    Raises
    ------
    Complaint
        If there is no such engine, method or timestep.
    """
    generated = [name for name, engine in engines().items() if not engine.of_file]
    names = dict.fromkeys(engine_names or generated)
    if python and not any("@" in name for name in names):
        raise Complaint("'--python' is for versions, such as '--engine mujoco@3.1.6'", BAD_INPUT)
    chosen = tuple(_engine(name, python) for name in names)
    if not chosen:
        raise Complaint("no engine is installed; 'pip install mujoco pybullet'", NOT_RUN)
    by_lower = {method.name.lower(): method.name for engine in chosen for method in engine.methods}
    for name in methods:
        if name.lower() not in by_lower:
            raise Complaint(
                f"'--method' must be one of {', '.join(sorted(by_lower.values()))}, got '{name}'"
                f"{did_you_mean(name, by_lower.values())}",
                BAD_INPUT,
            )
    methods = [by_lower[name.lower()] for name in methods]
    for timestep in timesteps:
        if not 0 < timestep < float("inf"):
            raise Complaint(f"'--timestep' must be positive, got {timestep:g} s", BAD_INPUT)
    return Choice(chosen, tuple(methods), tuple(timesteps))


def limited(choice: Choice, time_limit: float | None) -> Choice:
    """The choice with a time limit, s, if one was given.

    Raises
    ------
    Complaint
        If it is not positive, or longer than the system's clocks can wait.
    """
    if time_limit is not None and not 0 < time_limit <= MOST_TIME:
        raise Complaint(
            f"'--time-limit' must be positive and at most {MOST_TIME:g} s, got {time_limit:g} s",
            BAD_INPUT,
        )
    return replace(choice, time_limit=time_limit)


def _engine(name: str, python: str) -> Engine:
    if name.startswith(CHILD):
        return _child(name.removeprefix(CHILD))
    if name in engines():
        return engines()[name]
    if "@" in name:
        return _at_version(name, python)
    for absent in missing():
        if absent.name == name:
            raise Complaint(
                f"engine '{name}' cannot be used: {absent.reason}",
                NOT_RUN,
            )
    raise Complaint(
        f"'--engine' must be one of {', '.join(engines())}, got '{name}'"
        f"{did_you_mean(name, engines())}",
        BAD_INPUT,
    )


def _at_version(name: str, python: str) -> Engine:
    """The engine of a name such as mujoco@3.1.6; from now on in the list of engines."""
    from ...engines.versions import VersionError, versioned

    try:
        engine = versioned(name, python)
    except VersionError as error:
        raise Complaint(f"'--engine' {error}", NOT_RUN) from None
    add(engine)
    return engine


def _child(command: str) -> Engine:
    """The engine that a command starts; from now on in the list of engines, under its own name."""
    from ...engines.child import ProtocolError, child_engine

    try:
        engine = child_engine(words_of(command))
        add(engine)
    except ProtocolError as error:
        raise Complaint(f"'--engine' {CHILD}{command}: {error}", NOT_RUN) from None
    except ValueError as error:
        raise Complaint(f"'--engine' {CHILD}{command}: {error}", BAD_INPUT) from None
    return engine


def words_of(command: str) -> list[str]:
    """A command's words, quoted as in a shell.

    Raises
    ------
    ValueError
        If a quotation does not end, or there is no word.
    """
    if not (words := shlex.split(command)):
        raise ValueError("must be a command, got nothing")
    return words


def check_timesteps(scenarios: Sequence[Scenario], choice: Choice) -> None:
    """See that every scene's window is longer than the timesteps asked for.

    Raises
    ------
    Complaint
        If one is not.
    """
    for scenario in scenarios:
        for timestep in choice.timesteps:
            if timestep > scenario.window.duration:
                raise Complaint(
                    f"'--timestep' must be shorter than the window of {scenario.name}, "
                    f"{scenario.window.duration:g} s, got {timestep:g} s",
                    BAD_INPUT,
                )
