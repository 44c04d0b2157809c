"""A command with an option a signal: the largest error allowed in it."""

import math
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand
from typer.main import get_command

if TYPE_CHECKING:
    from ....scenarios import Signal


class ErrorBoundsCommand(TyperCommand):
    """Adds an option a signal; `error_bounds` has the bounds that were given."""

    def get_params(self, ctx: Any) -> Any:
        """The command's own arguments and options, with the bounds after the first of them."""
        first, *others = super().get_params(ctx)
        return [first, *_bounds(), *others]


def error_bounds(context: typer.Context) -> dict[str, float]:
    """The bounds that were given, by signal."""
    from ....scenarios import SIGNAL

    bounds = {name: context.meta.get(f"{__name__}.{name}") for name in SIGNAL}
    return {name: bound for name, bound in bounds.items() if bound is not None}


def option(signal: str) -> str:
    """The option of a signal's bound."""
    return f"--{signal.replace('_', '-')}"


def _bounds() -> list[Any]:
    # Only here: every other command's help would wait for it.
    from ....scenarios import SIGNALS

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
    """The annotation of a bound."""
    return Annotated[
        float | None,
        typer.Option(
            option(signal.name),
            parser=_angle if signal.unit else float,
            metavar="RAD|…deg" if signal.unit else "E",
            help=f"Largest error allowed in {signal}.",
            callback=_keep,
            expose_value=False,
        ),
    ]


def _angle(text: str) -> float:
    """An angle, rad, of a number; of one that ends in "deg", its degrees in rad."""
    number = text.removesuffix("deg")
    return float(number) if number == text else math.radians(float(number))


def _keep(
    context: typer.Context, parameter: typer.CallbackParam, bound: float | None
) -> float | None:
    context.meta[f"{__name__}.{parameter.name}"] = bound
    return bound
