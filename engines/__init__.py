"""Physics engines behind one interface."""

from .discovery import Missing, engines, missing
from .engine import BodyReading, Engine, EngineFault, Method, Outcome, Run, Session, State

__all__ = [
    "BodyReading",
    "Engine",
    "EngineFault",
    "Method",
    "Missing",
    "Outcome",
    "Run",
    "Session",
    "State",
    "engines",
    "missing",
]
