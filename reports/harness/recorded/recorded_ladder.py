"""Recorded motions at halved timesteps as the ladder of one method, and the verdict on it."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import final

import numpy as np

from ....engines import Engine, EngineError, Method, Run, Session
from ....scenarios import FloatArray, Scenario, Trajectory
from ...results.results import Results, SceneResult
from ..convergence_study import ConvergenceStudy
from ..executors import Answer
from ..judging import judge
from ..ladder import Ladder, Rung
from .judged import JudgedMotion, exact_at
from .recording import RecordingError

#: Two times are the same if they differ by less than this, relative to the last.
SAME_TIME = 1e-9
#: Relative difference from a halved timestep that is one nevertheless.
HALVED = 1e-6


@final
class RecordedEngine(Engine):
    """Stands for whatever made the motions: it has a method, and cannot be run."""

    name = "recorded"

    def __init__(self, order: int, single_precision: bool) -> None:
        self.single_precision = single_precision
        self.methods = (Method("files", order, order, "motions read from files", frozenset()),)

    @property
    def version(self) -> str:
        """None is known."""
        return ""

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:  # noqa: ARG002
        """Raise: there is nothing to open."""
        raise EngineError("recorded motions cannot be run")


def study_of_files(
    scenario: Scenario, motions: Sequence[JudgedMotion], order: int
) -> ConvergenceStudy:
    """Return motions, each made with half the timestep of another, as the runs of one method.

    Parameters
    ----------
    order : of accuracy, that the method has or claims

    Raises
    ------
    RecordingError
        If timesteps are unknown or not halved, or the motions share no sample times.
    """
    by_timestep = sorted(motions, key=lambda one: -_timestep(one))
    timesteps = [_timestep(one) for one in by_timestep]
    for coarse, fine in pairwise(timesteps):
        if not abs(coarse / fine - 2) <= HALVED:
            raise RecordingError(
                f"timesteps must be halved from file to file, got {coarse:g} and {fine:g} s"
            )
    recorded = [one.recorded.trajectory for one in by_timestep]
    times = _shared(recorded)
    solution = exact_at(scenario, times)
    rungs = [Rung(dt, np.rint(times / dt).astype(np.int64)) for dt in timesteps]
    engine = RecordedEngine(order, any(one.is_single for one in motions))
    ladder = Ladder(tuple(rungs), (), times, float(rungs[0].steps))
    study = ConvergenceStudy(scenario, engine, engine.methods[0], solution, ladder)
    _take(study, dict(zip(timesteps, recorded, strict=True)), times)
    return study


def results_of(study: ConvergenceStudy, explained_by: Sequence[str]) -> Results:
    """Return the runs and the verdict as a result file has them, for pages.

    Parameters
    ----------
    explained_by : what explains the motion, in words, if anything does: then it is another one
    """
    verdict = judge(study.records)
    if explained_by:
        reason = "; ".join([*explained_by, verdict.reason])
        verdict = replace(verdict, verdict="disagrees", reason=reason)
    name, pair = study.scenario.name, (study.engine.name, study.method.name)
    # As an engine's defaults are: judged as they are, shown first, recommended to nobody.
    return Results(
        {},
        {name: SceneResult(study.scenario, study.solution)},
        [replace(row, stock=row is study.rows[-1]) for row in study.rows],
        [verdict],
        methods={pair: replace(study.method, as_shipped=True)},
    )


def _take(study: ConvergenceStudy, recorded: dict[float, Trajectory], times: FloatArray) -> None:
    """Answer each run that the study asks for with the motion of its file."""
    runs = study.runs()
    planned = next(runs, None)
    while planned is not None:
        timestep = planned.rung.timestep
        motion = _at(recorded[timestep], times)
        named = (study.engine.name, "", study.method.name, timestep)
        run = Run(*named, "ok", trajectory=motion, steps=planned.rung.steps)
        try:
            planned = runs.send(study.compare(planned, Answer(run)))
        except StopIteration:
            planned = None


def _timestep(motion: JudgedMotion) -> float:
    """The timestep of a file, s; where it states none, the distance of its samples."""
    if motion.timestep is not None:
        return motion.timestep
    distances = np.diff(motion.recorded.trajectory.t)
    if np.ptp(distances) > SAME_TIME * motion.recorded.trajectory.t[-1]:
        raise RecordingError(
            "the timestep of a file with samples at unlike distances must be given: '--timestep', "
            "or a line '# timestep = 0.001' before the columns"
        )
    return float(np.mean(distances))


def _shared(motions: Sequence[Trajectory]) -> FloatArray:
    """The times, s, that all motions are sampled at."""
    times = motions[0].t
    slack = SAME_TIME * float(times[-1])
    for motion in motions[1:]:
        nearest = np.clip(np.searchsorted(motion.t, times - slack), 0, len(motion.t) - 1)
        times = times[np.abs(motion.t[nearest] - times) <= slack]
    if len(times) < 2:
        raise RecordingError("files at halved timesteps must share sample times, these have none")
    return times


def _at(motion: Trajectory, times: FloatArray) -> Trajectory:
    """The samples at these times, which are those of another file."""
    slack = SAME_TIME * float(times[-1])
    return replace(motion.at(np.searchsorted(motion.t, times - slack)), t=times)
