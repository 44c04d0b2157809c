"""What the command `run` does, and how its results are read back."""

from collections.abc import Sequence
from pathlib import Path

from ..engines import Engine, engines, missing
from ..scenarios import Scenario, ScenarioError, find, load
from .store import ResultFileError, Results, open_store
from .study import Choice, run_study
from .terminal import AGREES, BAD_INPUT, DISAGREES, NOT_RUN, Complaint, progress


def run(
    scenes: Sequence[str],
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    jobs: int,
    out: Path,
) -> Results:
    """Run what was named (nothing named: everything) and read back what was stored.

    Raises
    ------
    Complaint
        If a scene, engine, method or timestep cannot be used, or the file cannot be written.
    """
    scenarios = _load(scenes)
    choice = _choice(engine_names, methods, timesteps)
    _check_timesteps(scenarios, choice)
    try:
        with open_store(out, create=True) as store:
            with progress(len(scenarios) * (len(choice.pairs()) + 1)) as advance:
                run_study(scenarios, choice, store, jobs, advance)
            return store.read()
    except ResultFileError as error:
        raise Complaint(str(error), BAD_INPUT) from None


def read(path: Path) -> Results:
    """Everything in a result file.

    Raises
    ------
    Complaint
        If it cannot be read or is empty.
    """
    try:
        with open_store(path) as store:
            results = store.read()
    except ResultFileError as error:
        raise Complaint(str(error), BAD_INPUT) from None
    if not results.verdicts:
        raise Complaint(f"{path}: holds no results; 'spincheck run' fills it", BAD_INPUT)
    return results


def exit_code(results: Results) -> int:
    """0 if everything agrees, 1 if something does not, 3 if nothing could be run."""
    if all(row.outcome == "failed" for row in results.rows):
        return NOT_RUN
    return AGREES if all(verdict.agrees for verdict in results.verdicts) else DISAGREES


def _load(names: Sequence[str]) -> list[Scenario]:
    try:
        return [load(path) for path in find(names)]
    except ScenarioError as error:
        raise Complaint(str(error), BAD_INPUT) from None


def _choice(
    engine_names: Sequence[str], methods: Sequence[str], timesteps: Sequence[float]
) -> Choice:
    chosen = tuple(_engine(name) for name in dict.fromkeys(engine_names or engines()))
    if not chosen:
        raise Complaint("no engine is installed; 'pip install mujoco pybullet'", NOT_RUN)
    known = {method.name for engine in chosen for method in engine.methods}
    for name in methods:
        if name not in known:
            raise Complaint(
                f"'--method' must be one of {', '.join(sorted(known))}, got '{name}'", BAD_INPUT
            )
    for timestep in timesteps:
        if not 0 < timestep < float("inf"):
            raise Complaint(f"'--timestep' must be positive, got {timestep:g} s", BAD_INPUT)
    return Choice(chosen, tuple(methods), tuple(timesteps))


def _engine(name: str) -> Engine:
    if name in engines():
        return engines()[name]
    for absent in missing():
        if absent.name == name:
            raise Complaint(
                f"engine '{name}' needs the package '{absent.package}', which is not installed",
                NOT_RUN,
            )
    raise Complaint(f"'--engine' must be one of {', '.join(engines())}, got '{name}'", BAD_INPUT)


def _check_timesteps(scenarios: Sequence[Scenario], choice: Choice) -> None:
    for scenario in scenarios:
        for timestep in choice.timesteps:
            if timestep > scenario.window.duration:
                raise Complaint(
                    f"'--timestep' must be shorter than the window of {scenario.name}, "
                    f"{scenario.window.duration:g} s, got {timestep:g} s",
                    BAD_INPUT,
                )
