"""Users' own models: what each engine holds of them, against what their file states."""

from .inspect import CannotInspectError, inspect_model
from .records import Difference, Held, InspectedLink, Inspection

__all__ = [
    "CannotInspectError",
    "Difference",
    "Held",
    "InspectedLink",
    "Inspection",
    "inspect_model",
]
