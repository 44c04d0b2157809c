"""Engines in other languages, as child processes: docs/reference/engine-protocol.md."""

from .engine import ChildEngine, child_engine
from .process import ANSWER_LIMIT, ProtocolError
