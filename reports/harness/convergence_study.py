"""The convergence study of one method on one scene: its runs, in order."""

import math
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field, replace
from typing import Literal

from ...engines import Engine, Method, Run
from ...reference import Solution
from ...scenarios import Expect, Scenario
from ..results.evidence import Evidence, ReplayEvidence, StepEvidence
from ..results.records import Key, Row
from .comparison.defects import with_defects
from .comparison.rows import compared, unmet_expectations
from .executors import Answer, CallFailed
from .judging import Records
from .judging.ladder_end import cut_short, is_finished
from .measuring.intervals import MadeRun
from .measuring.noise import rounding_of_body
from .measuring.places import Places
from .timesteps.ladder import Ladder, Rung
from .timesteps.stock import StockRun, stock_timestep


@dataclass(frozen=True, eq=False)
class PlannedRun:
    """A run that a study needs.

    Attributes
    ----------
    solution : the exact motion at the samples of the rung
    use : what the run's timestep is: `ladder`, a rung of the ladder; `above`, longer than all
        rungs; `stock`, a stock timestep; `single`, one that a user or an expectation names
    judged : whether the result file has evidence from this run, so that its samples are not needed
    expectations : expectations of the scene for this timestep
    """

    rung: Rung
    solution: Solution
    use: Literal["single", "ladder", "above", "stock"]
    judged: bool = False
    expectations: tuple[Expect, ...] = ()

    def is_answered_by(self, row: Row) -> bool:
        """Whether a stored row suffices, so that this run need not be made again.

        The row of a run that is not `ok` suffices. That of an `ok` run must have the motion at all
        samples, since the motion is judged, drawn, and compared with expectations. The motion is
        not needed if the run was judged before, or is `single` or `above` without expectations.
        """
        if row.outcome != "ok" or self.judged:
            return True
        if self.use in ("single", "above") and not self.expectations:
            return True
        return row.motion is not None and len(row.motion.t) == len(self.rung.sample_steps)


@dataclass(eq=False)
class ConvergenceStudy:
    """The runs of a method on a scene, in order, and the evidence that its verdict is based on.

    Attributes
    ----------
    solution : the exact motion at the ladder's sample times
    ladder : None if only single timesteps are asked for
    singles : runs at timesteps that a user asked for, or that an expectation of the scene names
    stock : runs at stock timesteps
    before : the stored evidence that the method was judged by before; None if there is none
    rows, single_rows, above_rows, stock_rows : the rows so far, of the ladder's rungs, of single
        timesteps, of timesteps longer than all rungs, and of stock timesteps
    unmet : expectations of the scene that were not met, in words
    places : exact states from which the method's single steps are tested, and the timesteps of
        these steps; None if single steps are not tested
    steps, own_steps, replays : the evidence so far (see `Evidence`)
    refusal : why steps could not be examined, or runs not replayed; None if they could
    """

    scenario: Scenario
    engine: Engine
    method: Method
    solution: Solution
    ladder: Ladder | None
    singles: list[PlannedRun] = field(default_factory=list)
    stock: list[StockRun] = field(default_factory=list)
    before: Evidence | None = None
    rows: list[Row] = field(default_factory=list)
    single_rows: list[Row] = field(default_factory=list)
    above_rows: list[Row] = field(default_factory=list)
    stock_rows: list[Row] = field(default_factory=list)
    unmet: list[str] = field(default_factory=list)
    places: Places | None = None
    steps: StepEvidence | None = None
    own_steps: StepEvidence | None = None
    replays: tuple[ReplayEvidence, ...] = ()
    refusal: CallFailed | None = None

    @property
    def evidence(self) -> Evidence:
        """The evidence that the method is judged by: `before` if given, else what was measured."""
        refused = (self.refusal.reason, self.refusal.cause) if self.refusal else ()
        return self.before or Evidence(self.key, self.steps, self.own_steps, self.replays, *refused)

    @property
    def records(self) -> Records:
        """The records of the runs so far, by which the method is judged."""
        scenario, engine = self.scenario, self.engine
        return Records(
            self.evidence,
            self.rows,
            self.single_rows,
            self.above_rows,
            self.ladder is not None,
            min(self.method.order, self.method.attitude_order),
            self.method.as_shipped,
            engine.unsupported(scenario, self.method),
            engine.single_precision,
            rounding_of_body(self.places.condition, engine.ulp) if self.places else 0.0,
            self.places is not None,
            tuple(self.unmet),
            scenario.document.known,
        )

    @property
    def made_runs(self) -> tuple[list[MadeRun], list[MadeRun]]:
        """The runs that may be replayed: those of the ladder, coarse to fine, and the others.

        The others are at single timesteps and at the engine's own stock timestep, one at each. Only
        `ok` runs whose motion is known at all samples are included.
        """
        ladder = self.ladder.rungs if self.ladder else ()
        own = stock_timestep(self.engine)
        stock = [run.rung for run in self.stock if run.rung and run.timestep == own]
        singles = [planned.rung for planned in self.singles]
        others = {rung.timestep: rung for rung in [*singles, *stock]}

        def made(rungs: Iterable[Rung], rows: list[Row]) -> list[MadeRun]:
            by_timestep = {row.timestep: row for row in rows if row.outcome == "ok"}
            return [
                MadeRun(rung, row.motion)
                for rung in rungs
                if (row := by_timestep.get(rung.timestep))
                and row.motion is not None
                and len(row.motion.t) == len(rung.sample_steps)
            ]

        return made(ladder, self.rows), made(others.values(), self.single_rows + self.stock_rows)

    @property
    def key(self) -> Key:
        """The key of the results: scene, engine and method."""
        return Key(self.scenario.name, self.engine.name, self.method.name)

    def runs(self) -> Generator[PlannedRun, Row]:
        """Yield the planned runs one by one; the caller sends the row of each into the generator.

        The order is: single timesteps; the ladder, coarse to fine, until no finer rung is needed;
        timesteps longer than all rungs, fine to coarse, until a run does not survive; stock
        timesteps. Without a ladder only the single timesteps are run.
        """
        for single in self.singles:
            row = yield single
            self.single_rows.append(row)
            for expectation in single.expectations:
                exact = single.solution.trajectory
                self.unmet += unmet_expectations(self.scenario, expectation, row, exact)
        if self.ladder is None:
            return
        for rung in self.ladder.rungs:
            judged = self.before is not None
            self.rows.append((yield PlannedRun(rung, self.solution, "ladder", judged)))
            if is_finished(self.records):
                break
        is_alive = not self.rows or self.rows[0].survived
        for rung in self.ladder.above if is_alive else ():
            self.above_rows.append(
                (yield PlannedRun(rung, thinned(self.solution, rung.every), "above"))
            )
            if not self.above_rows[-1].survived:
                break
        for run in self._stock_left:
            if run.rung and run.solution:
                self.stock_rows.append((yield PlannedRun(run.rung, run.solution, "stock")))

    def compare(self, planned: PlannedRun, answer: Answer[Run]) -> Row:
        """Compare a run with the exact motion, and return its row.

        Defects are added to the row if the run is at a stock timestep, or at one that a user or an
        expectation names. The motion of a run with a timestep longer than all rungs is left out of
        the row if the ladder has rows.

        Parameters
        ----------
        planned : the run as it was planned
        answer : the run, or why the call that should make it failed; and what the engine printed
        """
        row = compared(
            self.scenario,
            self.engine,
            self.key,
            planned.rung,
            answer,
            planned.solution,
            # The equations of an engine as shipped are expected to differ from the scene's.
            None if self.method.as_shipped else self.steps,
        )
        if row.stock or planned.use == "single":
            exact, is_single = planned.solution.trajectory, self.engine.single_precision
            return with_defects(row, self.scenario, exact, is_single=is_single)
        if self.rows and planned.use == "above":
            # The run's samples are not needed, as finer runs are judged and drawn.
            return replace(row, motion=None)
        return row

    def refusals(self) -> list[Row]:
        """Return an `unsupported` row for each stock timestep that is refused on the scene."""
        return [
            Row(
                self.key,
                self.engine.version,
                run.timestep,
                "unsupported",
                run.refusal,
                "timestep",
                stock=True,
            )
            for run in self._stock_left
            if run.refusal
        ]

    @property
    def cut_short(self) -> bool:
        """Whether the ladder ended at the step limit although finer rungs were still needed."""
        return cut_short(self.records)

    def discardable_timesteps(self) -> list[float]:
        """Return the timesteps, s, of the runs whose samples are not needed after the verdict.

        Needed are the samples of three sorts of runs: the finest run with samples, and runs at
        stock timesteps, as reports show their motion; and runs with expectations, as messages tell
        since when an expectation is not met.
        """
        rows = self.rows + self.single_rows + self.above_rows
        kept = {single.rung.timestep for single in self.singles if single.expectations}
        kept.add(min((row.timestep for row in rows if row.motion is not None), default=math.inf))
        return [row.timestep for row in rows if row.timestep not in kept and not row.stock]

    @property
    def _stock_left(self) -> list[StockRun]:
        """The runs at stock timesteps without a row so far.

        There are none if the method cannot simulate the scene, or failed on the whole ladder.
        """
        return (
            []
            if self._is_hopeless
            else [r for r in self.stock if r.timestep not in self._timesteps_so_far]
        )

    @property
    def _timesteps_so_far(self) -> set[float]:
        """Timesteps of all rows so far, s."""
        rows = self.rows + self.single_rows + self.above_rows + self.stock_rows
        return {row.timestep for row in rows}

    @property
    def _is_hopeless(self) -> bool:
        """Whether the method cannot simulate the scene, or failed in every run of the ladder."""
        if self.engine.unsupported(self.scenario, self.method):
            return True
        return bool(self.rows) and all(map(self.records.is_hopeless, self.rows))


def thinned(solution: Solution, every: int) -> Solution:
    """Return the exact motion at its first sample time, and at each `every`-th one after that."""
    if every == 1:
        return solution
    return replace(solution, trajectory=solution.trajectory.every(every))
