"""Judges recorded motions whose timesteps are halved from file to file as the ladder of one method.

The gains of each file from sample to sample are judged by the same model as the gains of single
steps. Files cannot show whether the method has memory.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import final

import numpy as np

from ....engines import Engine, EngineError, Method, Run, Session
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray, Scenario, Trajectory, error_series
from ...results.evidence import StepEvidence
from ...results.results import Results, SceneResult
from ...results.verdicts import Verdict
from ..convergence_study import ConvergenceStudy
from ..executors import Answer
from ..judging import judge
from ..measuring.look import Look
from ..measuring.noise import NOISE, noise_of, noise_of_steps
from ..measuring.places import Places, states_of
from ..measuring.step_evidence import evidence_of
from ..measuring.steps import Steps, flowed, step_gains
from ..timesteps.ladder import Ladder, Rung
from .files.exact_at import exact_at
from .files.recording import RecordingError
from .judged import JudgedMotion

#: Two times are the same if they differ by less than this, relative to the last time.
SAME_TIME = 1e-9
#: Largest error of the attitude, rad, at which intervals are judged. With larger errors the files'
#: intervals start from different states, and gains do not depend on the timestep alone.
TOGETHER = 0.1
#: Largest number of intervals that are judged. Least number of files: gains at the shortest
#: timestep are predicted from those at two or more longer ones.
MOST_INTERVALS, FEWEST_FILES = 64, 3
#: Tolerance of the ratio of successive timesteps, which must be 2.
HALVED = 1e-6


@final
class RecordedEngine(Engine):
    """The unknown engine that computed the files, which has one method and cannot be run.

    Parameters
    ----------
    order : order of accuracy that the method has or claims
    single_precision : whether the engine computes in single precision
    """

    name = "recorded"

    def __init__(self, order: int, single_precision: bool) -> None:
        self.single_precision = single_precision
        self.methods = (Method("files", order, order, "motions read from files", frozenset()),)

    @property
    def version(self) -> str:
        """The version of the engine: an empty string, as it is unknown."""
        return ""

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:  # noqa: ARG002
        """Raise `EngineError`, as there is nothing to open; no parameter is used."""
        raise EngineError("recorded motions cannot be run")


def study_of_files(
    scenario: Scenario, motions: Sequence[JudgedMotion], order: int
) -> ConvergenceStudy:
    """Return the convergence study whose runs are recorded motions at halved timesteps.

    The motions are compared at the sample times that all of them share.

    Parameters
    ----------
    motions : the motions, in any order; the timestep of each is half the next longer one
    order : order of accuracy that the method has or claims

    Raises
    ------
    RecordingError
        If a timestep is unknown, if timesteps are not halved, if the motions share fewer than two
        sample times, or if the exact motion is not known at all of these.
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
    at_times = [_at(motion, times) for motion in recorded]
    study = ConvergenceStudy(scenario, engine, engine.methods[0], solution, ladder)
    resolution = max(one.resolution for one in by_timestep)
    study.steps = _steps(study, np.array(timesteps), at_times, resolution)
    _answer_runs(study, dict(zip(timesteps, at_times, strict=True)))
    return study


def _steps(
    study: ConvergenceStudy,
    timesteps: FloatArray,
    motions: Sequence[Trajectory],
    resolution: float,
) -> StepEvidence | None:
    """Return the evidence of the gains from sample to sample, while errors are small.

    An interval between samples is used only if it ends before the attitude of the motion with the
    longest timestep is off the exact one by more than `TOGETHER`.

    Parameters
    ----------
    study : the convergence study of the files, which has the exact motion at the same times
    timesteps : timesteps of J files, s, from the longest to the shortest, (J,)
    motions : motions of the files, in the order of `timesteps`, all at the same times
    resolution : relative resolution of the numbers in the files

    Returns
    -------
    The evidence; None if there are fewer than `FEWEST_FILES` files, or if no interval can be used
    """
    scenario, exact = study.scenario, study.solution.trajectory
    beyond = error_series(scenario, motions[0], exact).first_beyond("attitude", TOGETHER)
    last = len(exact.t) - 1 if beyond is None else beyond - 1
    if len(motions) < FEWEST_FILES or last < 1:
        return None
    kept = np.unique(np.linspace(0, last - 1, MOST_INTERVALS).astype(int))
    before, after = (stacked([states_of(one.at(at)) for one in motions]) for at in (kept, kept + 1))
    spans = np.tile(np.diff(exact.t)[kept], len(motions))
    steps = Steps(timesteps, spans, before, after, flowed(scenario, before, spans))
    equations, condition = Equations(scenario), float(np.linalg.cond(scenario.inertia))
    of_engine = noise_of(equations, steps, study.engine, condition, settled=False)
    sqrt_steps = np.sqrt(spans.reshape(len(motions), -1) / timesteps[:, None])[..., None]
    of_files = noise_of_steps(equations, steps) * (sqrt_steps + resolution / NOISE)
    look = Look(
        equations,
        steps,
        step_gains(equations, steps)[:, 0],
        np.hypot(of_engine, of_files),
        0,
        study.engine.single_precision,
        is_pooled=False,
    )
    at = Places(before.rows(slice(len(kept))), exact.t[kept], timesteps, condition)
    return evidence_of(look, at, study.method.order, explains=True)


def verdict_on_files(study: ConvergenceStudy) -> Verdict:
    """Return the verdict on the files' method.

    If it is `unresolved` because the study has no evidence of gains, its text says which files a
    verdict needs.
    """
    verdict = judge(study.records)
    if verdict.verdict != "unresolved" or study.steps is not None:
        return verdict
    takes = (
        f"a verdict takes {FEWEST_FILES} files at halved timesteps or more, within {TOGETHER:g} "
        f"rad of the exact motion over the first interval, got {len(study.rows)}"
    )
    return replace(verdict, quoted=takes)


def results_of(study: ConvergenceStudy, explained_by: Sequence[str]) -> Results:
    """Return the runs and the verdict of a study as results, from which a report's pages are made.

    Parameters
    ----------
    study : the convergence study of the files
    explained_by : sentences on mistakes or other physics that explain the motions' errors. If there
        are any, the verdict is `disagrees`
    """
    verdict = verdict_on_files(study)
    if explained_by:
        quoted = "; ".join(filter(None, [*explained_by, verdict.quoted]))
        verdict = replace(verdict, verdict="disagrees", quoted=quoted)
    name, pair = study.scenario.name, (study.engine.name, study.method.name)
    # Files are treated as an engine as shipped: judged, shown first, and never recommended.
    return Results(
        {},
        {name: SceneResult(study.scenario, study.solution)},
        [replace(row, stock=row is study.rows[-1]) for row in study.rows],
        [verdict],
        methods={pair: replace(study.method, as_shipped=True)},
    )


def _answer_runs(study: ConvergenceStudy, recorded: dict[float, Trajectory]) -> None:
    """Answer each run that the study asks for with the recorded motion of the same timestep.

    Parameters
    ----------
    recorded : the motions of the files, by their timesteps, s
    """
    runs = study.runs()
    planned = next(runs, None)
    while planned is not None:
        timestep = planned.rung.timestep
        motion = recorded[timestep]
        named = (study.engine.name, "", study.method.name, timestep)
        run = Run(*named, "ok", trajectory=motion, steps=planned.rung.steps)
        try:
            planned = runs.send(study.compare(planned, Answer(run)))
        except StopIteration:
            planned = None


def _timestep(motion: JudgedMotion) -> float:
    """Return the timestep of a motion, s; if none is known, the time between samples.

    Raises
    ------
    RecordingError
        If no timestep is known and the samples are not evenly spaced.
    """
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
    """Return the S times, s, (S,), at which all motions have samples.

    Raises
    ------
    RecordingError
        If there are fewer than two such times.
    """
    times = motions[0].t
    slack = SAME_TIME * float(times[-1])
    for motion in motions[1:]:
        nearest = np.clip(np.searchsorted(motion.t, times - slack), 0, len(motion.t) - 1)
        times = times[np.abs(motion.t[nearest] - times) <= slack]
    if len(times) < 2:
        raise RecordingError(
            "files at halved timesteps must share two sample times or more, these share "
            f"{len(times)}"
        )
    return times


def _at(motion: Trajectory, times: FloatArray) -> Trajectory:
    """Return the samples of a motion at S given times, s, (S,), with exactly these times.

    At each of these times the motion must have a sample, but for rounding of the time.
    """
    slack = SAME_TIME * float(times[-1])
    return replace(motion.at(np.searchsorted(motion.t, times - slack)), t=times)
