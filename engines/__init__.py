"""Physics engines behind one interface."""

from .batch import Batch
from .checks.read_back import BodyReading, EngineError, State, UnsupportedError
from .discovery import NameTaken, add, engines, missing
from .engine import Engine
from .fault import Cause, Fault
from .method import Method
from .missing import Missing
from .run import Outcome, Run
from .session import Session
