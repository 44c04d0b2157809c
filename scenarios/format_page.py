"""The page that specifies the scenario file, key by key, written from the format's own models."""

import types
import typing
from collections.abc import Iterator
from typing import Any

from pydantic.fields import FieldInfo

from .document import (
    BodyTable,
    Document,
    Expect,
    Known,
    Published,
    Window,
)
from .effects import EFFECTS, Effects
from .start import StartTable
from .values import Table

#: Every table of the file in the order in which it is written, with an example. Together they make
#: a valid scene, except `[effects.table]`, which excludes the pivot.
EXAMPLES: dict[str, tuple[type[Table], str]] = {
    "The top of the file": (
        Document,
        """spincheck = 1
title = "A top that drags its heels"
source = "Goldstein, Classical Mechanics, §5.7"
description = "Leans by 30° and loses its spin."
tags = ["heavy", "driven"]
""",
    ),
    "[body]": (
        BodyTable,
        """[body]
mass = 0.5                        # kg
inertia = [8e-4, 8e-4, 4e-4]      # kg m²
com = [0.0, 0.0, 0.05]            # m, from the pivot
""",
    ),
    "[start]": (
        StartTable,
        """[start]
euler_zyz_deg = [0.0, 30.0, 0.0]
euler_zyz_rates = [2.0, 0.0, 80.0]  # rad/s: precession, nutation, spin
""",
    ),
    "[effects]": (Effects, ""),
    **{
        effect.heading: (effect.model, f"{effect.heading}\n{effect.model.EXAMPLE}")
        for effect in EFFECTS.values()
    },
    "[window]": (
        Window,
        """[window]
duration = 2.0                    # s
samples = 201
""",
    ),
    "[[published]]": (
        Published,
        """[[published]]
t = 0.0
energy = 4.5064                   # J
tolerance = 1e-4
source = "worked out by hand"
""",
    ),
    "[[expect]]": (
        Expect,
        """[[expect]]
engine = "mujoco"
method = "RK4"
timestep = 0.001                  # s
omega = 1e-6
attitude = 1e-5                   # rad
""",
    ),
    "[[known]]": (
        Known,
        """[[known]]
engine = "mujoco"
method = "discrete"
verdict = "disagrees"
reason = "creeps on where a body has all but stopped"
""",
    ),
}

_HEAD = """<!-- `make format-page` writes this from scenarios/document.py. -->
# The scene file, key by key

A scene is one TOML file in SI units. Its name is the file's name without `.toml`. Nothing physical
has a hidden default: a key that is not needed and is left out means that there is no such thing.
Unknown keys are errors; `spincheck check FILE` names file, line, key and rule of whatever is wrong.
`scenarios/schema.json` gives completion in editors.
[Your own top in five minutes](../start/first-scene.md) shows one being written.

ZYZ Euler angles are α, β, γ with R = Rz(α) Ry(β) Rz(γ); R times body components is world
components. L is about the pivot, or about the centre of mass where there is none; potential energy
is −m g·r_com.
"""


def format_page() -> str:
    """Return the page that specifies the scenario file, as Markdown."""
    return "\n".join([_HEAD, *(line for title in EXAMPLES for line in _section(title))])


def _section(title: str) -> Iterator[str]:
    """Yield the lines of the section on one table: meaning, keys and an example.

    Parameters
    ----------
    title : the section's title, a key of `EXAMPLES`
    """
    model, example = EXAMPLES[title]
    yield f"## {title}\n"
    yield f"{model.__doc__}\n"
    fields = model.model_fields
    if fields:
        yield "| key | value | needed | meaning |\n|---|---|---|---|"
        for key, field in fields.items():
            needed = "yes" if field.is_required() else ""
            yield f"| `{key}` | {_kind(field)} | {needed} | {field.description} |"
        yield ""
    if example:
        yield f"```toml\n{example}```\n"


def _kind(field: FieldInfo) -> str:
    """Return, in words, which values a key of a table takes: their type and their bounds."""
    limits = [
        f" {sign} {limit}"
        for name, sign in (("gt", ">"), ("ge", "≥"), ("le", "≤"))
        for one in field.metadata
        if (limit := getattr(one, name, None)) is not None
    ]
    return _words(field.annotation) + " and".join(limits)


def _words(annotation: Any) -> str:
    """Return, in words, which values a type allows."""
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        words = _words(arguments[0])
        positive = any("gt=0" in repr(one) for one in arguments[1:])
        return "number > 0" if words == "number" and positive else words
    if origin in (typing.Union, types.UnionType):
        offered = dict.fromkeys(_words(one) for one in arguments if one is not type(None))
        return " or ".join(offered)
    if origin is typing.Literal:
        return " or ".join(f"`{value!r}`".replace("'", '"') for value in arguments)
    if origin is tuple:
        return _row(arguments)
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return "table"
    return {float: "number", int: "whole number", str: "text"}[annotation]


def _row(arguments: tuple[Any, ...]) -> str:
    """Return, in words, which values a tuple type allows, given the types of its entries."""
    words = [_words(one) for one in arguments if one is not Ellipsis]
    if Ellipsis in arguments:
        return "array of tables" if words == ["table"] else f"list of {words[0]}"
    if len(set(words)) == 1:
        return f"{len(words)} × {words[0]}"
    return ", ".join(words)


if __name__ == "__main__":
    print(format_page(), end="")
