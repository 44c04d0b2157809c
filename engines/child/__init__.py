"""Engines in other languages: a child process that answers JSON lines; docs/engine-protocol.md."""

from .engine import ChildEngine, child_engine
from .process import ANSWER_LIMIT, ProtocolError

__all__ = ["ANSWER_LIMIT", "ChildEngine", "ProtocolError", "child_engine"]
