"""Explains a recorded motion, and says whether it is within the errors allowed to its method."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import matrices, norms
from .alternation import Alternation, alternation
from .columns import saturated, stuck
from .digits import Numbers, Shown, numbers_of, shown_by_digits
from .exact_at import exact_at
from .hinges import spins_beyond
from .interpolated import interpolated
from .intervals import intervals_of
from .jumps import FAR, jumps
from .log import log_of
from .measured import Measured
from .missing import is_omega_off
from .mistakes import FEWEST, LEFT_OUT, followed, mistakes, rounded_times, without
from .motion import Reading, RecordedMotion, recorded_motion
from .odd_samples import across_signs, exchanged, jitter, lost_sign, warped, wrapped
from .other_physics import Physics, rounding
from .read_attitude import attitude_read
from .read_omega import OMEGA, omega_read
from .recording import Recording, RecordingError
from .since import since_exactly, since_when
from .starts import elsewhere

#: Names of the settings by which a file states the noise of attitude, rad, and of ω, rad/s.
NOISE = ("noise_attitude", "noise_omega")
#: That a method's order is lower than the stated one.
LOWER_ORDER = (
    "its method is of order {}, not {}: the scene's equations and errors of that order make this "
    "motion; look for a wrong stage or weight, or a rate that is taken at another time"
)
OTHER_TIMESTEP = "its timestep is not the stated {:.4g} s"
LONGER_TIMESTEP = (
    "its timestep is longer than the stated {:.4g} s: the scene's equations and errors of order {} "
    "make this motion, with a timestep of {:.2g} s or more"
)
#: Noise of attitude, rad, and of ω, relative, beyond which no solver leaves it.
SOLVERS = 1e-4
#: How many mistakes are tried with what may explain the rest.
MOST_TRIED = 3


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
    *,
    is_first: bool = True,
) -> Explanation:
    """Return what explains a recorded motion.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    reading, recorded : the recording, read as it states itself
    timestep : the timestep that the motion was made with, s; None if unknown
    order : order of accuracy of the method that made it
    is_first : whether no mistake has been undone in the reading
    """
    motion, has_omega = recorded.trajectory, recorded.has_omega
    floor = _floor(scenario, motion, recording.resolution, has_omega)
    stated = [float(recording.settings.get(name, 0.0)) for name in NOISE]
    noise = np.maximum(stated, floor) if any(stated) else None
    # An interval has the noise of two samples.
    of_intervals = floor if noise is None else np.sqrt(2) * noise
    physics = Physics(scenario, motion, exact, timestep, order, of_intervals)
    # What is certain by the numbers themselves comes before what they may mean.
    numbers = numbers_of(recording, reading, exact)
    if shown := shown_by_digits(numbers):
        return _of_numbers(shown, physics, reading)
    if odd := _odd_samples(reading, numbers, physics):
        return _of_numbers([odd], physics, reading)
    if wrong := mistakes(scenario, exact, reading) or rounded_times(reading):
        of_all = scenario, exact, recording, reading, timestep, order
        rest = _without(wrong, *of_all) if is_first else None
        sentences = (*wrong, *(rest.explained_by if rest else ()))
        made_by = rest.made_by if rest else ""
        return Explanation(sentences, _verdict(physics), physics.is_beyond, made_by)
    if uneven := warped(scenario, motion, exact, of_intervals):
        return Explanation((uneven,), _verdict(physics, is_explained=True), physics.is_beyond)
    every = intervals_of(scenario, motion, timestep, order, of_intervals, near=FAR)
    if every and not physics.clamps and (jump := jumps(every, has_omega=has_omega)):
        return Explanation(tuple(jump), _verdict(physics, is_beyond=True), is_beyond=True)
    alternates, is_stated = alternation(scenario, motion, floor), noise is not None
    # Who states an order of more than one has computed the motion.
    is_computed = timestep is not None and order > 1
    of_solvers = SOLVERS * np.array([1.0, norms(motion.omega_body).max()])
    if noise is None and not is_computed and alternates:
        is_large = bool((alternates.noise > of_solvers).all())
        if (alternates.is_noise & [is_large or not has_omega, has_omega]).any():
            noise, alternates = np.maximum(alternates.noise, floor), None
    if noise is not None:
        has = {"is_stated": is_stated, "has_omega": has_omega}
        fit = Measured(scenario, log_of(scenario, motion, exact, noise, **has))
        physics = replace(physics, noise=np.sqrt(2) * noise)
        if fit.is_beyond and (words := since_when(fit, motion, exact)):
            return Explanation(tuple(words), fit.verdict, is_beyond=True, measured=fit)
        # What a solver leaves is like noise, and its method has errors besides.
        is_large = bool((noise > of_solvers).any())
        is_measured = is_stated or is_large or physics.is_beyond or not fit.is_beyond
        # A method that errs in one of attitude and ω soon errs in the other.
        if is_measured or fit.right_by_itself:
            return _of_measured(fit, physics)
    is_asked = is_first and has_omega and (physics.search is None or physics.is_open_or_turning)
    if is_asked and (both := _both(physics, recording, reading)):
        return both
    return _of_computed(physics, alternates if has_omega else None, floor, has_omega=has_omega)


def _odd_samples(reading: Reading, numbers: Numbers, physics: Physics) -> Shown | None:
    """Return what samples show by themselves, beyond their digits; None if nothing."""
    found = interpolated(numbers) or lost_sign(reading, numbers) or across_signs(numbers)
    if found or numbers.omega is None:
        return found
    motion = physics.motion
    return (
        saturated(numbers, numbers.omega)
        or stuck(numbers, numbers.omega)
        or wrapped(numbers, numbers.omega)
        or exchanged(physics.scenario, motion)
        or jitter(motion)
    )


def _of_numbers(shown: Sequence[Shown], physics: Physics, reading: Reading) -> Explanation:
    """Say what numbers show, and which mistakes explain what is recorded before the first of it."""
    rounding = np.max([one.rounding for one in shown], axis=0)
    physics = replace(physics, noise=np.maximum(physics.noise, np.sqrt(2) * rounding))
    # Only what is rounded may be within a method's error.
    is_beyond = physics.is_beyond or not all(any(one.rounding) for one in shown)
    first = min(one.first for one in shown)
    wrong = []
    if first > FEWEST + LEFT_OUT:
        before = reading.rows(slice(first))
        exact, motion = physics.exact.until(first), physics.motion.until(first)
        wrong = mistakes(physics.scenario, exact, before)
        part = replace(physics, motion=motion, exact=exact)
        # A rest that is not explained may be of what was found.
        wrong = wrong or ([] if part.is_open or part.clamps else part.explained())
    words = *(one.words for one in shown), *wrong
    return Explanation(words, _verdict(physics, is_beyond), is_beyond)


def _without(
    wrong: list[str],
    scenario: Scenario,
    exact: Trajectory,
    recording: Recording,
    reading: Reading,
    timestep: float | None,
    order: int,
) -> Explanation | None:
    """Return what explains a recording once mistakes in it are undone; None if they cannot be."""
    undone = without(wrong, reading, scenario, _first(exact))
    if undone is None or len(undone.t) != len(reading.t) or undone.t[0] < 0:
        return None
    try:
        is_same = np.array_equal(undone.t, reading.t)
        at = exact if is_same else exact_at(scenario, undone.t).trajectory
    except RecordingError:
        return None
    motion = recorded_motion(scenario, recording, undone, at)
    of_it = scenario, at, recording, undone, motion, timestep, order
    return explained(*of_it, is_first=False)


def _both(physics: Physics, recording: Recording, reading: Reading) -> Explanation | None:
    """Return a mistake, and what explains all that it leaves; None if there is no such mistake.

    It is one without which the attitude follows ω, whatever torques act.
    """
    scenario, exact = physics.scenario, physics.exact
    of_com = [one for name, one in recording.arrays.items() if name in ("com", "velocity")]
    for words, one in followed(reading, scenario)[:MOST_TRIED]:
        undone: Reading | None = one
        more = mistakes(scenario, at, one) if (at := _at(exact, one.t)) else []
        if more:
            undone = without(more, one, scenario, _first(exact))
        at = _at(exact, undone.t) if undone else None
        if undone is None or at is None or any(len(one) != len(at.t) for one in of_com):
            continue
        motion = recorded_motion(scenario, recording, undone, at).trajectory
        rest = replace(physics, motion=motion, exact=at)
        if rest.search is not None and not rest.is_open:
            of_physics = [] if rest.made_by else rest.explained()
            every = *words, *more, *of_physics
            return Explanation(every, _verdict(rest, is_beyond=True), is_beyond=True)
    return None


def _first(exact: Trajectory) -> FloatArray:
    """Return the attitude at the first sample, body to world, (3, 3)."""
    return np.asarray(matrices(exact.q_world_body_wxyz[:1])[0])


def _at(motion: Trajectory, t: FloatArray) -> Trajectory | None:
    """Return the samples of a motion at times, s, (n,); None if it has not all of them."""
    kept = np.isin(motion.t, t)
    if np.count_nonzero(kept) != len(t):
        return None
    arrays = {one.name: getattr(motion, one.name) for one in fields(motion)}
    return Trajectory(**{name: array[kept] for name, array in arrays.items()})


def _of_computed(
    physics: Physics, alternates: Alternation | None, floor: FloatArray, *, has_omega: bool
) -> Explanation:
    """Explain a motion that was computed."""
    of_method = physics.scenario, physics.motion, physics.timestep, physics.order
    of_spins = spins_beyond(*of_method, floor)
    words = _of_other_method(physics)
    is_beyond = physics.is_beyond or bool(words or of_spins)
    if not physics.made_by:
        words = words or (_of_readings(physics) if has_omega and not physics.clamps else [])
        # That only ω is wrong says less than what explains all of the motion.
        words = physics.explained() if not words or (words == [OMEGA] and physics.is_all) else words
    if alternates and physics.is_beyond:
        words = alternates.of_omega or words
    if not words and not physics.made_by and not physics.exact.t[0]:
        words = since_exactly(physics.scenario, physics.motion)
    words = [*words, *of_spins]
    # Other equations change no state at the scene's start.
    if has_omega and (not words or (physics.is_of_equations and not physics.exact.t[0])):
        words = [*words, *elsewhere(physics)]
    verdict = _verdict(physics, is_beyond, is_explained=bool(words))
    return Explanation(tuple(words), verdict, is_beyond, physics.made_by)


def _of_other_method(physics: Physics) -> list[str]:
    """Return that a method of a lower order, or another timestep, than the stated one was used."""
    if physics.is_at_another_timestep:
        return [OTHER_TIMESTEP.format(physics.timestep)]
    order = physics.order_made
    if order == physics.order and physics.timestep:
        return [LONGER_TIMESTEP.format(physics.timestep, order, physics.least_timestep)]
    return [LOWER_ORDER.format(order, physics.order)] if order else []


def _of_readings(physics: Physics) -> list[str]:
    """Return what was made of ω, or of the attitude, if no simpler mistake explains the motion."""
    if words := attitude_read(physics.motion, physics.exact):
        return words
    is_asked = physics.is_beyond or is_omega_off(physics.motion, physics.exact)
    return omega_read(physics, is_explained=physics.is_of_reading) if is_asked else []


def _of_measured(fit: Measured, physics: Physics) -> Explanation:
    """Explain a measured motion, by other physics if more than noise is left."""
    words = physics.dissipated if fit.search.is_called_for else []
    if not words and fit.is_far and (physics.clamps or physics.by_change is None):
        # A body that is limited itself turns no faster either.
        words = fit.right_by_itself
    words = words or (physics.explained() if fit.is_beyond else []) or fit.explained()
    return Explanation(tuple(words), fit.verdict, fit.is_beyond, measured=fit)


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


def _verdict(physics: Physics, is_beyond: bool | None = None, *, is_explained: bool = False) -> str:
    """Return a sentence on whether a motion is beyond its method's error."""
    is_beyond = physics.is_beyond if is_beyond is None else is_beyond
    if physics.search is None:
        return "its samples are too few, or too far apart, to say what a method made of them"
    what = f"what a method of order {physics.order} makes of the exact motion"
    where = (
        f"at a timestep of {physics.timestep:.4g} s"
        if physics.timestep
        else "from sample to sample in one step, as no timestep is stated"
    )
    if is_beyond:
        return f"beyond {what} {where}"
    more = "" if physics.timestep else "; state the timestep to see smaller differences"
    if is_explained:
        more = "; but what explains it is no method's error"
    return f"within {what} {where}{more}"
