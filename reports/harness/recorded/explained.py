"""Explains a recorded motion, and says whether it is within the errors allowed to its method."""

from dataclasses import dataclass

import numpy as np

from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from .alternation import alternation
from .hinges import spins_beyond
from .interpolated import interpolated
from .intervals import apart, states_of
from .measured import Measured, log_of, started_elsewhere
from .mistakes import mistakes
from .motion import Reading, RecordedMotion
from .other_physics import Physics, rounding
from .recording import Recording

#: Names of the settings by which a file states the noise of attitude, rad, and of ω, rad/s.
NOISE = ("noise_attitude", "noise_omega")
#: Distance of a first sample, rad, and relative for ω, from which on the start counts as another
#: one.
STARTS = 1e-3


@dataclass(frozen=True, eq=False)
class Explanation:
    """What explains a recorded motion; the attributes are those of `JudgedMotion`."""

    explained_by: tuple[str, ...]
    verdict: str
    is_beyond: bool
    made_by: str = ""
    measured: Measured | None = None


def explained(
    scenario: Scenario,
    exact: Trajectory,
    recording: Recording,
    reading: Reading,
    recorded: RecordedMotion,
    timestep: float | None,
    order: int,
) -> Explanation:
    """Return what explains a recorded motion.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    reading, recorded : the recording, read as it states itself
    timestep : the timestep that the motion was made with, s; None if unknown
    order : order of accuracy of the method that made it
    """
    motion = recorded.trajectory
    floor = _floor(scenario, motion, recording.resolution, recorded.has_omega)
    settings = recording.settings
    stated = [float(settings.get(name, 0.0)) for name in NOISE]
    noise = np.maximum(stated, floor) if any(stated) else None
    in_recording = mistakes(scenario, exact, reading)
    if not in_recording and recorded.has_omega:
        in_recording = interpolated(motion, floor[1])
    alternates = alternation(scenario, motion, floor)
    if not in_recording:
        is_stated = noise is not None
        if noise is None and alternates and alternates.is_noise[: 1 + recorded.has_omega].all():
            noise = np.maximum(alternates.noise, floor)
        if noise is not None:
            has = {"is_stated": is_stated, "has_omega": recorded.has_omega}
            fit = Measured(scenario, log_of(scenario, motion, exact, noise, **has))
            # An interval has the noise of two samples.
            physics = Physics(scenario, motion, exact, timestep, order, np.sqrt(2) * noise)
            return _of_measured(fit, physics)
    physics = Physics(scenario, motion, exact, timestep, order, floor)
    of_spins = spins_beyond(scenario, motion, timestep, order, floor)
    is_beyond = physics.is_beyond or bool(of_spins)
    verdict = _verdict(physics, is_beyond)
    if in_recording:
        return Explanation(tuple(in_recording), verdict, is_beyond)
    words = [] if physics.made_by else physics.explained()
    if alternates and recorded.has_omega and physics.is_beyond:
        words = [*filter(None, [alternates.of_omega])] or words
    words += filter(None, [of_spins])
    if not words and recorded.has_omega:
        words = _elsewhere(exact, motion)
    return Explanation(tuple(words), verdict, is_beyond, physics.made_by)


def _of_measured(fit: Measured, physics: Physics) -> Explanation:
    """Explain a measured motion, by other physics if more than noise is left."""
    words = (physics.explained() if fit.is_beyond else []) or fit.explained()
    return Explanation(tuple(words), fit.verdict, fit.is_beyond, measured=fit)


def _elsewhere(exact: Trajectory, motion: Trajectory) -> list[str]:
    """Return the sentence that the first sample is off the scene's motion, if it is."""
    start, first = (states_of(one.until(1)) for one in (exact, motion))
    turned, faster = norms(apart(start, first).reshape(2, 3))
    speed = float(norms(start[:, 4:])[0])
    is_near = turned < STARTS and faster < STARTS * (speed or 1.0)
    return [] if is_near else [started_elsewhere(float(exact.t[0]), (turned, faster))]


def _floor(
    scenario: Scenario, motion: Trajectory, resolution: float, has_omega: bool
) -> FloatArray:
    """Return the error of attitude, rad, and ω, rad/s, by rounding, or by deriving ω, (2,)."""
    speed, distances = float(norms(motion.omega_body).max()), np.diff(motion.t)
    # Rounding of ω about the axis of the largest moment turns a needle about its thin axis.
    turns = speed * float(np.median(distances)) * float(np.linalg.cond(scenario.inertia))
    floor = (1 + turns) * rounding(motion, resolution)
    if not has_omega:
        distance = float(distances.max())
        # The stencil has five samples, with rounded numbers.
        found = speed * (speed * distance) ** 4 + floor[0] / float(distances.min())
        floor = np.array([floor[0] + distance * found, found])
    return floor


def _verdict(physics: Physics, is_beyond: bool) -> str:
    if physics.search is None:
        return "its samples are too few, or too far apart, to say what a method made of them"
    what = f"what a method of order {physics.order} makes of the exact motion"
    where = (
        f"at a timestep of {physics.timestep:.4g} s"
        if physics.timestep
        else "at a timestep as long as the samples are apart, as none is stated"
    )
    return f"{'beyond' if is_beyond else 'within'} {what} {where}"
