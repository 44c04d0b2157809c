"""Records as JSON objects, with the names that scripts rely on."""

from dataclasses import fields
from typing import Any

from pydantic_core import to_jsonable_python

from ...scenarios import errors_by_key
from .records import MOTIONS, Key, Record


def as_json(record: Record) -> dict[str, Any]:
    """Return a record as a JSON object, without its motion.

    Each field is an entry, with two exceptions. In place of a `Key` there are three entries: scene,
    engine and method. In place of a run's errors there is one entry for each signal, null if the
    run has no error in this signal.
    """
    content: dict[str, Any] = {}
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, Key):
            content |= vars(value)
        elif field.name == "errors":
            content |= errors_by_key(value)
        elif field.name not in MOTIONS:
            content[field.name] = to_jsonable_python(value, inf_nan_mode="constants")
    return content
