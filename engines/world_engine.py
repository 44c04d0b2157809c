"""An engine whose world is defined in a stand-alone module, `world.py`, beside the adapter."""

import inspect
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

from spincheck.engine import Engine, Method, Scenario, Session

from .users_models import ModelReader
from .world_session import WorldSession, world_script


class WorldEngine(Engine):
    """An engine whose scenes are simulated by a stand-alone module `world.py` beside the adapter.

    The engine's scripts contain that module. The engine is named as its Python distribution.

    Attributes
    ----------
    session : the class of the engine's sessions
    reader : how the engine reads users' model files; None if it reads none
    """

    interface = 2
    session: ClassVar[type[WorldSession]]
    reader: ClassVar[ModelReader | None] = None

    @property
    def version(self) -> str:
        """The version of the installed package."""
        return version(self.name)

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Return a session of a new world with the scene's body at its start."""
        module = type(self).__module__.rpartition(".")[0]
        return self.session(f"{module}.world", scenario, method.name, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """Return a Python script of the run, which contains the module `world.py`."""
        world = Path(inspect.getfile(type(self))).with_name("world.py")
        return world_script(world, scenario, method.name)
