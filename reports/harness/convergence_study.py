"""The convergence study of one method on one scene: which run comes next, and the rows so far."""

from dataclasses import dataclass, field, replace
from functools import cached_property

from ...engines import Engine, Method, Run
from ...reference import Solution
from ...scenarios import Expect, Scenario
from ..results.records import Key, Row
from .comparison import row_of, unmet_expectations
from .executors import Answer
from .ladder import MIN_RUNGS, Ladder, Rung
from .ladder_judge import LadderJudge
from .stock import StockRun, stock_timesteps


@dataclass(frozen=True, eq=False)
class SingleRun:
    """A single timestep: asked for by a user, or named in an expectation of the scene."""

    rung: Rung
    solution: Solution
    expectations: tuple[Expect, ...] = ()


@dataclass(frozen=True, eq=False)
class _Coming:
    """The next run, the exact motion at its samples, and the list that its row is added to."""

    rung: Rung
    solution: Solution
    rows: list[Row]


@dataclass(eq=False)
class ConvergenceStudy:
    """The runs of a method on a scene, in order, and the verdict on them.

    First the single timesteps are run, then the ladder, then timesteps above the ladder as long as
    they survive, then stock timesteps.

    Attributes
    ----------
    solution : the exact motion at the ladder's sample times
    ladder : None if only single timesteps are asked for
    stock : runs at stock timesteps
    rows, single_rows, above_rows, stock_rows : the runs so far
    unmet : expectations of the scene that were not met, in words
    """

    scenario: Scenario
    engine: Engine
    method: Method
    solution: Solution
    ladder: Ladder | None
    singles: list[SingleRun] = field(default_factory=list)
    stock: list[StockRun] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    single_rows: list[Row] = field(default_factory=list)
    above_rows: list[Row] = field(default_factory=list)
    stock_rows: list[Row] = field(default_factory=list)
    unmet: list[str] = field(default_factory=list)

    @cached_property
    def judge(self) -> LadderJudge:
        """Judges the ladder."""
        return LadderJudge(self.scenario, self.engine, self.method, self.solution)

    @property
    def key(self) -> Key:
        """Scene, engine and method."""
        return Key(self.scenario.name, self.engine.name, self.method.name)

    def next_rung(self) -> Rung | None:
        """The rung to run next; None if no more runs are needed."""
        coming = self._coming()
        return coming.rung if coming else None

    def compare(self, answer: Answer[Run]) -> Row:
        """Compare the run of the next rung with the exact motion; returns its row."""
        coming = self._coming()
        assert coming is not None, "only a rung that is asked for is run"
        row = row_of(
            self.scenario,
            self.key,
            self.engine.version,
            coming.rung,
            answer.value,
            coming.solution,
        )
        stock = coming.rung.timestep in stock_timesteps(self.engine)
        row = replace(row, printed=answer.printed, stock=stock)
        if self.rows and coming.rows is self.above_rows and not stock:
            # Its samples are not needed: finer runs are judged and drawn.
            row = replace(row, motion=None)
        return row

    def take(self, row: Row) -> None:
        """Take the row of the next rung, whether just made or stored."""
        coming = self._coming()
        assert coming is not None, "only a rung that is asked for is taken"
        coming.rows.append(row)
        if coming.rows is self.rows:
            self.judge.take(row)
        elif coming.rows is self.single_rows:
            for expectation in self.singles[len(self.single_rows) - 1].expectations:
                self.unmet += unmet_expectations(expectation, row)

    def can_take(self, row: Row) -> bool:
        """Whether a stored row can be used: on a ladder it needs a motion at its samples."""
        coming = self._coming()
        if coming is None or row.outcome != "ok":
            return True
        if coming.rows is self.rows or coming.rows is self.stock_rows:
            return row.motion is not None and len(row.motion.t) == len(coming.rung.sample_steps)
        return True

    def refusals(self) -> list[Row]:
        """Rows of stock timesteps that do not fit the scene: `unsupported`, without a run."""
        if self._pointless:
            return []
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
            for run in self.stock
            if run.refusal and run.timestep not in self._taken
        ]

    @property
    def cut_short(self) -> bool:
        """Whether finer rungs would have been run if the step limit allowed them."""
        if self.ladder is None:
            return False
        if not self.rows:
            return self.ladder.least_steps > 0
        settled = self._hopeless(self.rows[-1]) or self._diverges_at_any_timestep
        return not (settled or self.judge.is_known)

    def discardable_timesteps(self) -> list[float]:
        """Timesteps of the runs whose samples are not needed after the verdict.

        A report shows the finest run that has any, and those at stock timesteps.
        """
        rows = self.rows + self.single_rows + self.above_rows
        shown = min((row.timestep for row in rows if row.motion is not None), default=None)
        return [row.timestep for row in rows if row.timestep != shown and not row.stock]

    def _coming(self) -> _Coming | None:
        single = next(iter(self.singles[len(self.single_rows) :]), None)
        if single is not None:
            return _Coming(single.rung, single.solution, self.single_rows)
        if self.ladder is None:
            return None
        if not self._down:
            return _Coming(self.ladder.rungs[len(self.rows)], self.solution, self.rows)
        if rung := self._next_above():
            return _Coming(rung, thinned(self.solution, rung.every), self.above_rows)
        return self._next_stock()

    def _next_stock(self) -> _Coming | None:
        """The next stock timestep without a run; none if no timestep can succeed."""
        if self._pointless:
            return None
        for run in self.stock:
            if run.rung and run.solution and run.timestep not in self._taken:
                return _Coming(run.rung, run.solution, self.stock_rows)
        return None

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

    def _next_above(self) -> Rung | None:
        """The next doubled timestep, if the one before survived."""
        assert self.ladder is not None, "without a ladder there is nothing above it"
        before = self.above_rows[-1:] or self.rows[:1]
        if before and not before[0].survived:
            return None
        return next(iter(self.ladder.above[len(self.above_rows) :]), None)

    @property
    def _down(self) -> bool:
        """Whether the ladder is finished: no finer rung exists, is needed, or can succeed."""
        assert self.ladder is not None, "only a ladder has an end"
        taken = len(self.rows)
        if taken == len(self.ladder.rungs) or (self.rows and self._hopeless(self.rows[-1])):
            return True
        if self._diverges_at_any_timestep:
            return True
        finest = self.ladder.rungs[-1].timestep
        settled = self.judge.is_known or self.judge.is_out_of_reach(finest)
        return taken >= MIN_RUNGS and settled

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
