"""Users' own models: what each engine holds of them, against what their file states."""

from .inspect import Asked, CannotInspectError, asked_engines, inspect_model
from .records import Held, InspectedLink, Inspection

__all__ = [
    "Asked",
    "CannotInspectError",
    "Held",
    "InspectedLink",
    "Inspection",
    "asked_engines",
    "inspect_model",
]
