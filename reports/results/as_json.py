"""Records as JSON objects, with the names that scripts rely on."""

from dataclasses import fields
from typing import Any

from pydantic_core import to_jsonable_python

from ...scenarios import Errors
from .records import MOTIONS, Key, Record


def as_json(record: Record) -> dict[str, Any]:
    """Every field of a record but its motion; errors have a field each, null if there are none."""
    content: dict[str, Any] = {}
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, Key):
            content |= vars(value)
        elif field.name == "errors":
            named = dict(value) if value else {one.name: None for one in fields(Errors)}
            content |= {f"{signal}_error": error for signal, error in named.items()}
        elif field.name not in MOTIONS:
            content[field.name] = to_jsonable_python(value, inf_nan_mode="constants")
    return content
