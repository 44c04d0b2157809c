"""Compares users' models as engines hold them with what their files state."""

from .findings import (
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
from .inspect import READ_LIMIT, CannotInspectError, inspect_model, reader_engines
from .motion_apart import attitude_apart
from .records import InspectedLink, Inspection, LinkReading
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
