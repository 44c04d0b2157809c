"""Physics engines behind one interface."""

from .discovery import Missing, engines, missing
from .engine import Engine, Method
from .read_back import BodyReading, EngineError, State
from .run import Outcome, Run
from .session import Session

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
