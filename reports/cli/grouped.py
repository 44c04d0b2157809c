"""The commands in groups, as ``spincheck --help`` lists them."""

from typing import Any

from typer.core import TyperGroup

GROUPS = {
    "Run and judge": ["run", "judge", "map", "report", "view", "plot", "versions"],
    "Choose and compare": ["recommend", "compare", "reproduce"],
    "Look at results": ["rows", "verdicts", "points", "tidy"],
    "Scenes": ["list", "show", "new", "check", "reference", "export", "vary", "member"],
    "Robot models": ["inspect", "import"],
    "Engines": ["engines", "encodings", "conform"],
}
_OTHERS = "Others"


class GroupedCommands(TyperGroup):
    """Lists commands under the headings of `GROUPS`; commands in no group come last."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section a group."""
        commands = set(self.list_commands(ctx))
        grouped = {name for names in GROUPS.values() for name in names}
        for heading, names in (GROUPS | {_OTHERS: sorted(commands - grouped)}).items():
            rows = [(name, self._summary(ctx, name)) for name in names if name in commands]
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find a command; its name may be in any case."""
        return super().resolve_command(ctx, [args[0].lower(), *args[1:]])

    def _summary(self, ctx: Any, name: str) -> str:
        command = self.get_command(ctx, name)
        assert command is not None, "every command listed exists"
        text: str = command.get_short_help_str(limit=66)
        return text
