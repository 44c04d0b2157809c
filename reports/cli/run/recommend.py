"""What the command `recommend` does: the cheapest method and timestep that stay within bounds.

The runs and their costs come from a result file, as in the report's tables. If the file has none of
the scene, or none of an engine that the user names, the scene is run and timed now. The timestep at
which a method reaches the bounds is interpolated between its runs. The cheapest choice is then
checked by a run at exactly its timestep. If an error of that run exceeds its bound, the run is
added to the others, and the choice is made again.
"""

import math
import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from ....engines import engines
from ....scenarios import SIGNAL, Scenario
from ...harness.choice import Choice, EngineMethod
from ...harness.executors import TIME_LIMIT, LocalWorkers
from ...harness.plan import plan
from ...harness.study import run_study
from ...pages.analysis.best_choice import (
    BOUNDS,
    Candidate,
    ErrorBounds,
    candidates,
    steady,
    to_type,
)
from ...pages.analysis.report_data import SceneRuns, report_data
from ...results.cost_records import MethodCost
from ...results.records import Key, Row
from ...results.results import Results
from ...results.store import open_store
from ..choosing import check_temporary_folder, choose
from ..grouped import option
from ..named_scenes import one_scene
from ..options import RESULT_FILE
from ..stopping import saying
from ..terminal import AGREES, DISAGREES, NOT_RUN, Complaint, say
from . import running

#: Stored results are used if at least one method has this many timed runs.
LEAST_TIMED = 3
#: Number of checks after which the search is given up.
CHECKS = 4


@dataclass(frozen=True, eq=False)
class Recommendation:
    """The method and timestep that are recommended for a scene, and how they were found.

    Attributes
    ----------
    scenario : name of the scene
    bounds : the largest errors allowed, by signal: attitude in rad, others relative
    candidates : every method that may be recommended, the cheapest first; those that cannot reach
        the bounds come last
    checks : runs at exactly a recommended timestep; the last one is of the first candidate
    unchecked : why the choice was not checked; empty if it was checked
    setup : what users write in the first candidate's engine to set its method and timestep; empty
        if the adapter does not state it
    command : the command that runs the first candidate again; empty if nothing is recommended
    nothing : why nothing is recommended; empty if something is
    source : the result file used; empty if the scene was run now
    not_compared : methods of which the result file has no runs, and the command that adds them, in
        words; empty if there are none
    left_in : cost of the first candidate's steps if the engine does all that it does by default;
        None if the adapter leaves nothing of that out, or if it was not timed
    """

    scenario: str
    bounds: ErrorBounds
    candidates: tuple[Candidate, ...]
    checks: tuple[Row, ...]
    unchecked: str = ""
    setup: str = ""
    command: str = ""
    nothing: str = ""
    source: str = ""
    not_compared: str = ""
    left_in: MethodCost | None = None

    @property
    def best(self) -> Candidate | None:
        """The cheapest candidate; None if nothing is recommended."""
        return None if self.nothing else self.candidates[0]

    @property
    def of_other_engines(self) -> list[Candidate]:
        """The cheapest candidate of each engine other than that of `best`.

        Engines that cannot reach the bounds are left out.
        """
        first: dict[str, Candidate] = {}
        for candidate in self.candidates if self.best else ():
            if candidate.timestep is not None:
                first.setdefault(candidate.key.engine, candidate)
        return list(first.values())[1:]

    @property
    def verified(self) -> bool:
        """Whether the errors of the last check are within all bounds; False without a check."""
        return bool(self.checks) and within(self.checks[-1], self.bounds)


def recommend(
    scene: str, bounds: ErrorBounds, engine_names: Sequence[str], jobs: int, stored: Path
) -> Recommendation:
    """Return the cheapest method and timestep on a scene, checked by a run.

    Engines as shipped are not considered.

    Parameters
    ----------
    scene : a file, or the name of a library scene
    bounds : the largest errors allowed, by signal: attitude in rad, others relative; `BOUNDS` if
        empty
    engine_names : the engines to choose from; if empty, all that are not optional
    jobs : number of worker processes
    stored : a result file, from which runs are taken; if it has no timed runs of the scene, or no
        runs of a named engine, the scene's ladders are run

    Raises
    ------
    Complaint
        If a name or bound cannot be used, if the engines have no method that may be recommended, or
        if nothing could be run.
    """
    bounds = bounds or BOUNDS
    scenario = one_scene(scene)
    _check_bounds(bounds, scenario)
    offered = _offered(scenario, engine_names)
    check_temporary_folder()
    with saying("nothing is kept"), TemporaryDirectory() as folder:
        if timed_runs := _timed_runs(scene, bounds, engine_names, stored):
            say(f"From the runs in {stored}.")
            found = replace(
                _checked(scene, bounds, timed_runs, Path(folder)),
                source=str(stored),
                not_compared=_not_compared(scene, offered, engine_names, timed_runs, stored),
            )
            return _as_typed_again(found, engine_names)
        out = Path(folder) / "ladder.sqlite"
        methods = dict.fromkeys(method.name for _, method in offered)
        results = running.run([scene], engine_names, [*methods], [], jobs, out)
        if running.exit_code(results) == NOT_RUN:
            raise Complaint(f"{scene}: nothing could be run: {results.rows[0].reason}", NOT_RUN)
        return _as_typed_again(_checked(scene, bounds, results, Path(folder)), engine_names)


def within(row: Row, bounds: ErrorBounds) -> bool:
    """Return whether the errors of a run are known and within all bounds.

    Parameters
    ----------
    bounds : the largest errors allowed, by signal: attitude in rad, others relative
    """
    if row.errors is None:
        return False
    return all(row.errors[signal] <= bound for signal, bound in bounds.items())


def exit_code(recommendation: Recommendation) -> int:
    """Return 0 if the recommended run was checked and keeps every bound, else 1."""
    return AGREES if recommendation.verified else DISAGREES


def _check_bounds(bounds: ErrorBounds, scenario: Scenario) -> None:
    """Raise a `Complaint` for a bound that is not positive, not finite, or of an absent signal."""
    for signal, bound in bounds.items():
        if not 0 < bound < math.inf:
            raise Complaint(f"'{option(signal)}' must be positive, got {bound:g}")
        if not SIGNAL[signal].exists(scenario):
            raise Complaint(f"'{option(signal)}': {scenario.name} has no {SIGNAL[signal].quantity}")


def _offered(scenario: Scenario, engine_names: Sequence[str]) -> list[EngineMethod]:
    """Return every engine with each of its methods that may be recommended for a scene.

    A `Complaint` is raised if there are none.

    Parameters
    ----------
    engine_names : the engines whose methods are returned; if empty, all that are not optional
    """
    chosen = choose(engine_names, [], []).engines
    made_for_it = ((one, method) for one in chosen for method in one.methods_for(scenario))
    offered = [(one, method) for one, method in made_for_it if method.is_recommendable]
    if not offered:
        raise Complaint(
            f"{', '.join(engine_names)}: has no method that is recommended: those as shipped are "
            "not, nor readers of users' models, such as mujoco-file",
            NOT_RUN,
        )
    return offered


def _able(scenario: Scenario, offered: Sequence[EngineMethod]) -> list[Key]:
    """Return the keys of those of some methods that can simulate a scene."""
    return [
        Key(scenario.name, engine.name, method.name)
        for engine, method in offered
        if not engine.unsupported(scenario, method)
    ]


def _not_compared(
    scene: str,
    offered: Sequence[EngineMethod],
    engine_names: Sequence[str],
    results: Results,
    stored: Path,
) -> str:
    """Return in words which methods a result file has no runs of, and the command that adds them.

    The text is empty if there are none.

    Parameters
    ----------
    scene, engine_names : the scene and the engines as the user typed them
    offered : the methods that may be recommended
    results : the scene's runs that are used of the file
    stored : the file
    """
    there = {row.key for row in results.rows}
    able = _able(one_scene(scene), offered)
    labels = [key.label for key in able if key not in there]
    words = ["spincheck", "run", scene]
    words += [word for name in engine_names for word in ("--engine", name)]
    words += [] if stored == RESULT_FILE else ["--out", str(stored)]
    return f"{', '.join(labels)}; '{shlex.join(words)}' adds them" if labels else ""


def _timed_runs(
    scene: str, bounds: ErrorBounds, engine_names: Sequence[str], stored: Path
) -> Results | None:
    """Return a scene's stored results, of engines whose installed version is the stored one.

    None is returned if there is no file, if the file lacks the scene or has another version of the
    scene, if no method has `LEAST_TIMED` timed runs, if there is no run of a named engine that has
    methods for the scene, or if errors in a signal with a bound are not stored. Files of older
    versions lack errors of spins.

    Parameters
    ----------
    bounds : the largest errors allowed, by signal
    engine_names : the engines to choose from; all that are installed if empty
    stored : the file
    """
    if not stored.exists():
        return None
    scenario, results = one_scene(scene), running.contents(stored)
    solved = results.scenes.get(scenario.name)
    if solved is None or solved.scenario.digest != scenario.digest:
        return None
    chosen = choose(engine_names or ["all"], [], [], scenarios=[scenario]).engines
    versions = {engine.name: engine.version for engine in chosen}
    rows = [
        row
        for row in results.rows
        if row.key.scenario == scenario.name and versions.get(row.key.engine) == row.engine_version
    ]
    timed = Counter(row.key for row in rows if row.seconds_per_step)
    if max(timed.values(), default=0) < LEAST_TIMED:
        return None
    known = [solved.solution.uncertainty, *(row.errors for row in rows if row.errors)]
    if any(math.isnan(one[signal]) for one in known for signal in bounds):
        return None
    keys = {row.key for row in rows}
    able = _able(scenario, _offered(scenario, engine_names)) if engine_names else []
    if {key.engine for key in able} - {key.engine for key in able if key in keys}:
        return None
    return replace(
        results,
        scenes={scenario.name: solved},
        rows=rows,
        verdicts=[verdict for verdict in results.verdicts if verdict.key in keys],
    )


def _checked(scene: str, bounds: ErrorBounds, results: Results, folder: Path) -> Recommendation:
    """Recommend the cheapest candidate, checked by a run; if the check fails, choose again.

    The search ends when the errors of a check are within the bounds, when a check would take too
    long and is left out, when no method reaches the bounds, or after `CHECKS` checks. Nothing is
    recommended on a motion so simple that bad methods, too, follow it (`steady`).

    Parameters
    ----------
    scene : the scene as the user typed it
    bounds : the largest errors allowed, by signal: attitude in rad, others relative
    results : runs of the scene, between which the candidates' timesteps are interpolated
    folder : where the result files of the checks are written
    """
    checks: list[Row] = []
    while True:
        (tried,) = report_data(results).scenes
        ranked = tuple(map(_as_typed, candidates(tried, bounds)))
        best = ranked[0]
        nothing = steady(tried.solved, bounds) if tried.solved else "it could not be solved"
        if best.timestep is None:
            nothing = nothing or "no method reaches the bounds"
        if nothing or best.timestep is None or tried.solved is None:
            return Recommendation(tried.name, bounds, ranked, tuple(checks), nothing=nothing)
        unchecked = _too_long(best, float(tried.solved.solution.trajectory.t[-1]))
        if not unchecked:
            out = folder / f"check-{len(checks)}.sqlite"
            checks.append(_run_again(tried.solved.scenario, best.key, best.timestep, out))
        if unchecked or within(checks[-1], bounds) or len(checks) == CHECKS:
            setup, command = _setup(tried, best), _command(scene, best)
            named = (tried.name, bounds, ranked, tuple(checks), unchecked, setup, command)
            return Recommendation(*named, left_in=_left_in(results, best.key))
        results = _with_run(results, checks[-1])


def _as_typed(candidate: Candidate) -> Candidate:
    """Return a candidate with its timestep rounded down to two digits, and the cost at that."""
    if candidate.timestep is None or candidate.cost is None:
        return candidate
    timestep = to_type(candidate.timestep, candidate.finest_useful)
    cost = candidate.cost * candidate.timestep / timestep
    return replace(candidate, timestep=timestep, cost=cost)


def _left_in(results: Results, key: Key) -> MethodCost | None:
    """Return the cost of a method's steps with all passes that the adapter otherwise leaves out.

    None is returned if it was not measured, or if the adapter leaves nothing out.
    """
    whole = (one for one in results.costs if one.key == key and one.left_in)
    return next((one for one in whole if one.cost and one.cost.ratio), None)


def _setup(scene: SceneRuns, best: Candidate) -> str:
    """Return what users write in an engine to set a candidate's method and timestep.

    The text is empty if the adapter does not state it.

    Parameters
    ----------
    best : a candidate with a timestep
    """
    assert best.timestep is not None, "only what reaches the bounds is recommended"
    return scene.by_pair[best.key.pair].setup(best.timestep)


def _too_long(best: Candidate, duration: float) -> str:
    """Return why a candidate's run is too long for a check; empty if it is not.

    It is too long if it would take more than `TIME_LIMIT`.

    Parameters
    ----------
    best : the candidate
    duration : the simulated time of the run, s
    """
    seconds = (best.cost or 0.0) * duration
    if seconds <= TIME_LIMIT:
        return ""
    return f"it would take {seconds:.0f} s, and a run may take {TIME_LIMIT:.0f} s"


def _run_again(scenario: Scenario, key: Key, timestep: float, out: Path) -> Row:
    """Run a method at exactly the given timestep, s, into a new result file, and return the run."""
    say(f"Checking {key.label} at {timestep!r} s.")
    choice = Choice((engines()[key.engine],), (key.method,), (timestep,))
    with open_store(out, create=True) as store:
        with LocalWorkers(1) as executor:
            left = plan([scenario], choice, store)
            run_study(left, choice, store, executor, lambda _: None)
        return next(row for row in store.read().rows if row.timestep == timestep)


def _with_run(results: Results, run: Row) -> Results:
    """Return the results with another run, in place of any of that method at the same timestep.

    As the run was not timed, the cost of a step is taken from another run of the method.
    """
    alike = next(row for row in reversed(results.rows) if row.key == run.key)
    priced = replace(
        run,
        seconds_per_step=alike.seconds_per_step,
        seconds_spread=alike.seconds_spread,
        wall_seconds_per_step=alike.wall_seconds_per_step,
    )
    by_timestep = {(row.key, row.timestep): row for row in (*results.rows, priced)}
    return replace(results, rows=list(by_timestep.values()))


def _as_typed_again(recommendation: Recommendation, engine_names: Sequence[str]) -> Recommendation:
    """Return a recommendation whose command names a user's own engine as `engine_names` does.

    The user has typed it as 'MODULE:CLASS' or 'child:COMMAND'; its name alone would not be found.
    """
    words = shlex.split(recommendation.command)
    if not words:
        return recommendation
    own = (name for name in engine_names if ":" in name)
    typed = {one.name: name for name in own for one in choose([name], [], []).engines}
    at = words.index("--engine") + 1
    words[at] = typed.get(words[at], words[at])
    return replace(recommendation, command=shlex.join(words))


def _command(scene: str, best: Candidate) -> str:
    """Return the command that runs a candidate again, into a result file of its own.

    `scene` is the scene as the user typed it.
    """
    parts = ["spincheck", "run", scene, "--engine", best.key.engine, "--method", best.key.method]
    # Results go to another file, as a run of a scene replaces what a file has of that scene.
    parts += ["--timestep", repr(best.timestep), "--out", "recommended.sqlite", "--json"]
    return shlex.join(parts)
