"""The part of a study that a user chooses to run."""

from dataclasses import dataclass

from ...engines import Engine, Method
from ...scenarios import Scenario
from ..results.records import Key
from .timesteps.ladder import MAX_STEPS, QUICK_STEPS

EngineMethod = tuple[Engine, Method]


@dataclass(frozen=True)
class Choice:
    """Which part of the grid of engines × methods × timesteps to run.

    Attributes
    ----------
    engines : the engines that are run
    methods : names of the methods that are run; if empty, all that an engine offers for a scene
    timesteps : the timesteps of the runs, s; if empty, the ladder is run
    max_steps : a ladder ends before a run would take more steps than this
    timed : whether the cost of a step of each method is measured
    hard_in_passing : whether hard scenes are studied only briefly: they are not timed, and no run
        of a ladder takes more than `QUICK_STEPS` steps, which show which methods blow up
    time_limit : CPU time that a run may take, s; if None, the default of the executor
    again : whether runs are made again although their results are stored
    """

    engines: tuple[Engine, ...]
    methods: tuple[str, ...] = ()
    timesteps: tuple[float, ...] = ()
    max_steps: int = MAX_STEPS
    timed: bool = True
    hard_in_passing: bool = False
    time_limit: float | None = None
    again: bool = False

    def max_steps_on(self, scenario: Scenario) -> int:
        """Return the largest number of steps that a run of a scene's ladder may take."""
        in_passing = self.hard_in_passing and scenario.hard
        return min(self.max_steps, QUICK_STEPS) if in_passing else self.max_steps

    def times(self, scenario: Scenario) -> bool:
        """Whether the cost of a step is measured on a scene."""
        return self.timed and not (self.hard_in_passing and scenario.hard)

    def pairs(self) -> list[EngineMethod]:
        """Return every chosen engine with each of its chosen methods."""
        return [
            (engine, method)
            for engine in self.engines
            for method in engine.methods
            if not self.methods or method.name in self.methods
        ]

    def methods_on(self, scenario: Scenario) -> dict[Key, EngineMethod]:
        """Return the pairs of engine and method to run on a scene, by the keys of their results.

        Engines that cannot load the scene's body are left out. If the user named methods, they are
        included even where the engine does not offer them for the scene.
        """
        return {
            Key(scenario.name, engine.name, method.name): (engine, method)
            for engine, method in self.pairs()
            if engine.applies_to(scenario)
            and (self.methods or method in engine.methods_for(scenario))
        }
