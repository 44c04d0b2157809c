"""An engine whose worlds are in a stand-alone module beside its adapter, `world.py`."""

import inspect
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

from spincheck.engine import Engine, Method, Scenario, Session

from .users_models import ModelReader
from .world_session import WorldSession, world_script


class WorldEngine(Engine):
    """Opens scenes in worlds of that module, and returns the module as a script.

    Its name is that of its distribution.

    Attributes
    ----------
    session : class of the session that reads a world
    reader : how the engine reads users' model files, if it does
    """

    interface = 2
    session: ClassVar[type[WorldSession]]
    reader: ClassVar[ModelReader | None] = None

    @property
    def version(self) -> str:
        """The version of the installed package."""
        return version(self.name)

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Build a world with the body, held where the scene says."""
        module = type(self).__module__.rpartition(".")[0]
        return self.session(f"{module}.world", scenario, method.name, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """Return the world as Python."""
        world = Path(inspect.getfile(type(self))).with_name("world.py")
        return world_script(world, scenario, method.name)
