"""One method's way down the ladder of one scene: which rung next, and the verdict at the end."""

from dataclasses import dataclass, field, replace
from typing import Any

from ..engines import Engine, Method, Run
from ..reference import Solution
from ..scenarios import Expect, Scenario
from .compared_run import broken_promises, row_of
from .ladder import MIN_RUNGS, Rung
from .lane import Lost
from .records import Key, Row, Verdict
from .verdict import Judgement, Signal, Step, judge

#: A ladder goes on until its limit is known to this, relative (ω) and in rad, or steps run out.
GOAL = 1e-4
#: Rungs an extrapolated limit with an error estimate takes.
LEAST_RUNGS = 3


@dataclass(frozen=True, eq=False)
class Single:
    """One timestep by itself: asked for by a user, or promised about by the scene."""

    rung: Rung
    solution: Solution
    promises: tuple[Expect, ...] = ()


@dataclass(eq=False)
class Descent:
    """A scene, an engine and a method; first the single timesteps, then the ladder.

    Attributes
    ----------
    solution, rungs : the ladder, coarse to fine, and the truth at its sample times
    rows, single_rows : what was found so far
    broken : promises of the scene that were not kept, in words
    """

    scenario: Scenario
    engine: Engine
    method: Method
    solution: Solution
    rungs: list[Rung]
    singles: list[Single] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    single_rows: list[Row] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    _judged: dict[int, tuple[Signal, Judgement]] = field(default_factory=dict)

    @property
    def key(self) -> Key:
        """Which scene, engine and method."""
        return Key(self.scenario.name, self.engine.name, self.method.name)

    def next_rung(self) -> Rung | None:
        """The rung to run now, or None when enough is known."""
        if len(self.single_rows) < len(self.singles):
            return self.singles[len(self.single_rows)].rung
        taken = len(self.rows)
        if taken == len(self.rungs) or (self.rows and self._hopeless(self.rows[-1])):
            return None
        return None if taken >= MIN_RUNGS and self._known() else self.rungs[taken]

    def add(self, result: Run | Lost, printed: str = "") -> Row:
        """Turn what came back from a worker for the next rung into a row."""
        rung = self.next_rung()
        assert rung is not None
        single = self._next_single()
        solution = single.solution if single else self.solution
        row = row_of(self.scenario, self.key, self.engine.version, rung, result, solution)
        row = replace(row, printed=printed)
        self.take(row)
        return row

    def take(self, row: Row) -> None:
        """Take the row of the next rung, whether it was run just now or is known from before."""
        single = self._next_single()
        if single is None:
            self.rows.append(row)
            return
        self.single_rows.append(row)
        for promise in single.promises:
            self.broken += broken_promises(promise, row)

    def can_take(self, row: Row) -> bool:
        """Whether the row of the next rung is enough: a ladder is judged on motions."""
        return bool(self._next_single() or row.outcome != "ok" or row.motion is not None)

    @property
    def cut_short(self) -> bool:
        """Whether finer rungs, had there been any, would have been run."""
        if not self.rungs or len(self.rows) < len(self.rungs):
            return False
        return not (self._hopeless(self.rows[-1]) or self._known())

    def spent(self) -> list[float]:
        """Timesteps of the runs whose samples nobody wants once there is a verdict: all but one.

        A report shows the finest run that left any.
        """
        rows = self.rows + self.single_rows
        shown = min((row.timestep for row in rows if row.motion is not None), default=None)
        return [row.timestep for row in rows if row.timestep != shown]

    def verdict(self) -> Verdict:
        """Judge the ladder."""
        last = (self.rows or self.single_rows)[-1]
        known: dict[str, Any] = {
            "broken": tuple(self.broken),
            "as_shipped": self.method.as_shipped,
        }
        if last.outcome in ("failed", "diverged", "unsupported"):
            word = "diverges" if last.outcome == "diverged" else last.outcome
            return Verdict(self.key, word, _with_time(last), **known)
        signal, judgement = self._judge()
        return Verdict(
            self.key,
            judgement.word,
            # Of an engine as shipped, what differs from the scene.
            "; ".join(said for said in (judgement.reason, last.reason) if said),
            signal,
            judgement.order,
            judgement.limit_error,
            judgement.limit_estimate,
            **known,
        )

    def _next_single(self) -> Single | None:
        return next(iter(self.singles[len(self.single_rows) :]), None)

    def _hopeless(self, last: Row) -> bool:
        """Whether no finer timestep can help: it failed, or lacks an effect at any timestep."""
        if last.outcome == "unsupported":
            return bool(self.engine.unsupported(self.scenario, self.method))
        return last.outcome == "failed"

    def _known(self) -> bool:
        """Whether every signal is judged and its limit known to the goal."""
        if self.rows[-1].outcome != "ok" or len(self._steps()) < LEAST_RUNGS:
            return False
        _, worst = self._judge()
        known = worst.limit_estimate is None or worst.limit_estimate <= GOAL
        return worst.word != "unresolved" and known

    def _judge(self) -> tuple[Signal, Judgement]:
        """The worse of the judgements on ω and attitude; each set of rows is judged once."""
        taken = len(self.rows)
        if taken not in self._judged:
            self._judged[taken] = self._judge_anew()
        return self._judged[taken]

    def _judge_anew(self) -> tuple[Signal, Judgement]:
        if not self.rungs:
            return "omega", Judgement("unresolved", "no ladder was run, and no limit is known")
        steps = self._steps()
        if not self.rungs:
            return "omega", Judgement("unresolved", "no ladder was run, only single timesteps")
        if len(steps) < LEAST_RUNGS:
            reason = f"only {len(steps)} timesteps ran to the end; {LEAST_RUNGS} make a verdict"
            return "omega", Judgement("unresolved", reason)
        uncertainty = self.solution.uncertainty
        truth = self.solution.trajectory
        orders = {"omega": self.method.order, "attitude": self.method.attitude_order}
        judged: list[tuple[Signal, Judgement]] = [
            (signal, judge(signal, steps, truth, orders[signal], getattr(uncertainty, signal)))
            for signal in ("omega", "attitude")
        ]
        severity = ("converges", "unresolved", "disagrees")
        return max(judged, key=lambda pair: severity.index(pair[1].word))

    def _steps(self) -> list[Step]:
        """The finished rungs below the last that did not finish."""
        finished: list[Step] = []
        for row in self.rows:
            if row.outcome != "ok" or row.motion is None:
                finished.clear()
                continue
            round_off = self._round_off(row.steps)
            finished.append(Step(row.timestep, row.steps, row.motion, round_off))
        return finished

    def _round_off(self, steps: int) -> dict[Signal, float]:
        """What rounding may do: each step is good for one ulp, grown as the motion grows it."""
        conditioning = self.solution.conditioning
        return {"omega": steps * conditioning.omega, "attitude": steps * conditioning.attitude}


def _with_time(row: Row) -> str:
    when = f" at {row.stopped_at:.4g} s" if row.stopped_at is not None else ""
    return f"{row.reason}{when}, with a timestep of {row.timestep:.3g} s"
