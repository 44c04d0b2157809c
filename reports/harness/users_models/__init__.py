"""Compares users' models as engines hold them with what their files state."""

from .inspect import CannotInspectError, ReaderEngine, inspect_model, reader_engines
from .records import InspectedLink, Inspection, LinkReading

__all__ = [
    "CannotInspectError",
    "InspectedLink",
    "Inspection",
    "LinkReading",
    "ReaderEngine",
    "inspect_model",
    "reader_engines",
]
