"""Runs a scene's body in other descriptions that mean the same, and compares the motions."""

from .running import run_encodings

__all__ = ["run_encodings"]
