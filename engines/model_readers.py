"""The readers of model files of all engines that are installed."""

from functools import cache

from .discovery import engines
from .users_models import FileEngine, ModelReader
from .world_engine import WorldEngine


@cache
def model_readers() -> dict[str, ModelReader]:
    """Return the readers of model files of the installed engines, by the reader's name."""
    readers = [
        engine.reader
        for engine in engines().values()
        if isinstance(engine, FileEngine | WorldEngine) and engine.reader
    ]
    return {reader.name: reader for reader in readers}
