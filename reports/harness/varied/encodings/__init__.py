"""Runs a scene's body in other descriptions of the same meaning, and compares the motions."""

from .running import run_encodings

__all__ = ["run_encodings"]
