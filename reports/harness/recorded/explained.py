"""Explains a recorded motion, and says whether its errors are those of noise or of its method.

Three kinds of explanations are tried, in this order:

- A mistake is found in the recording. What remains is explained in turn (`_with_remainder`).
- Other equations of motion explain a motion with noise (`_of_measured`) or without
  (`_of_computed`). Without noise it may also be explained by mistakes in attitude or ω
  (`_of_readings`), or by a clamp of ω (`_of_equations`).
- If other equations explain too little, there may be a mistake in recording besides
  (`_beside_a_mistake`). Or the physics change at some time, and the motion is explained from that
  time on (`_since_exactly`) or until then (`_by_its_beginning`).
"""

from dataclasses import dataclass, replace

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.rotation import norms
from .case import Case
from .findings import Finding, finding, parts_of
from .fits.log import log_of
from .fits.measured import Measured
from .fits.motion_changes import sentences
from .fits.other_physics import MOST_PARAMETERS, Physics
from .fits.read_attitude import attitude_read
from .fits.read_omega import OMEGA, omega_read
from .fits.since import CHANGED, since_exactly, since_left_out, since_when
from .fits.starts import elsewhere
from .samples.alternation import Alternation
from .samples.hinges import keeps_momentum_of_start, spins_beyond
from .samples.intervals import intervals_of
from .samples.missing import is_omega_off
from .samples.mistakes import FITS, followed

#: Largest error of attitude, rad, and of ω, relative to the largest ‖ω‖, by which the iterative
#: constraint solver of an engine may scatter states at random.
SOLVERS = 1e-4
#: The first parts of a motion that are tried if it is not explained as a whole: a half and a
#: quarter. The least number of samples in such a part.
PARTS, FEWEST = (2, 4), 20
UNTIL = "that explains it until t = {:.4g} s, and not all that follows: look for what changed"
EXACT_UNTIL = (
    "until t = {:.4g} s it is the exact motion with noise, and not in all that follows: look for "
    "what changed"
)
#: The most mistakes in recording that are tried, one at a time, together with other explanations.
MOST_TRIED = 3


@dataclass(frozen=True, eq=False)
class Explanation:
    """What explains a recorded motion.

    Attributes
    ----------
    explained_by : sentences on what explains why the motion is not the exact one
    verdict : a sentence on whether its errors are within noise, or within those of its method
    is_beyond : whether its errors are larger than noise, or than those of its method
    made_by : the known integrator that computed the motion, in words; empty if none is recognised
    measured : the fit to all samples if the motion has noise, else None; if a mistake in recording
        is found, to the samples in which it is corrected
    is_open : whether part of the difference from the exact motion stays unexplained
    """

    explained_by: tuple[str, ...]
    verdict: str
    is_beyond: bool
    made_by: str = ""
    measured: Measured | None = None
    is_open: bool = False


def explained(case: Case) -> Explanation:
    """Return what explains why a recorded motion is not the exact one.

    If a mistake is found in the recording, it is corrected, and the corrected recording is
    explained in turn. If none is found, other equations of motion are tried.
    """
    found = finding(case)
    return _with_remainder(case, found) if found else _by_equations(case)


def _with_remainder(case: Case, found: Finding) -> Explanation:
    """Return a finding and what explains the rest of the difference from the exact motion.

    The cases in `Finding.left` are explained one after another. The first that is explained fully
    is used; if none is, the last one.

    Parameters
    ----------
    case : the case before any of its samples are corrected or left out
    found : the finding in it
    """
    remainder = None
    for left in found.left:
        remainder = explained(left)
        if not remainder.is_open:
            break
    is_beyond = case.physics.is_beyond if found.is_beyond is None else found.is_beyond
    # If only some samples remain, what was found may have made these wrong, too.
    is_reported = remainder is not None and (found.is_all or not remainder.is_open)
    # Once most of the motion is explained, the sentence that ω is not that of the attitudes adds
    # nothing.
    of_remainder = (
        [one for one in remainder.explained_by if one != OMEGA] if remainder and is_reported else []
    )
    words = (*found.words, *of_remainder)
    made_by = remainder.made_by if remainder and found.is_all else ""
    is_open = remainder is not None and remainder.is_open
    measured = remainder.measured if remainder and found.is_all else None
    if measured and is_beyond:
        verdict = f"as it is recorded, beyond its noise; corrected, it is {measured.verdict}"
    else:
        verdict = _verdict(case.physics, is_beyond, is_explained=True)
    return Explanation(words, verdict, is_beyond, made_by, measured, is_open)


def _by_equations(case: Case) -> Explanation:
    """Return what explains a motion in whose recording no mistake is found.

    Other equations of motion are tried, together with noise or the errors of a method.
    """
    noise, alternates = _noise_of(case)
    if noise is not None:
        fit, case = _fitted(case, noise), replace(case, noise=noise)
        log = fit.log
        # If ω was recorded wrongly, that is corrected before the log is fitted.
        is_tried = not fit.requires_nothing and _may_be_mistaken(case)
        if is_tried and (both := _beside_a_mistake(case)):
            return both
        compared = case.motion.until(len(log.t)), case.exact.until(len(log.t))
        if fit.is_beyond and (words := since_when(fit, *compared)):
            return Explanation(tuple(words), fit.verdict, is_beyond=True, measured=fit)
        if words := since_left_out(fit, case.motion):
            return Explanation(tuple(words), fit.verdict, is_beyond=True, measured=fit)
        # A constraint solver's error looks like noise, but the method has other errors, too.
        is_measured = case.stated is not None or bool((noise > _of_solvers(case)).any())
        is_measured = is_measured or case.physics.is_beyond or not fit.is_beyond
        # If attitude or ω alone is right, the motion was measured: errors of a method in one of
        # them soon cause errors in the other.
        if is_measured or fit.right_by_itself:
            found = _of_measured(fit, case)
            if case.is_trial or not fit.is_beyond or found.explained_by:
                return found
            return _by_its_beginning(case) or found
    physics = case.physics
    if case.is_trial and (physics.search is None or physics.is_open):
        return Explanation((), "", physics.is_beyond, is_open=True)
    is_tried = physics.search is None or physics.is_open_or_turning
    if is_tried and _may_be_mistaken(case) and (both := _beside_a_mistake(case)):
        return both
    found = _of_computed(case, alternates if case.has_omega else None)
    if case.is_trial or not physics.is_unexplained or (found.explained_by and not found.is_open):
        return found
    both = _beside_a_mistake(case) if _may_be_mistaken(case) and not is_tried else None
    both = both or _since_exactly(case) or _by_its_beginning(case)
    return both or _by_noise(case, alternates) or found


def _fitted(case: Case, noise: FloatArray) -> Measured:
    """Return the fit of the exact motion to all samples, with a given noise.

    Parameters
    ----------
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    """
    has = {"is_stated": case.stated is not None, "has_omega": case.has_omega}
    log = log_of(case.scenario, case.motion, case.exact, noise, **has)
    return Measured(case.scenario, log.while_followed(case.exact))


def _by_noise(case: Case, alternates: Alternation | None) -> Explanation | None:
    """Return the fit of a motion that noise of attitude or of ω explains; None if it does not.

    Noise of one quantity alone may be an error of a method, so that it is tried last.

    Parameters
    ----------
    alternates : what alternates in the motion from sample to sample; None if nothing does
    """
    if not alternates or not alternates.is_noise.any() or _is_computed(case):
        return None
    fit = _fitted(case, np.maximum(alternates.noise, case.floor))
    if fit.is_beyond or not fit.requires_nothing:
        return None
    return Explanation((), fit.verdict, is_beyond=False, measured=fit)


def _may_be_mistaken(case: Case) -> bool:
    """Return whether mistakes in recording are to be tried together with other explanations.

    They are if ω was recorded, no mistake has been corrected before, and the case is no trial.
    """
    return case.has_omega and not (case.undone or case.is_trial)


def _by_its_beginning(case: Case) -> Explanation | None:
    """Return what explains the first half or quarter of a motion; None if nothing does.

    The sentences also say until when the explanation holds.
    """
    t = case.motion.t
    for part in PARTS:
        left = case.of(np.arange(len(t) // part)) if len(t) >= part * FEWEST else None
        remainder = _by_equations(replace(left, is_trial=True)) if left else None
        if left is None or remainder is None or remainder.is_open:
            continue
        # If noise is estimated, not stated, noise alone explains nothing: it may be a method's
        # error.
        if not remainder.explained_by and case.stated is None:
            continue
        fit = left.physics.by_change if left.physics.is_of_equations else None
        later = [one.words for one in case.jumps(fit.hypothesis)] if fit else []
        until = UNTIL if remainder.explained_by else EXACT_UNTIL
        words = *remainder.explained_by, *(later or [until.format(left.motion.t[-1])])
        return _with_remainder(case, Finding(words))
    return None


def _since_exactly(case: Case) -> Explanation | None:
    """Return when a motion suddenly ceases to be the exact one, and what explains the later motion.

    Returns
    -------
    None if there is no such sudden change, if there are too few samples or some are too far apart,
    or if the recording does not begin at the scene's start
    """
    physics = case.physics
    of_method = case.timestep, case.order, case.of_intervals
    data = intervals_of(case.scenario, case.motion, *of_method)
    if data is None or len(data.spans) < len(case.motion.t) - 1 or physics.exact.t[0]:
        return None
    since = since_exactly(data, physics.least, case.reach)
    if since is None:
        return None
    but_for = "but for the errors of its method" if since.is_method else "to rounding"
    begins = f"until t = {case.motion.t[since.last]:.4g} s it is the exact motion, {but_for}"
    later = case.of(np.arange(since.first, len(case.motion.t)))
    remainder = explained(replace(later, is_trial=True)) if later else None
    if remainder and remainder.explained_by and not remainder.is_open:
        words = [
            f"{begins}; there it changes: from then on {one}" for one in remainder.explained_by
        ]
    else:
        turned, faster = since.off
        words = [CHANGED.format(begins, np.degrees(turned), faster)]
    verdict = _verdict(physics, physics.is_beyond, is_explained=True)
    return Explanation(tuple(words), verdict, physics.is_beyond)


def _beside_a_mistake(case: Case) -> Explanation | None:
    """Return a mistake in recording, together with what explains the corrected motion.

    A mistake is tried only if, once it is corrected, ω is the rate at which the attitude turns. At
    most `MOST_TRIED` are tried.

    Returns
    -------
    None if no correction leads to a motion that is explained fully
    """
    for words, reading in followed(case.reading, case.scenario)[:MOST_TRIED]:
        if left := case.read(reading):
            left = replace(left, is_trial=True)
            both = _with_remainder(
                case, Finding(tuple(words), (left,), is_beyond=True, is_all=True)
            )
            if not both.is_open:
                return both
    return None


def _noise_of(case: Case) -> tuple[FloatArray | None, Alternation | None]:
    """Return the noise of a motion, and what alternates from sample to sample without being noise.

    The noise is that which the file states. If it states none, it is the noise that was found in
    the recording before. If there was none either, it is what alternates from sample to sample, if
    that looks like noise and the motion is not known to have been computed.

    Returns
    -------
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,); None if the motion has none
    alternates : what alternates; None if nothing does, or if there is noise that is not stated
    """
    alternates = case.alternates
    if case.stated is None and case.noise.any():
        fits = FITS * np.array([1.0, norms(case.motion.omega_body).max()])
        return np.maximum(case.noise, np.maximum(case.floor, fits)), None
    if case.stated is not None or not alternates:
        return case.stated, alternates
    is_large = bool((alternates.noise > _of_solvers(case)).all())
    is_noise = alternates.is_noise & [is_large or not case.has_omega, case.has_omega]
    if _is_computed(case) or not is_noise.any():
        return None, alternates
    # Errors of a method alternate, too, where rotors turn by radians between samples.
    if case.timestep is not None and case.physics.is_of_method:
        return None, alternates
    return np.maximum(alternates.noise, case.floor), None


def _is_computed(case: Case) -> bool:
    """Return whether a motion is known to have been computed, and not measured.

    Only for a motion that was computed does a user state a timestep, and an order of more than one.
    """
    return case.timestep is not None and case.order > 1


def _of_solvers(case: Case) -> FloatArray:
    """Return how far constraint solvers may scatter attitude, rad, and ω, rad/s, at most, (2,)."""
    return SOLVERS * np.array([1.0, norms(case.motion.omega_body).max()])


def _of_computed(case: Case, alternates: Alternation | None) -> Explanation:
    """Return what explains a motion without noise, which was computed and not measured.

    Parameters
    ----------
    alternates : what alternates in the motion from sample to sample; None if nothing does, or if ω
        was not recorded
    """
    physics, motion = case.physics, case.motion
    of_spins = spins_beyond(case.scenario, motion, case.timestep, case.order, case.floor)
    words = of_method = physics.of_other_method
    is_open, is_beyond = False, physics.is_beyond or bool(words or of_spins)
    if not physics.made_by:
        words = words or (_of_readings(physics) if case.has_omega and not physics.clamps else [])
        # The sentence that only ω is wrong says less than an explanation of all of the motion.
        if not words or (words == [OMEGA] and physics.is_all):
            words = _of_attitudes(case) or _of_equations(case)
            is_open = physics.is_open and not physics.unlike_any_change
            if words and physics.is_of_equations and (fit := physics.by_change):
                words = [*words, *(one.words for one in case.jumps(fit.hypothesis))]
    if alternates and physics.is_beyond:
        words = alternates.of_omega or words
    # Other equations cannot explain a wrong state at the scene's start. From a wrong first ω,
    # rotors on free hinges keep a wrong momentum, which looks like other equations.
    is_carried = keeps_momentum_of_start(case.scenario)
    at_start = not physics.exact.t[0] and (physics.is_of_equations or is_carried)
    start = elsewhere(physics) if case.has_omega and (of_method or at_start or not words) else []
    is_tried = bool(start) and (is_carried or not words) and not physics.made_by
    left = case.as_it_begins() if is_tried else None
    if left:
        found = Finding(tuple(start), (replace(left, is_trial=True),), is_beyond)
        of_start = _with_remainder(case, found)
        if not words or not of_start.is_open:
            return of_start
    words = [*words, *of_spins, *start]
    verdict = _verdict(physics, is_beyond, is_explained=bool(words))
    return Explanation(tuple(words), verdict, is_beyond, physics.made_by, is_open=is_open)


def _of_attitudes(case: Case) -> list[str]:
    """Return sentences on other equations that the attitudes obey, and on how ω was misrecorded.

    The list is empty if no such equations are found, or if the wrong ω cannot be explained beside
    them. It is empty, too, if the case is only a trial, if ω was not recorded, or if other
    equations explain attitude and ω together, but for noise or a method's errors. Within a method's
    error, equations with more than `MOST_PARAMETERS` parameters count for nothing.
    """
    physics = case.physics
    found = physics.found or physics.by_change
    remainder = physics.after(found) if found else None
    if (
        case.is_trial
        or not case.has_omega
        or (remainder and (remainder.made_by or remainder.is_of_method))
    ):
        return []
    left = case.read(case.reading._replace(omega=None))
    fit = left.physics.by_change if left and left.physics.is_of_equations else None
    if left is None or fit is None or not left.physics.after(fit).is_of_noise:
        return []
    if fit.rank > MOST_PARAMETERS and not physics.is_beyond:
        return []
    read = omega_read(physics.after(fit), is_explained=False)
    return [*sentences(fit), *read] if read and read != [OMEGA] else []


def _of_equations(case: Case) -> list[str]:
    """Return sentences on the clamp of ω, or else on the other equations, that explain a motion.

    A clamp is a bound that ω is limited to. After the sentence on it, further ones explain the
    motion before ω reaches the bound. The list is empty if neither explains the motion.
    """
    if not case.physics.clamps:
        return case.physics.explained()
    clamp = case.physics.clamps[0]
    left = parts_of(case, np.arange(clamp.first))
    found = Finding((clamp.words,), left, is_beyond=True)
    return list(_with_remainder(case, found).explained_by)


def _of_readings(physics: Physics) -> list[str]:
    """Return sentences on how attitude or ω of a recorded motion is wrong; empty if neither is.

    Parameters
    ----------
    physics : the recorded motion, with the search for what explains it
    """
    if words := attitude_read(physics.motion, physics.exact):
        return words
    is_tried = physics.is_beyond or is_omega_off(physics.motion, physics.exact)
    return omega_read(physics, is_explained=physics.is_of_reading) if is_tried else []


def _of_measured(fit: Measured, case: Case) -> Explanation:
    """Return what explains a motion with noise.

    If even the best fit leaves more than noise, the explanations of motions without noise are tried
    before the changes that the fit found.

    Parameters
    ----------
    fit : the fit of the exact motion to all samples
    """
    physics = case.physics
    words = physics.dissipated if fit.search.is_called_for else []
    if not words and fit.is_beyond and (physics.clamps or physics.by_change is None):
        # If a clamp limited the body's own ω, the attitudes could not be the scene's.
        words = fit.right_by_itself
    words = words or (_of_equations(case) if fit.is_beyond else []) or fit.explained()
    said, is_beyond = tuple(words), fit.is_beyond
    return Explanation(said, fit.verdict, is_beyond, measured=fit, is_open=is_beyond)


def _verdict(physics: Physics, is_beyond: bool, *, is_explained: bool) -> str:
    """Return a sentence on whether a motion's errors are larger than those of its method.

    If they are not known to be larger, and the samples are too few or too far apart to compare
    them, the sentence says that.

    Parameters
    ----------
    physics : the recorded motion, with the search for what explains it
    is_beyond : whether the errors are known to be larger
    is_explained : whether a mistake or other physics explains the motion
    """
    if physics.search is None and not is_beyond:
        as_recorded = "as it is recorded, " if is_explained else ""
        return (
            f"{as_recorded}its samples are too few, or too far apart, to say what a method made of "
            "them"
        )
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
