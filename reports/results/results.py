"""All that is in a result file, as reports are made from it."""

from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from ...engines import Method
from ...reference import Solution
from ...scenarios import Scenario
from .cost_records import EffectsCost, PassCosts
from .default_records import DefaultEffects
from .encoding_records import EncodedRuns
from .evidence import Evidence
from .records import Pair, Row
from .sweep_records import SweepResult
from .verdicts import Verdict


@dataclass(frozen=True, eq=False)
class SceneResult:
    """A scene as it was simulated, and its exact motion at the sample times."""

    scenario: Scenario
    solution: Solution


@dataclass(frozen=True, eq=False)
class Results:
    """Everything a report is made from.

    Attributes
    ----------
    methods : what each engine's adapter declared of its methods, in the order it lists them
    stock_timesteps : s, of the engines that have one
    """

    environment: dict[str, str]
    scenes: dict[str, SceneResult]
    rows: list[Row]
    verdicts: list[Verdict]
    effects: list[EffectsCost] = field(default_factory=list)
    passes: list[PassCosts] = field(default_factory=list)
    defaults: list[DefaultEffects] = field(default_factory=list)
    encodings: list[EncodedRuns] = field(default_factory=list)
    evidence: list[Evidence] = field(default_factory=list)
    methods: dict[Pair, Method] = field(default_factory=dict)
    stock_timesteps: dict[str, float] = field(default_factory=dict)
    sweeps: list[SweepResult] = field(default_factory=list)

    @property
    def every_row(self) -> list[Row]:
        """The runs of scenes as they are, then those of sweeps, each once."""
        points = {(p.key, p.variation): p for sweep in self.sweeps for p in sweep.points}
        return [*self.rows, *points.values()]

    def of(self, scene: str) -> Self:
        """Return the results of one scene, with the environment and all declared methods."""
        chosen: dict[str, Any] = {
            one.name: [record for record in records if record.key.scenario == scene]
            for one in fields(self)
            if one.name != "sweeps" and isinstance(records := getattr(self, one.name), list)
        }
        return replace(
            self,
            **chosen,
            scenes={name: one for name, one in self.scenes.items() if name == scene},
            sweeps=[one for one in self.sweeps if one.scenario.name == scene],
        )
