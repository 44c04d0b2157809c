"""The program's Python sources, each read and parsed once a process."""

import ast
from collections.abc import Callable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("scenarios", "reference", "engines", "reports")


@cache
def trees() -> dict[str, ast.Module]:
    """Parsed, by their paths from the root."""
    return {
        path.relative_to(ROOT).as_posix(): ast.parse(path.read_text(encoding="utf-8"))
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }


def files_with(is_one: Callable[[ast.AST], bool]) -> set[str]:
    """The files in which there is such a node."""
    return {name for name, tree in trees().items() if any(map(is_one, ast.walk(tree)))}
