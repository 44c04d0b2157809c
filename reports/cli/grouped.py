"""Classes of typer commands and groups, for what typer itself does not offer.

They list commands in groups, give a command an option for each signal, and let the number behind
an option be left out.
"""

import math
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from .options import MEMBERS

if TYPE_CHECKING:
    from ...scenarios import Signal

GROUPS = {
    "Run and judge": ["run", "judge", "report"],
    "Choose and compare": ["recommend", "compare", "reproduce"],
    "Look at results": ["rows"],
    "Scenes": ["list", "show", "new", "check", "reference", "export"],
    "Robot models": ["inspect", "import"],
    "Engines": ["engines", "gradients"],
}
_OTHERS = "Others"


class GroupedCommands(TyperGroup):
    """The group of all commands; its help lists them by `GROUPS`, and others at the end."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section of the help, with typer's `formatter`, for each group of commands."""
        commands = set(self.list_commands(ctx))
        grouped = {name for names in GROUPS.values() for name in names}
        for heading, names in (GROUPS | {_OTHERS: sorted(commands - grouped)}).items():
            rows = [(name, self._summary(ctx, name)) for name in names if name in commands]
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by its name, None if there is none; its help shows no Python types."""
        command = super().get_command(ctx, cmd_name)
        for one in command.params if command else ():
            if one.param_type_name == "argument":
                one.__dict__["display_type_rich"] = lambda **_: ""
            elif not getattr(one, "is_flag", False):
                one.metavar = one.metavar or one.name.upper()
        return command

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return a command's name, the command, and its arguments, given the name in any case."""
        return super().resolve_command(ctx, [args[0].lower(), *args[1:]])

    def _summary(self, ctx: Any, name: str) -> str:
        """Return the short help of a command, by its name."""
        command = self.get_command(ctx, name)
        assert command is not None, "every command listed exists"
        text: str = command.get_short_help_str(limit=66)
        return text


_ENSEMBLE = "--ensemble"
#: Factor to rad, by the unit that follows an angle.
ANGLES = {"deg": math.pi / 180, "°": math.pi / 180, "rad": 1.0}


class EnsembleCommand(TyperCommand):
    """A command with the option `--ensemble`, whose number is `MEMBERS` if left out."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments after adding `MEMBERS` behind an `--ensemble` without a number.

        A number behind the option is always taken for the number of members, never for a scene.
        """
        if _ENSEMBLE in args:
            after = args.index(_ENSEMBLE) + 1
            if not (after < len(args) and args[after].lstrip("-").isdigit()):
                args = [*args[:after], str(MEMBERS), *args[after:]]
        rest: list[str] = super().parse_args(ctx, args)
        return rest


class ErrorBoundsCommand(TyperCommand):
    """A command with one option for each signal: the bound on the error in that signal.

    The function `error_bounds` returns the bounds that a user gave.
    """

    def get_params(self, ctx: Any) -> Any:
        """Return the command's parameters, with options for signals' bounds in second place."""
        first, *others = super().get_params(ctx)
        return [first, *_bounds(), *others]


def error_bounds(context: typer.Context) -> dict[str, float]:
    """Return the error bounds that a user gave, by signal: attitude in rad, others relative."""
    from ...scenarios import SIGNAL

    bounds = {name: context.meta.get(f"{__name__}.{name}") for name in SIGNAL}
    return {name: bound for name, bound in bounds.items() if bound is not None}


def option(signal: str) -> str:
    """Return the name of the option for a signal's error bound, such as "--omega"."""
    return f"--{signal.replace('_', '-')}"


def _bounds() -> list[Any]:
    """Return typer's parameters for the options of the error bounds, one for each signal."""
    # Imported only here: the help of every other command would wait for it.
    from ...scenarios import SIGNALS

    def command(**_: float | None) -> None: ...

    parameters = [
        Parameter(signal.name, Parameter.KEYWORD_ONLY, default=None, annotation=_bound(signal))
        for signal in SIGNALS
    ]
    command.__dict__["__signature__"] = Signature(parameters)
    command.__annotations__ = {one.name: one.annotation for one in parameters}
    app = typer.Typer(add_completion=False)
    app.command()(command)
    return list(get_command(app).params)


def _bound(signal: "Signal") -> Any:
    """Return the type annotation from which typer makes the option of a signal's bound."""
    return Annotated[
        float | None,
        typer.Option(
            option(signal.name),
            parser=angle if signal.unit else number,
            metavar="RAD|…deg" if signal.unit else "E",
            help=f"Largest error allowed in {signal}.",
            callback=_keep,
            expose_value=False,
        ),
    ]


def number(text: str) -> float:
    """Return the number in the text of an option; raise `typer.BadParameter` if there is none."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"must be a number, such as 1e-3, got '{text}'") from None


def angle(text: str) -> float:
    """Return, in rad, an angle that is given as text, such as "0.1deg", "0.1°" or "1e-3".

    A number without a unit is in rad. `typer.BadParameter` is raised if the text is no angle.
    """
    unit = next((unit for unit in ANGLES if text.endswith(unit)), "rad")
    try:
        return float(text.removesuffix(unit)) * ANGLES[unit]
    except ValueError:
        raise typer.BadParameter(f"must be such as 1e-3 (rad) or 0.1deg, got '{text}'") from None


def _keep(
    context: typer.Context, parameter: typer.CallbackParam, bound: float | None
) -> float | None:
    """Store the value of a bound's option for `error_bounds`, and return it; None if not given."""
    context.meta[f"{__name__}.{parameter.name}"] = bound
    return bound
