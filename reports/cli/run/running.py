"""The command `run`: what it does, and how its results are read back."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ....scenarios import Scenario, did_you_mean, printable
from ...harness.choice import Choice
from ...harness.plan import Plan, plan
from ...harness.scene_checks.published import published_that_do_not_hold
from ...harness.study import run_study
from ...harness.timesteps.ladder import QUICK_STEPS
from ...pages.analysis.wording import plural
from ...results.records import UNSOLVED, Key, Row
from ...results.result_file import ResultFileError
from ...results.results import Results
from ...results.store import open_store
from ...results.verdict_words import UNPROVEN
from ..choosing import (
    check_timesteps,
    choose,
    executor_for,
    say_if_compiling,
)
from ..named_scenes import scenes_to_run
from ..stopping import saying
from ..terminal import (
    AGREES,
    DISAGREES,
    NOT_RUN,
    Complaint,
    as_complaint,
    progress,
    say,
)
from .encodings import encoded


def announcement(left: Plan) -> str:
    """Return, in words, how many verdicts a plan will make, and on which engines.

    The number of scenes to be timed is added, if any. The text is empty if the plan will make at
    most one verdict.
    """
    pairs = [pair for scene in left.scenes for pair in scene.to_run]
    if len(pairs) < 2:
        return ""
    names = dict.fromkeys(engine.name for engine, _ in pairs)
    timed = left.total - len(pairs)
    to_time = f", and {plural(timed, 'scene')} to be timed" if timed else ""
    return (
        f"{plural(len(pairs), 'verdict')} of {plural(len(names), 'engine')} ({', '.join(names)}) "
        f"on {plural(len(left.scenes), 'scene')}{to_time}"
    ) + ("; --engine names fewer" if len(names) > 2 else "")


def run(
    scenes: Sequence[str],
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    jobs: int,
    out: Path,
    *,
    quick: bool = False,
    time_limit: float | None = None,
    again: bool = False,
    python: str = "",
    encodings: Sequence[str] = (),
) -> Results:
    """Run methods on scenes, add the results to a result file, and return them.

    Progress is printed on stderr.

    Parameters
    ----------
    scenes : files, folders or names of library scenes; if empty, the library, in which hard scenes
        have short ladders, or are left out if the run is quick
    engine_names : names of engines; if empty, all that are not optional
    methods : names of methods; if empty, all that the engines offer for a scene
    timesteps : s; ladders of halved timesteps if empty
    jobs : number of worker processes
    out : the result file; what it holds already is not run again
    quick : whether ladders are short and nothing is timed
    time_limit : CPU time that a run may take, s; the default if None
    again : whether to run also what the result file holds already
    python : the command of the interpreter that other versions of engines run under; the
        interpreter of this process if empty
    encodings : names of encodings in which bodies are run as well

    Raises
    ------
    Complaint
        If a name, a number or the result file cannot be used.
    """
    scenarios = scenes_of(scenes, quick=quick)
    choice = choose(
        engine_names,
        methods,
        timesteps,
        scenarios=scenarios,
        python=python,
        time_limit=time_limit,
    )
    check_all_apply(choice, scenarios)
    others = encoded(choice.engines, encodings, scenarios)
    choice = replace(choice, engines=(*choice.engines, *others))
    choice = replace(choice, hard_in_passing=not scenes, again=again)
    if quick:
        choice = replace(choice, max_steps=QUICK_STEPS, timed=False)
    check_timesteps(scenarios, choice)
    with (
        as_complaint(ResultFileError),
        saying(gone_on_with(out)),
        open_store(out, create=True) as store,
    ):
        left = plan(scenarios, choice, store)
        if str(left):
            say(f"{out}: {left}")
        if words := announcement(left):
            say(words)
        if left.scenes:
            say_if_compiling()
        with (
            executor_for(jobs, choice) as executor,
            progress(left.total) as advance,
        ):
            run_study(left, choice, store, executor, advance)
        return _asked_for(store.read(choice.timesteps), scenarios, choice)


def gone_on_with(out: Path) -> str:
    """Return the message printed if a run is stopped: where its results are, how to continue."""
    return f"finished results are in {printable(str(out))}; the same command continues from there"


def check_all_apply(choice: Choice, scenarios: Sequence[Scenario]) -> None:
    """Raise a `Complaint` if an engine loads users' model files and no scene names such a file."""
    for engine in choice.engines:
        if not any(engine.applies_to(scenario) for scenario in scenarios):
            raise Complaint(
                f"'--engine' {engine.name} loads links of users' files, and no scene here names "
                "one; 'spincheck import FILE --out DIR' makes such scenes"
            )


def scenes_of(names: Sequence[str], *, quick: bool) -> list[Scenario]:
    """Return the scenes named or, without names, the library, less its hard scenes if `quick`."""
    scenarios = scenes_to_run(names)
    return [scenario for scenario in scenarios if names or not (quick and scenario.hard)]


def _asked_for(results: Results, scenarios: Sequence[Scenario], choice: Choice) -> Results:
    """Return the results of the chosen scenes, methods and timesteps, out of all in a file.

    If timesteps were chosen, two other kinds of rows are kept, too: runs at timesteps of the
    scene's expectations, and rows which say that a scene could not be solved.
    """
    pairs = [(engine.name, method.name) for engine, method in choice.pairs()]
    scenes = {scenario.name: scenario for scenario in scenarios}

    def named(key: Key) -> bool:
        return key.scenario in scenes and key.pair in pairs

    def at_asked_timestep(row: Row) -> bool:
        expected = {expect.timestep for expect in scenes[row.key.scenario].expect}
        return not choice.timesteps or row.timestep in {UNSOLVED, *choice.timesteps, *expected}

    return replace(
        results,
        scenes={name: scene for name, scene in results.scenes.items() if name in scenes},
        rows=[row for row in results.rows if named(row.key) and at_asked_timestep(row)],
        verdicts=[verdict for verdict in results.verdicts if named(verdict.key)],
    )


def contents(path: Path) -> Results:
    """Return what a result file holds, which may be nothing, as after a run that was stopped.

    A warning is printed if SQLite's log file is missing. A `Complaint` is raised if the
    file cannot be read.
    """
    with as_complaint(ResultFileError), open_store(path) as store:
        if store.log_missing:
            say(
                f"{path}: it was copied, or the disk was full, while it was being written, and its "
                f"log '{path.name}-wal' is not beside it: the last runs may be missing"
            )
        return store.read()


def read(path: Path, scene: str = "") -> Results:
    """Return what a result file holds, as `contents` does.

    Parameters
    ----------
    path : the result file
    scene : name of the scene whose results are returned; empty for all scenes

    Raises
    ------
    Complaint
        If the file cannot be read, or holds no results or none of the scene.
    """
    results = contents(path)
    if not (results.verdicts or results.ensembles):
        raise Complaint(f"{path}: holds no results; 'spincheck run' fills it")
    if not scene:
        return results
    swept = (one.scenario.name for one in results.ensembles)
    names = {*results.scenes, *(row.key.scenario for row in results.rows), *swept}
    if scene not in names:
        raise Complaint(
            f"{path}: holds no results of '{scene}', which 'spincheck run' makes"
            f"{did_you_mean(scene, names)}"
        )
    return results.of(scene)


def tidied(path: Path) -> str:
    """Delete results that no longer count from a result file; return in words what was freed.

    Results do not count if their scene, the program or their engine has changed since. A
    `Complaint` is raised if the file cannot be used.
    """
    with as_complaint(ResultFileError):
        with open_store(path):
            before = path.stat().st_size
        with open_store(path, create=True) as store:
            deleted = store.tidy()
    return f"{deleted} records deleted, {(before - path.stat().st_size) / 1e6:.1f} MB freed"


def tell_untrue(results: Results) -> None:
    """Raise a `Complaint` if a scene's published values are not those of its exact motion."""
    scenarios = [scene.scenario for scene in results.scenes.values()]
    untrue = [line for scenario in scenarios for line in published_that_do_not_hold(scenario)]
    if untrue:
        raise Complaint("\n".join(untrue), DISAGREES)


def say_where_motions_end(results: Results) -> None:
    """Print a warning for each scene whose exact motion is not known up to its window's end."""
    for name, scene in results.scenes.items():
        if too_long := scene.solution.ends_before(scene.scenario.window.duration):
            say(f"{name}: {too_long}")


def unproven_in_words(results: Results) -> str:
    """Return in words how many verdicts are 'unresolved' or 'diverges'; empty if none is.

    Verdicts on methods as shipped, and expected failures, are not counted.
    """
    count = sum(verdict.is_unproven for verdict in results.verdicts)
    if not count:
        return ""
    return (
        f"Unproven: {count} of {len(results.verdicts)} verdicts are {UNPROVEN}; "
        "'--strict' makes that exit code 1."
    )


def exit_code(results: Results, *, strict: bool = False) -> int:
    """Return the exit code: 3 if all runs failed, else 1 if a verdict is bad, else 0.

    A verdict is bad if it makes a study fail, or has an unmet expectation (`Verdict.agrees`).

    Parameters
    ----------
    strict : whether the verdicts 'unresolved' and 'diverges' are bad, too, unless they are on a
        method as shipped or are expected failures
    """
    if results.rows and all(row.outcome == "failed" for row in results.rows):
        return NOT_RUN
    agrees = all(v.agrees and not (strict and v.is_unproven) for v in results.verdicts)
    return AGREES if agrees else DISAGREES
