"""What a study is asked for."""

from dataclasses import dataclass

from ...engines import Engine, Method
from ...scenarios import Scenario
from ..runs.ladder import MAX_STEPS
from ..runs.records import Key

Pair = tuple[Engine, Method]

#: A quick study's ladders end before a run would take more steps than this.
QUICK_STEPS = 1 << 14


@dataclass(frozen=True)
class Choice:
    """Which part of the grid of engines × methods × timesteps to run; empty means all.

    Attributes
    ----------
    timesteps : s; the ladder is run where there are none
    max_steps : a ladder ends before a run would take more
    timed : whether steps are timed
    time_limit : s, that a run may take; the workers' own if None
    """

    engines: tuple[Engine, ...]
    methods: tuple[str, ...] = ()
    timesteps: tuple[float, ...] = ()
    max_steps: int = MAX_STEPS
    timed: bool = True
    time_limit: float | None = None

    def pairs(self) -> list[Pair]:
        """Every engine and method chosen."""
        return [
            (engine, method)
            for engine in self.engines
            for method in engine.methods
            if not self.methods or method.name in self.methods
        ]

    def methods_on(self, scenario: Scenario) -> dict[Key, Pair]:
        """The same, by what results on a scene are known by."""
        return {
            Key(scenario.name, engine.name, method.name): (engine, method)
            for engine, method in self.pairs()
        }
