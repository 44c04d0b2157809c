"""The interface for adapters of physics engines: docs/how-to/add-an-engine.md.

An adapter may use these names, and the attributes of scenes that are listed on that page, and
nothing else. It states the version of the interface that it is written for, as `Engine.interface`.
"""

from spincheck.engines.batch import Batch
from spincheck.engines.checks.read_back import (
    BodyReading,
    Difference,
    EngineError,
    State,
    UnsupportedError,
    composed,
    start_state,
)
from spincheck.engines.derivative import Derivative, along, in_chart, numbers_by_chart
from spincheck.engines.engine import Engine
from spincheck.engines.fault import Cause, Fault
from spincheck.engines.interface import NEWEST, OLDEST
from spincheck.engines.method import COMMON_EFFECTS, Method, Release
from spincheck.engines.missing import Missing
from spincheck.engines.models.description import PLAIN, Description
from spincheck.engines.session import Session
from spincheck.scenarios import FloatArray, Scenario
from spincheck.scenarios.gyrostat import Rotor

__all__ = [
    "COMMON_EFFECTS",
    "NEWEST",
    "OLDEST",
    "PLAIN",
    "Batch",
    "BodyReading",
    "Cause",
    "Derivative",
    "Description",
    "Difference",
    "Engine",
    "EngineError",
    "Fault",
    "FloatArray",
    "Method",
    "Missing",
    "Release",
    "Rotor",
    "Scenario",
    "Session",
    "State",
    "UnsupportedError",
    "along",
    "composed",
    "in_chart",
    "numbers_by_chart",
    "start_state",
]
