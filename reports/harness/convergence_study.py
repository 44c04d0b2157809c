"""The convergence study of one method on one scene: its runs, in order."""

from collections.abc import Generator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

from ...engines import Engine, Method, Run
from ...reference import Solution
from ...scenarios import Expect, Scenario
from ..results.evidence import JudgedRung
from ..results.records import Key, LocalCheck, Row
from .choice import QUICK_STEPS
from .comparison import row_of, unmet_expectations
from .defects import with_defects
from .executors import Answer, CallFailed
from .judging.places import Places
from .ladder import EXCESS, LEAST_RUNGS, MIN_RUNGS, Ladder, Rung
from .ladder_judge import LadderJudge
from .stock import StockRun, stock_timesteps


@dataclass(frozen=True, eq=False)
class SingleRun:
    """A single timestep: asked for by a user, or named in an expectation of the scene."""

    rung: Rung
    solution: Solution
    expectations: tuple[Expect, ...] = ()


@dataclass(frozen=True, eq=False)
class PlannedRun:
    """A run that a study asks for.

    Attributes
    ----------
    solution : the exact motion at the samples of the rung
    use : what it is for
    judged : whether it was judged before, so that its samples are not needed
    """

    rung: Rung
    solution: Solution
    use: Literal["single", "ladder", "above", "stock"]
    judged: bool = False

    def is_answered_by(self, row: Row) -> bool:
        """Whether a stored row will do: what is judged or drawn needs a motion at the samples."""
        if row.outcome != "ok" or self.use in ("single", "above") or self.judged:
            return True
        return row.motion is not None and len(row.motion.t) == len(self.rung.sample_steps)


@dataclass(eq=False)
class ConvergenceStudy:
    """The runs of a method on a scene, in order, and what their verdict is based on.

    Attributes
    ----------
    solution : the exact motion at the ladder's sample times
    ladder : None if only single timesteps are asked for
    stock : runs at stock timesteps
    judged : rungs of the ladder as they were judged before
    rows, single_rows, above_rows, stock_rows : the runs so far
    unmet : expectations of the scene that were not met, in words
    places : exact states that the method is tested from, if there are any
    local : what it does from there
    remembers : whether a run goes on otherwise than if restarted from its own states; None if that
        is not known
    """

    scenario: Scenario
    engine: Engine
    method: Method
    solution: Solution
    ladder: Ladder | None
    singles: list[SingleRun] = field(default_factory=list)
    stock: list[StockRun] = field(default_factory=list)
    judged: tuple[JudgedRung, ...] = ()
    rows: list[Row] = field(default_factory=list)
    single_rows: list[Row] = field(default_factory=list)
    above_rows: list[Row] = field(default_factory=list)
    stock_rows: list[Row] = field(default_factory=list)
    unmet: list[str] = field(default_factory=list)
    places: Places | None = None
    local: LocalCheck | None = None
    remembers: bool | None = None

    @cached_property
    def judge(self) -> LadderJudge:
        """Judges the ladder."""
        judged = {rung.timestep: rung for rung in self.judged}
        return LadderJudge(self.scenario, self.engine, self.method, self.solution, judged)

    @property
    def key(self) -> Key:
        """Scene, engine and method."""
        return Key(self.scenario.name, self.engine.name, self.method.name)

    def runs(self) -> Generator[PlannedRun, Row]:
        """Ask for one run after the other, and take its row: just made, or stored.

        First the single timesteps, then the ladder down to where it can be judged, then timesteps
        above it as long as they survive, then stock timesteps.
        """
        for single in self.singles:
            row = yield PlannedRun(single.rung, single.solution, "single")
            self.single_rows.append(row)
            for expectation in single.expectations:
                self.unmet += unmet_expectations(expectation, row)
        if self.ladder is None:
            return
        for rung in self.ladder.rungs:
            judged = rung.timestep in self.judge.judged
            self.rows.append((yield PlannedRun(rung, self.solution, "ladder", judged)))
            self.judge.take(self.rows[-1])
            if self._is_down:
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
        """Compare a run that was asked for with the exact motion; returns its row."""
        version, rung, run = self.engine.version, planned.rung, self._of_other_law(answer.value)
        row = row_of(self.scenario, self.key, version, rung, run, planned.solution)
        is_stock = rung.timestep in stock_timesteps(self.engine)
        row = replace(row, printed=answer.printed, stock=is_stock)
        exact, is_single = planned.solution.trajectory, self.engine.single_precision
        row = with_defects(row, self.scenario, exact, is_single=is_single)
        if self.rows and planned.use == "above" and not is_stock:
            # Its samples are not needed: finer runs are judged and drawn.
            row = replace(row, motion=None)
        return row

    def _of_other_law(self, run: Run | CallFailed) -> Run | CallFailed:
        """The run, marked where single steps do not obey the scene's equations of motion."""
        if isinstance(run, CallFailed) or not (self.local and self.local.reason):
            return run
        reason = "; ".join(filter(None, (run.reason, self.local.reason)))
        if run.outcome == "ok":
            return replace(run, cause="law", reason=reason)
        # A lag at however small a step is not a clamp.
        is_clock = run.cause == "lag" and self.local.at_any_timestep
        return replace(run, outcome="failed", cause="clock", reason=reason) if is_clock else run

    def refusals(self) -> list[Row]:
        """Rows of stock timesteps that do not fit the scene: `unsupported`, without a run."""
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
        """Whether finer rungs would have been run if the step limit allowed them."""
        if self.ladder is None:
            return False
        if not self.rows:
            return self.ladder.least_steps > 0
        settled = self._hopeless(self.rows[-1]) or self._diverges_at_any_timestep
        return not (settled or self._is_decided or self.judge.is_known)

    def discardable_timesteps(self) -> list[float]:
        """Timesteps of the runs whose samples are not needed after the verdict.

        A report shows the finest run that has any, and those at stock timesteps.
        """
        rows = self.rows + self.single_rows + self.above_rows
        shown = min((row.timestep for row in rows if row.motion is not None), default=None)
        return [row.timestep for row in rows if row.timestep != shown and not row.stock]

    @property
    def _stock_left(self) -> list[StockRun]:
        """Stock timesteps without a run; none if no timestep can succeed."""
        return [] if self._pointless else [r for r in self.stock if r.timestep not in self._taken]

    @property
    def _taken(self) -> set[float]:
        rows = self.rows + self.single_rows + self.above_rows + self.stock_rows
        return {row.timestep for row in rows}

    @property
    def _pointless(self) -> bool:
        """Whether the method cannot simulate the scene, or failed at every timestep so far."""
        if self.engine.unsupported(self.scenario, self.method):
            return True
        return bool(self.rows) and all(self._hopeless(row) for row in self.rows)

    @property
    def _is_down(self) -> bool:
        """Whether no finer rung is needed, or can succeed."""
        assert self.ladder is not None, "only a ladder has an end"
        if self._hopeless(self.rows[-1]) or self._diverges_at_any_timestep:
            return True
        if self._is_decided:
            return True
        finest = self.ladder.rungs[-1].timestep
        settled = self.judge.is_known or self.judge.is_out_of_reach(finest)
        return len(self.rows) >= MIN_RUNGS and settled

    @property
    def _is_decided(self) -> bool:
        """Whether steps and pieces decide, and a quick study's ladder has no more to show.

        Errors of finer rungs, and their costs, follow by the order.
        """
        if self.local is None or not self.local.converges:
            return False
        last, excess = self.rows[-1], EXCESS if len(self.rows) < LEAST_RUNGS else 1
        finest = last.timestep * last.steps / QUICK_STEPS
        in_vain = len(self.rows) >= MIN_RUNGS and self.judge.is_out_of_reach(finest)
        return in_vain or 2 * last.steps > excess * QUICK_STEPS

    @property
    def last_row(self) -> Row | None:
        """The run that decides the verdict where nothing is judged; None if there is none."""
        if self.rows or self.ladder is None:
            return (self.rows or self.single_rows)[-1]
        # Without rungs, only runs above the ladder exist: too coarse for anything but a failure.
        return next((row for row in self.above_rows if self._hopeless(row)), None)

    @property
    def _diverges_at_any_timestep(self) -> bool:
        """Whether the blow-up comes at the same time after the timestep was halved.

        In an unstable integrator, errors grow by a factor a step that tends to 1 faster than the
        number of steps increases, so halving delays the blow-up. A clamp is reached at the same
        time.
        """
        if len(self.rows) < 2:
            return False
        coarse, fine = (
            row.stopped_at if row.outcome == "diverged" else None for row in self.rows[-2:]
        )
        return coarse is not None and fine is not None and fine <= coarse

    def _hopeless(self, last: Row) -> bool:
        """Whether no finer timestep can succeed: the run failed, or the method lacks an effect."""
        if last.outcome == "unsupported":
            return bool(self.engine.unsupported(self.scenario, self.method))
        return last.outcome == "failed"


def thinned(solution: Solution, every: int) -> Solution:
    """The exact motion at every n-th of its sample times."""
    if every == 1:
        return solution
    return replace(solution, trajectory=solution.trajectory.every(every))
