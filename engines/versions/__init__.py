"""Other versions of the engines, each in a folder of its own."""

from .engine import VersionedEngine, versioned
from .folders import VersionError, install
