"""The exact motion of a scene at the sample times of all runs, solved once for all its methods."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from threading import Lock

from ...reference import ExactMotion, Solution
from ...scenarios import Scenario
from ...scenarios.fastest_rate import fastest_rate
from ..results.store import Store
from .choice import Choice
from .executors import CallFailed, Executor
from .measuring.places import Places, places
from .timesteps.ladder import Ladder, Rung, ladder, single
from .timesteps.stock import StockRun, stock_rung, stock_timesteps


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scene's exact motion at the samples of its ladder, single timesteps and stock timesteps.

    Attributes
    ----------
    solution : the exact motion at the ladder's sample times
    singles : for each timestep that a user or an expectation names, the rung with its samples, and
        the exact motion at these
    stock : the runs at stock timesteps, and the reasons why some of them are not made
    places : exact states from which single steps are tested, and the timesteps of these steps; None
        if single steps are not tested
    """

    solution: Solution
    ladder: Ladder
    singles: list[tuple[Rung, Solution]]
    stock: list[StockRun] = field(default_factory=list)
    places: Places | None = None

    def for_verdicts(self) -> "Prepared":
        """Return a copy without the timesteps longer than all rungs, as only reports need these."""
        return replace(self, ladder=replace(self.ladder, above=()))


class SceneReference:
    """A scene's exact motion, shared by all methods, and solved when the first of them needs it."""

    def __init__(self, scenario: Scenario, choice: Choice) -> None:
        self._scenario, self._choice = scenario, choice
        self._solving = Lock()
        self._solved: Prepared | CallFailed | None = None

    def get(self, executor: Executor, store: Store) -> Prepared | CallFailed:
        """Return the exact motion; or the failure, if it cannot be found.

        The first call solves it, and stores it if it is found. Later calls return the same motion
        or failure.
        """
        with self._solving:
            if self._solved is None:
                self._solved = self._solve(executor)
                if isinstance(self._solved, Prepared):
                    store.put_scene(self._scenario, self._solved.solution)
            return self._solved

    def _solve(self, executor: Executor) -> Prepared | CallFailed:
        """Return the exact motion at the samples of all chosen runs, or why it cannot be found.

        The executor calls `prepare`, which solves it.
        """
        scenario, choice = self._scenario, self._choice
        timesteps = {*choice.timesteps, *(expected.timestep for expected in scenario.expect)}
        stock = {dt for engine in choice.engines for dt in stock_timesteps(engine)}
        return executor.call(
            prepare,
            scenario,
            sorted(timesteps),
            choice.max_steps_on(scenario),
            () if choice.timesteps else sorted(stock),
        ).value


def prepare(
    scenario: Scenario, timesteps: Sequence[float], max_steps: int, stock: Sequence[float] = ()
) -> Prepared:
    """Return the timesteps and samples of all runs on a scene, and its exact motion at the samples.

    If the exact motion ends at a horizon, the runs end there, too.

    Parameters
    ----------
    timesteps : timesteps, s, that a user or an expectation names
    max_steps : largest number of steps of a run of the ladder
    stock : stock timesteps, s

    Raises
    ------
    ValueError
        If one of `timesteps` is at least twice the window, or so short that a run would take more
        than `MOST_STEPS` steps.
    IntegrationError
        If the exact motion cannot be found, or is not known beyond its start.
    """
    exact = ExactMotion(scenario)
    outline = exact.outline(scenario.times)
    if len(outline.t) < 2:
        exact.solve(scenario.times).require_more_than_the_start()
    rate = fastest_rate(scenario, outline.omega_body)
    rungs = ladder(scenario.window, rate, len(outline.t), max_steps)
    at_stock = {timestep: stock_rung(outline.t, timestep, rate) for timestep in stock}
    made = [single(timestep, outline.t) for timestep in timesteps]
    made += [rung for rung in at_stock.values() if isinstance(rung, Rung)]
    # All times are solved for at once: the cost hardly depends on their number.
    solution, *solutions = exact.solve_each([rungs.times, *(rung.times for rung in made)])
    runs = {
        rung.timestep: (rung.until(len(part.trajectory.t)), part)
        for rung, part in zip(made, solutions, strict=True)
    }
    ladder_rungs = rungs.until(len(solution.trajectory.t))
    coarsest = ladder_rungs.rungs[0].timestep if ladder_rungs.rungs else None
    return Prepared(
        solution,
        ladder_rungs,
        [runs[timestep] for timestep in timesteps],
        [
            StockRun(timestep, refusal=rung)
            if isinstance(rung, str)
            else StockRun(timestep, *runs[timestep])
            for timestep, rung in at_stock.items()
        ],
        places(scenario, outline, coarsest),
    )
