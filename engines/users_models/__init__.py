"""How a body that an engine holds differs from the one that a model file states, and why."""

from .cause import Kind, cause, unstated_body
from .difference import AGREES, BodyDifference, difference

__all__ = ["AGREES", "BodyDifference", "Kind", "cause", "difference", "unstated_body"]
