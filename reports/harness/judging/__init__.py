"""Derives verdicts from records. It runs no engine, and reads no file."""

from .records import Records
from .verdict import judge

__all__ = ["Records", "judge"]
