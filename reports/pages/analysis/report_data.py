"""A result file's contents, sorted for the report by scene, and in each scene by method."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....engines import Method
from ....reference import ExactMotion
from ....scenarios import (
    SIGNALS,
    Errors,
    ErrorSeries,
    FloatArray,
    Scenario,
    Signal,
    Trajectory,
    error_series,
)
from ....scenarios.fastest_rate import fastest_rate
from ...harness.comparison.defects import defects
from ...results.default_records import DefaultEffects
from ...results.evidence import Evidence
from ...results.records import Key, OfMethod, Pair, Row
from ...results.results import Results, SceneResult
from ...results.verdicts import Verdict
from .trace_style import TraceStyle, trace_styles
from .wording import typed


@dataclass(frozen=True, eq=False)
class MethodRuns(OfMethod):
    """The runs of one method on one scene, and the verdict on it.

    Attributes
    ----------
    rows : the runs, coarse to fine, without those on members of ensembles and those with some of
        the engine's defaults switched off
    verdict : the verdict; None if the study was stopped before there was one
    declared : what the adapter declared about the method when it ran; None if the file lacks it
    style : how the method's curves are drawn
    evidence : what the verdict rests on; None if there is none
    single_precision : whether the engine holds its state in single precision
    """

    engine: str
    method: str
    rows: tuple[Row, ...]
    verdict: Verdict | None
    declared: Method | None
    style: TraceStyle
    evidence: Evidence | None = None
    single_precision: bool = False

    def setup(self, timestep: float) -> str:
        """Return what users write to use the method at a timestep, s; empty if not known."""
        return self.declared.setup.replace("TIMESTEP", typed(timestep)) if self.declared else ""

    @property
    def as_shipped(self) -> bool:
        """Whether the adapter declares the method to be the engine as shipped."""
        return self.declared is not None and self.declared.as_shipped

    @property
    def is_recommendable(self) -> bool:
        """Whether the method may be recommended to users; true if `declared` is None."""
        return self.declared is None or self.declared.is_recommendable

    @cached_property
    def sampled(self) -> tuple[Row, ...]:
        """The runs whose samples the result file has, coarse to fine."""
        return tuple(row for row in self.rows if row.motion is not None and len(row.motion.t))

    @cached_property
    def finest(self) -> Row | None:
        """The finest run with the outcome `ok` and with samples.

        If no run with samples is `ok`, it is the finest run with samples; None if there is none.
        """
        finished = [row for row in self.sampled if row.outcome == "ok"]
        return next(iter([*(finished or self.sampled)][-1:]), None)

    @cached_property
    def stock(self) -> tuple[Row, ...]:
        """The runs at the engine's stock timestep and at 1 ms, coarse to fine.

        Rows of runs that were not made are included. The first is at the engine's own stock
        timestep, unless that is shorter than 1 ms.
        """
        return tuple(row for row in self.rows if row.stock)

    @property
    def drawn(self) -> tuple[Row, ...]:
        """The runs whose motions are drawn: the sampled ones of `stock`; without any, `finest`."""
        at_stock = tuple(row for row in self.sampled if row.stock)
        return at_stock or tuple(row for row in [self.finest] if row)


@dataclass(frozen=True, eq=False)
class SceneRuns:
    """One scene, its exact motion, and every method that was tried on it.

    Attributes
    ----------
    solved : the scene and its exact motion; None if the motion could not be solved
    methods : the runs of each method
    defaults : what each default of an engine does to the motion, for the engines for which that was
        measured
    """

    name: str
    solved: SceneResult | None
    methods: tuple[MethodRuns, ...]
    defaults: tuple[DefaultEffects, ...] = ()

    @property
    def title(self) -> str:
        """The scene's own title, or its name if the scene could not be solved."""
        return self.solved.scenario.title if self.solved else self.name

    @cached_property
    def by_pair(self) -> dict[Pair, MethodRuns]:
        """The runs of each method, by the names of engine and method."""
        return {runs.pair: runs for runs in self.methods}

    @cached_property
    def signals(self) -> tuple[Signal, ...]:
        """The signals in which the errors of all runs are known; none if the scene is unsolved."""
        solution = [self.solved.solution.uncertainty] if self.solved else []
        errors = [row.errors for runs in self.methods for row in runs.rows if row.errors]
        known = [dict(one).keys() for one in (*solution, *errors)]
        return tuple(s for s in SIGNALS if solution and all(s.name in names for names in known))

    @property
    def exact(self) -> SceneResult:
        """The scene and its exact motion; the scene must have been solved."""
        assert self.solved is not None, "what is exact is known of a solved scene"
        return self.solved

    @cached_property
    def fastest_rate(self) -> float:
        """The scene's fastest rate, rad/s."""
        return fastest_rate(self.exact.scenario, self.exact.solution.trajectory.omega_body)

    @property
    def end(self) -> float:
        """The last time of the exact motion, s."""
        return float(self.exact.solution.trajectory.t[-1])

    @property
    def turns(self) -> float:
        """The number of turns that the body makes up to `end` at the fastest rate."""
        return self.fastest_rate * self.end / (2 * math.pi)

    def outline(self, end: float, samples: int) -> Trajectory:
        """Return the exact motion at evenly spread times.

        Parameters
        ----------
        end : the last of these times, s; the first is 0
        samples : number of times
        """
        return ExactMotion(self.exact.scenario).outline(np.linspace(0.0, end, samples))

    @cached_property
    def compared(self) -> tuple["Compared", ...]:
        """The runs that are drawn, each with the exact motion at its own sample times.

        There are none if the scene could not be solved.
        """
        if self.solved is None:
            return ()
        scenario = self.solved.scenario
        return tuple(
            Compared(scenario, runs, row, motion, exact, error_series(scenario, motion, exact))
            for runs in self.methods
            for row in runs.drawn
            if (motion := row.motion) is not None
            for exact in [self._exact_at(motion)]
        )

    def _exact_at(self, motion: Trajectory) -> Trajectory:
        """Return the exact motion at the times of a run's samples.

        The stored exact motion is used if it begins with these times; otherwise the exact motion is
        computed.
        """
        stored, n = self.exact.solution.trajectory, len(motion.t)
        if n <= len(stored.t) and np.array_equal(stored.t[:n], motion.t):
            return stored.until(n)
        times = motion.t.tobytes()
        if times not in self._solved_at:
            self._solved_at[times] = ExactMotion(self.exact.scenario).outline(motion.t)
        return self._solved_at[times]

    @cached_property
    def _solved_at(self) -> dict[bytes, Trajectory]:
        """A cache of the exact motions that were computed, by their times as bytes."""
        return {}

    def uncertainty(self, row: Row) -> Errors:
        """Return the uncertainty of the reference that a run was compared with.

        That of ω is the larger of the one stored with the scene and the one stored with the run.
        """
        stored = row.reference_uncertainty
        if stored not in self._uncertainties:
            of_reference = self.exact.solution.uncertainty
            larger = replace(of_reference, omega=max(of_reference.omega, stored))
            self._uncertainties[stored] = larger
        return self._uncertainties[stored]

    @cached_property
    def _uncertainties(self) -> dict[float, Errors]:
        """A cache of results of `uncertainty`, by the uncertainty of ω stored with a run."""
        return {}


@dataclass(frozen=True, eq=False)
class Compared:
    """A run, with the exact motion and the errors at each of its samples.

    Attributes
    ----------
    runs : all runs of the method
    row : the run
    motion, exact : the run's motion and the exact motion, at the same times
    series : the errors at these times
    """

    scenario: Scenario
    runs: MethodRuns
    row: Row
    motion: Trajectory
    exact: Trajectory
    series: ErrorSeries

    @cached_property
    def defect(self) -> FloatArray:
        """The largest defect in any signal over the interval that ends at each sample, (n,).

        It is NaN at the start. It is NaN everywhere if the exact motion cannot be followed from
        sample to sample.
        """
        values = np.full(len(self.motion.t), np.nan)
        if found := defects(self.scenario, self.motion, self.exact):
            values[1:] = found.series.distances.max(axis=1)
        return values


@dataclass(frozen=True, eq=False)
class ReportData:
    """Everything that a report shows.

    Attributes
    ----------
    environment : machine, versions and date of the runs, by the name of the entry
    pairs : the methods, in the order in which they are listed
    scenes : the scenes, sorted by name
    """

    environment: dict[str, str]
    pairs: tuple[Pair, ...]
    scenes: tuple[SceneRuns, ...]

    @property
    def verdicts(self) -> list[Verdict]:
        """All verdicts, scene by scene."""
        return [runs.verdict for scene in self.scenes for runs in scene.methods if runs.verdict]

    @cached_property
    def plain(self) -> "ReportData":
        """The data of the plain scenes alone; of all scenes if all are hard."""
        plain = tuple(s for s in self.scenes if not (s.solved and s.solved.scenario.hard))
        return replace(self, scenes=plain or self.scenes)


def report_data(results: Results) -> ReportData:
    """Return a result file's records, sorted by scene and method."""
    keys = [row.key for row in results.rows] + [verdict.key for verdict in results.verdicts]
    listed = {pair: rank for rank, pair in enumerate(results.methods)}
    pairs = tuple(
        # Engines are ordered by name, their methods as the adapter lists them, unlisted methods
        # last.
        sorted(
            {key.pair for key in keys},
            key=lambda pair: (pair[0], listed.get(pair, len(listed)), pair[1]),
        )
    )
    names = sorted({key.scenario for key in keys} | set(results.scenes))
    drawn = trace_styles(pairs)
    verdicts = {verdict.key: verdict for verdict in results.verdicts}
    evidence = {one.key: one for one in results.evidence}
    tried: dict[Key, list[Row]] = {}
    for row in sorted(results.rows, key=lambda row: -row.timestep):
        tried.setdefault(row.key, []).append(row)

    def method_runs(key: Key) -> MethodRuns:
        rows, declared = tuple(tried.get(key, ())), results.methods.get(key.pair)
        style, judged_by = drawn[key.pair], evidence.get(key)
        is_single = key.engine in results.single_precision
        return MethodRuns(*key.pair, rows, verdicts.get(key), declared, style, judged_by, is_single)

    scenes = tuple(
        SceneRuns(
            name,
            results.scenes.get(name),
            tuple(
                method_runs(key)
                for key in (Key(name, *pair) for pair in pairs)
                if key in tried or key in verdicts
            ),
            tuple(one for one in results.defaults if one.key.scenario == name),
        )
        for name in names
    )
    return ReportData(results.environment, pairs, scenes)
