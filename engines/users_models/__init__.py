"""How a body that an engine holds differs from the one that a model file states, and why."""

from .cause import Kind, cause, held_of_nothing
from .difference import AGREES, BodyDifference, difference

__all__ = ["AGREES", "BodyDifference", "Kind", "cause", "difference", "held_of_nothing"]
