"""Physics engines behind one interface."""

from .discovery import Missing, engines, missing
from .engine import Engine, Method
from .fault import Cause, Fault
from .read_back import BodyReading, EngineError, State
from .run import Outcome, Run
from .session import Session

__all__ = [
    "BodyReading",
    "Cause",
    "Engine",
    "EngineError",
    "Fault",
    "Method",
    "Missing",
    "Outcome",
    "Run",
    "Session",
    "State",
    "engines",
    "missing",
]
