"""The contents of a result file, in the form from which reports are made."""

from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from ...engines import Method
from ...reference import Solution
from ...scenarios import Scenario
from .cost_records import MethodCost
from .default_records import DefaultEffects
from .ensemble_records import EnsembleResult
from .evidence import Evidence
from .records import Pair, Row
from .verdicts import Verdict


@dataclass(frozen=True, eq=False)
class SceneResult:
    """A scene as it was simulated, and its exact motion at the sample times."""

    scenario: Scenario
    solution: Solution


@dataclass(frozen=True, eq=False)
class Results:
    """Everything that a report is made from.

    Attributes
    ----------
    environment : machine and versions, by name
    scenes : the scenes that were solved, by name
    rows : the runs in which nothing is varied
    verdicts : one for each method and scene
    costs : costs of steps of varied engines, such as those that leave no part of a step out; the
        costs of unvaried engines are in `rows`
    defaults : the effects of engines' defaults, where they were measured
    evidence : what the verdicts rest on besides the runs
    methods : what each engine's adapter declares about its methods, in the adapter's order
    stock_timesteps : stock timesteps, s, of the engines that have one
    single_precision : names of the engines that hold their state in floats of 24 bits
    ensembles : the ensembles that were asked for, with their stored runs
    varied : the runs in which something is varied, such as members of ensembles
    """

    environment: dict[str, str]
    scenes: dict[str, SceneResult]
    rows: list[Row]
    verdicts: list[Verdict]
    costs: list[MethodCost] = field(default_factory=list)
    defaults: list[DefaultEffects] = field(default_factory=list)
    evidence: list[Evidence] = field(default_factory=list)
    methods: dict[Pair, Method] = field(default_factory=dict)
    stock_timesteps: dict[str, float] = field(default_factory=dict)
    single_precision: frozenset[str] = frozenset()
    ensembles: list[EnsembleResult] = field(default_factory=list)
    varied: list[Row] = field(default_factory=list)

    @property
    def every_row(self) -> list[Row]:
        """The runs in which nothing is varied, as in `rows`; then the others.

        The others are sorted by scene, engine, method, what is varied, and timestep.
        """
        return [*self.rows, *sorted(self.varied, key=_place)]

    def of(self, scene: str) -> Self:
        """Return the results of one scene; all that belongs to no scene is kept."""
        chosen: dict[str, Any] = {
            one.name: [record for record in records if record.key.scenario == scene]
            for one in fields(self)
            if one.name != "ensembles" and isinstance(records := getattr(self, one.name), list)
        }
        return replace(
            self,
            **chosen,
            scenes={name: one for name, one in self.scenes.items() if name == scene},
            ensembles=[one for one in self.ensembles if one.scenario.name == scene],
        )


def _place(row: Row) -> tuple[object, ...]:
    """Return the sort key of a varied run: scene, engine, method, what is varied, and timestep.

    Varied numbers are sorted as numbers, other values as texts; long timesteps come first.
    """
    varied = row.varied
    values = [
        (one, "") if isinstance(one, int | float) else (0, str(one)) for one in varied.values()
    ]
    key = row.key
    return key.scenario, key.engine, key.method, [*varied], values, -row.timestep
