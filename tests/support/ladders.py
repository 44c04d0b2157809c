"""Made-up ladders of one scene whose errors follow a law of the timestep."""

from collections.abc import Callable
from dataclasses import replace

from made_up import TIMESTEPS, MadeUp, results
from spincheck.reports.pages.analysis.best_choice import Candidate, candidates
from spincheck.reports.pages.analysis.report_data import SceneRuns, report_data
from spincheck.reports.pages.analysis.work_precision import EPS
from spincheck.reports.results.results import Results
from spincheck.scenarios import Errors

TOP = "made-up-top"
ALONE = (MadeUp("mujoco", "Euler", 1), MadeUp("mujoco", "RK4", 4))
#: Of ω; between two rungs of a first-order method, and below its finest.
BETWEEN, BELOW = 1e-3, 1e-5
#: Quotients of times and powers of them.
ROUNDING = 64 * EPS

Law = Callable[[float], float]


def only(stored: Results, name: str = TOP) -> Results:
    """The results of one scene, as a study of it alone would store them."""
    return replace(
        stored,
        scenes={name: stored.scenes[name]},
        rows=[row for row in stored.rows if row.key.scenario == name],
        verdicts=[verdict for verdict in stored.verdicts if verdict.key.scenario == name],
    )


def with_law(law: Law, method: str = "Euler") -> Results:
    """The same, with the errors of one method in ω and attitude by a law of the timestep."""
    stored = only(results(methods=ALONE))
    rows = [
        replace(row, errors=errors_of(law, row.timestep)) if row.key.method == method else row
        for row in stored.rows
    ]
    return replace(stored, rows=rows)


def errors_of(law: Law, timestep: float) -> Errors:
    return Errors(*[law(timestep)] * 6)


def scene_of(stored: Results) -> SceneRuns:
    (scene,) = report_data(stored).scenes
    return scene


def chosen(stored: Results, method: str, **bounds: float) -> Candidate:
    tried = candidates(scene_of(stored), bounds)
    return next(candidate for candidate in tried if candidate.key.method == method)


def straight(timestep: float) -> float:
    return 0.1 * timestep / TIMESTEPS[0]


def bending_up(timestep: float) -> float:
    """Steeper at coarse timesteps."""
    return straight(timestep) * (1 + timestep / TIMESTEPS[0])


def bending_down(timestep: float) -> float:
    """Flatter at coarse timesteps, as errors that saturate are."""
    return straight(timestep) / (1 + timestep / TIMESTEPS[0])
