"""A command whose option `--ensemble` may stand without its number."""

from typing import Any

from typer.core import TyperCommand

from ..options import MEMBERS

_OPTION = "--ensemble"


class EnsembleCommand(TyperCommand):
    """Adds `MEMBERS` where no number follows the option."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments, none of which is a scene named by a number."""
        if _OPTION in args:
            after = args.index(_OPTION) + 1
            if not (after < len(args) and args[after].lstrip("-").isdigit()):
                args = [*args[:after], str(MEMBERS), *args[after:]]
        rest: list[str] = super().parse_args(ctx, args)
        return rest
