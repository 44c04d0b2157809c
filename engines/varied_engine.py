"""An engine that opens scenes in another way than its adapter's `open`."""

from typing import Any, final

from ..scenarios import Scenario
from .checks.read_back import BodyReading, Difference, State
from .engine import Engine
from .method import Method
from .session import Session


@final
class VariedEngine(Engine):
    """An engine that opens scenes by another engine's `open_with`, and else behaves as that engine.

    Parameters
    ----------
    base : the other engine
    way : name of the argument of `open_with` that is given
    names : the names that are passed as this argument
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
        """The folder that a worker process imports the other engine from; see `Engine.site`."""
        return self.base.site

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Open the scene by `open_with` with the argument `way`."""
        return self.base.open_with(scenario, method, timestep, **self._way)

    def differences(
        self, scenario: Scenario, method: str, body: BodyReading, state: State
    ) -> list[Difference]:
        """Return how body and start differ from the scene, as the other engine finds."""
        return self.base.differences(scenario, method, body, state)
