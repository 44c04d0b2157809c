"""Compares users' models as engines hold them with what their files state."""

from .findings import (
    InspectedLink,
    Inspection,
    LinkReading,
    added_masses,
    cell_text,
    composed_bodies,
    differences,
    listed,
    problems_of,
    stated_mass,
    weight_in_words,
    worst_links,
)
from .inspect import READ_LIMIT, CannotInspectError, attitude_apart, inspect_model, reader_engines
from .remedy import line_without_rotation, remedies

__all__ = [
    "READ_LIMIT",
    "CannotInspectError",
    "InspectedLink",
    "Inspection",
    "LinkReading",
    "added_masses",
    "attitude_apart",
    "cell_text",
    "composed_bodies",
    "differences",
    "inspect_model",
    "line_without_rotation",
    "listed",
    "problems_of",
    "reader_engines",
    "remedies",
    "stated_mass",
    "weight_in_words",
    "worst_links",
]
