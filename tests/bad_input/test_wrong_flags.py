"""Every option and argument of every command with wrong values: one message, exit code 2.

Commands, options and their types are read from the typer application itself, so that a new one is
tested at once.
"""

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from types import GenericAlias, UnionType
from typing import Any, get_args, get_type_hints

import pytest
import typer
from case_loops import each_case
from mutated_scenes import LEAST, written
from spincheck.reference import solve
from spincheck.reports.cli.app import app
from spincheck.reports.cli.grouped import option
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT, Complaint
from spincheck.scenarios import SIGNALS, loads
from typer.models import OptionInfo
from typer.testing import CliRunner

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Parameter:
    """An option or argument of a command.

    Attributes
    ----------
    flag : as it is typed; empty of an argument
    kinds : the types that its values may have
    """

    name: str
    flag: str
    kinds: frozenset[type]
    required: bool
    least: float | None


#: A bound a signal: of commands that read them from their context.
BOUNDS = [Parameter(s.name, option(s.name), frozenset({float}), False, None) for s in SIGNALS]


def parameters(callback: Any) -> tuple[Parameter, ...]:
    hints = get_type_hints(callback, include_extras=True)
    defaults = {n: p.default for n, p in inspect.signature(callback).parameters.items()}
    own = [_parameter(n, hints[n], d) for n, d in defaults.items() if hints[n] is not typer.Context]
    with_bounds = typer.Context in hints.values()
    return (*own, *(BOUNDS if with_bounds else ()))


def _parameter(name: str, hint: Any, default: object) -> Parameter:
    info = hint.__metadata__[0]
    declared = getattr(info, "param_decls", None) or (f"--{name.replace('_', '-')}",)
    flag = declared[0] if isinstance(info, OptionInfo) else ""
    required = default is inspect.Parameter.empty
    return Parameter(name, flag, frozenset(_kinds(hint)), required, info.min)


def _kinds(hint: Any) -> Iterator[type]:
    if isinstance(hint, type) and not get_args(hint):
        yield hint
    for arm in get_args(hint):
        yield from _kinds(arm) if isinstance(arm, type | UnionType | GenericAlias) else ()


COMMANDS = {
    info.name or info.callback.__name__: parameters(info.callback)
    for part in (app, *(group.typer_instance for group in app.registered_groups))
    for info in part.registered_commands
}
SCENE = loads(written(LEAST), "made")
MOTION = solve(SCENE, SCENE.times).trajectory
#: The exact motion, as a recording.
RECORDED = "t,qw,qx,qy,qz,wx,wy,wz\n" + "".join(
    ",".join(map(repr, map(float, (t, *q, *omega)))) + "\n"
    for t, q, omega in zip(MOTION.t, MOTION.q_world_body_wxyz, MOTION.omega_body, strict=True)
)
#: No option takes these, whatever it is about.
INTEGERS = ("-1", "0", "1.5", "x", "", "nan", "1e3")
NUMBERS = ("nan", "inf", "-inf", "-1", "x", "", "1e400")
NAMES = ("", "no-such-thing", "\x1b[31m", "a\nb")


def values_of(option: Parameter) -> tuple[str, ...]:
    if int in option.kinds:
        return tuple(v for v in INTEGERS if v not in ("0", "-1") or int(v) < (option.least or 0))
    if float in option.kinds:
        return NUMBERS
    return NAMES if option.name in ("engine", "method") else ()


CASES = {
    f"{command} {option.flag} {value!r}": (command, option.flag, value)
    for command, parameters in COMMANDS.items()
    for option in parameters
    if option.flag
    for value in values_of(option)
}
WITH_ARGUMENTS = [
    command for command, parameters in COMMANDS.items() if not all(p.flag for p in parameters)
]


def refusal_of(arguments: list[str]) -> tuple[int, str]:
    """The exit code and the message; any other exception than a complaint is passed on."""
    result = CliRunner().invoke(app, arguments)
    if isinstance(result.exception, Complaint):
        return result.exception.exit_code, str(result.exception)
    if not isinstance(result.exception, SystemExit | None):
        raise result.exception
    return result.exit_code, result.output


def needed(command: str) -> list[str]:
    """A value for each argument that must be there; all of them can be used."""
    of_arguments = {"files": "made.csv"}
    required = [p.name for p in COMMANDS[command] if p.required and not p.flag]
    return [of_arguments.get(name, "made.toml") for name in required]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    (tmp_path / "made.toml").write_text(written(LEAST))
    (tmp_path / "made.csv").write_text(RECORDED)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@each_case(("command", "flag", "value"), CASES)
def test_a_wrong_value_is_reported_and_nothing_is_begun(command, flag, value, folder):
    code, message = refusal_of([command, *needed(command), f"{flag}={value}"])
    assert code == BAD_INPUT, message
    assert message
    assert not list(folder.glob("*.sqlite*"))


@each_case("command", [*COMMANDS])
def test_an_option_that_there_is_not_is_reported(command):
    code, message = refusal_of([command, "--no-such-option"])
    assert code == BAD_INPUT
    assert "No such option: --no-such-option" in message


@each_case("command", [command for command in COMMANDS if needed(command)])
def test_an_argument_that_is_missing_is_reported(command):
    code, message = refusal_of([command])
    assert code == BAD_INPUT
    assert "Missing argument" in message


@each_case("value", ["nowhere.toml", "", "\x1b[31m", "a\nb", "x" * 300])
@each_case("command", WITH_ARGUMENTS)
def test_an_argument_that_names_nothing_is_reported(command, value):
    if command == "new" and value == "nowhere.toml":
        pytest.skip("it is the file that is to be made")
    code, message = refusal_of([command, *[value] * max(len(needed(command)), 1)])
    assert code == BAD_INPUT, message
    assert "\x1b" not in message


def test_without_a_wrong_value_a_recording_is_judged():
    """Teeth: else its other options would be refused for want of one."""
    assert refusal_of(["judge", *needed("judge")])[0] == AGREES


def test_a_timestep_of_more_steps_than_can_be_counted_is_reported_and_nothing_is_begun(folder):
    code, message = refusal_of(["run", "made.toml", "--timestep", "1e-300"])
    assert code == BAD_INPUT
    assert "'--timestep' must be longer" in message
    assert not list(folder.glob("*.sqlite*"))


def test_the_commands_are_found():
    """Teeth: if nothing were read from the application, nothing would be tested."""
    assert {"run", "report", "check", "recommend"} <= COMMANDS.keys()
    assert ("run", "--timestep", "nan") in CASES.values()
    assert ("recommend", "--omega", "inf") in CASES.values()
