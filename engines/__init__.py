"""Physics engines behind one interface."""

from .discovery import Missing, engines, missing
from .engine import Engine, Method, Outcome, Run, Session
from .read_back import BodyReading, EngineError, State

__all__ = [
    "BodyReading",
    "Engine",
    "EngineError",
    "Method",
    "Missing",
    "Outcome",
    "Run",
    "Session",
    "State",
    "engines",
    "missing",
]
