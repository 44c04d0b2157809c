"""An engine whose scenes are opened by `open_with`, in place of its adapter's `open`."""

from typing import Any, final

from ..scenarios import Scenario
from .checks.read_back import BodyReading, Difference, State
from .engine import Engine
from .method import Method
from .session import Session


@final
class VariedEngine(Engine):
    """An engine like another one, except that it opens scenes by the other's `open_with`.

    Parameters
    ----------
    base : the other engine
    way : name of the keyword argument that is passed to `open_with`
    names : value of that argument
    """

    def __init__(self, base: Engine, way: str, names: tuple[str, ...]) -> None:
        self.name, self.base = base.name, base
        self._way: dict[str, Any] = {way: names}
        self.varied = {way: list(names)}
        self.methods = base.methods
        self.single_precision = base.single_precision

    @property
    def version(self) -> str:
        """The version of the other engine."""
        return self.base.version

    @property
    def site(self) -> str:
        """The folder from which worker processes import modules first; see `Engine.site`."""
        return self.base.site

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Open the scene by `open_with` of the other engine; return the session."""
        return self.base.open_with(scenario, method, timestep, **self._way)

    def differences(
        self, scenario: Scenario, method: str, body: BodyReading, state: State
    ) -> list[Difference]:
        """Return the quantities that differ from the scene, by the other engine's `differences`.

        `body` and `state` were read back before the first step of the method named `method`.
        """
        return self.base.differences(scenario, method, body, state)
