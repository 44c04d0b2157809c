"""Sweeps in a result file: their definitions, and every point as soon as it is run."""

import json
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from ...scenarios import Scenario
from .sweep_records import (
    DefinedSweep,
    Ensemble,
    EnsembleResult,
    Map,
    MapResult,
    PointResult,
    SweepPoint,
)
from .tables import POINTS, SWEEPS, as_result_file_error

if TYPE_CHECKING:
    from .store import Store

#: Engine and method of the result at a point whose numbers make no scene.
NO_SCENE = ("", "")


class SweepTables:
    """The sweeps of an open result file.

    A place is known by what is different there: two maps that share it share its points.
    """

    def __init__(self, store: "Store") -> None:
        self._store = store

    def put(self, sweep: Map | Ensemble, scenario: Scenario) -> None:
        """Store the definition of a sweep."""
        self._store.put(DefinedSweep(scenario.name, sweep, scenario.text))

    def put_points(self, point: SweepPoint, results: Iterable[PointResult]) -> None:
        """Record the results at one point."""
        self._store.put(*(replace(result, place=point.identity) for result in results))

    def stored(self, scenario: str) -> list[PointResult]:
        """The stored results of a scene's points, of all sweeps."""
        return self._store.select(POINTS, "scenario = ?", (scenario,))

    def points(self, sweep: Map | Ensemble) -> tuple[PointResult, ...]:
        """The stored results of a sweep, in the order of its points."""
        return _results(sweep, self.stored(sweep.scenario))

    def read(self) -> tuple[list[MapResult], list[EnsembleResult]]:
        """Every map and every ensemble, with their points."""
        points: dict[str, list[PointResult]] = defaultdict(list)
        for result in self._store.select(POINTS):
            points[result.key.scenario].append(result)
        maps: list[MapResult] = []
        ensembles: list[EnsembleResult] = []
        for defined in self._store.select(SWEEPS, order="scenario, sweep"):
            scenario = as_result_file_error(defined.varied)()
            results = as_result_file_error(_results)(defined.sweep, points[defined.scenario])
            if isinstance(defined.sweep, Map):
                maps.append(MapResult(defined.sweep, scenario, results))
            else:
                ensembles.append(EnsembleResult(defined.sweep, scenario, results))
        return maps, ensembles


def _results(sweep: Map | Ensemble, stored: Iterable[PointResult]) -> tuple[PointResult, ...]:
    """The results of a sweep among those of its scene, in the order of its points.

    It loops over the stored results, not over all points of the sweep: few may have been run.
    """
    found = [
        replace(result, at=point.at)
        for result in stored
        if (point := sweep.point(json.loads(result.place))) is not None
    ]
    return tuple(sorted(found, key=lambda one: (one.at, one.key.engine, one.key.method)))
