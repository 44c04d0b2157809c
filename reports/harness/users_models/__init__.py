"""Compares users' models as engines hold them with what their files state."""

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
