"""Finds out why the first sample is not the exact one, such as a misread start of the scene."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import fdtrc

from .....reference.deviations import apart
from .....reference.following import follow
from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario
from .....scenarios.rotation import conjugate, matrix, norms, rotation_vectors
from ...explaining.search import LEFT, SAME, SIGNIFICANCE
from ..samples.clamps import TINY
from ..samples.intervals import deviations_from_flow, error_at_first_sample, states_of
from ..samples.mistakes import FITS
from .other_physics import Physics
from .read_omega import OMEGA

#: Conventions, in scipy's notation, by which z-y-z angles may have been read by mistake.
CONVENTIONS = ("ZYX", "XYZ", "ZXZ", "ZXY", "YXZ", "zyx", "xyz", "zyz")


def elsewhere(physics: Physics) -> list[str]:
    """Return a sentence on how the first sample deviates from the exact motion.

    The deviation counts only if it exceeds a bound of the method's error since the scene's start.
    By an F-test it must also be significantly larger than the deviations of later samples from the
    exact flow that starts in the sample before each of them.

    Parameters
    ----------
    physics : the recorded motion, with the search for what explains it

    Returns
    -------
    A list of one sentence; empty if the deviation does not count
    """
    scenario, exact, motion = physics.scenario, physics.exact, physics.motion
    of_method = error_at_first_sample(scenario, motion.t, physics.timestep, physics.order)
    deviations = apart(states_of(exact.until(1)), states_of(motion.until(1))).reshape(2, 3)
    others = deviations_from_flow(scenario, motion)[1:].reshape(-1, 2, 3)
    count = max(1, 3 * len(others))
    least = physics.least
    variances = np.sum(others**2, axis=(0, 2)) / count + least**2
    p_values = fdtrc(3, count, np.mean(deviations**2, axis=1) / variances)
    if not ((p_values < SIGNIFICANCE / 2) & (norms(deviations) > of_method)).any():
        return []
    attitudes = apart(states_of(exact.until(2)), states_of(motion.until(2)))[:, :3]
    if norms(deviations)[0] <= least[0] and norms(attitudes[1:])[0] <= least[0]:
        # The first two attitudes are right, and so was the body's first ω. Only the recorded ω is
        # wrong.
        return [OMEGA]
    start = states_of(exact.until(1))
    words = "" if exact.t[0] else _misread_start(scenario, states_of(motion.until(1))[0])
    words = words or _at_another_time(scenario, start, deviations)
    return [words or started_elsewhere(float(exact.t[0]), norms(deviations))]


def _at_another_time(scenario: Scenario, start: FloatArray, deviations: FloatArray) -> str:
    """Return the sentence that ω at the first sample is the exact ω at another time.

    The text is empty if there is no such time.

    Parameters
    ----------
    start : the exact state at the first sample, q and ω, (1, 7)
    deviations : deviations of the recorded attitude, rad, and ω, rad/s, from that state, (2, 3)
    """
    equations = equations_of(scenario)
    rate = max(float(equations.rate), float(norms(start[:, 4:])[0]))
    turned, faster = norms(deviations) * [rate, 1.0]
    if not faster or turned > SAME * faster:
        return ""

    def later(time: float) -> FloatArray:
        return apart(start, follow(equations, start, np.array([[time]]))[:, 0])[0, 3:]

    # To first order, the deviation of ω is its rate of change times the time.
    small = SAME / rate
    change = later(small) / small
    time = float(deviations[1] @ change / max(change @ change, TINY))
    residual = float(norms((later(time) - deviations[1])[None])[0])
    if abs(time) * rate > LEFT or residual > max(SAME, abs(time) * rate) * faster:
        return ""
    when = "after" if time > 0 else "before"
    return f"ω is that of {abs(time):.4g} s {when} its time; the attitude is that of its time"


def started_elsewhere(at: float, deviations: Sequence[float] | FloatArray) -> str:
    """Return the sentence that a motion started in another state than the scene states.

    Parameters
    ----------
    at : time of the first sample, s
    deviations : sizes of the deviations of attitude, rad, and ω, rad/s, at that time, (2,)
    """
    turned, faster = (0.0 if size < FITS else float(size) for size in deviations)
    return (
        f"it started elsewhere: at t = {at:g} s the attitude is off by {np.degrees(turned):.3g}° "
        f"and ω by {faster:.3g} rad/s"
    )


def _misread_start(scenario: Scenario, first: FloatArray) -> str:
    """Return a sentence on how a scene's start was misread; empty if no known mistake explains it.

    Parameters
    ----------
    first : q, scalar first, and ω, rad/s, body axes, of the first sample, (7,)
    """
    start, words = scenario.start, []
    rate = float(norms(start.omega_body[None])[0])
    turned = {
        name: float(norms(rotation_vectors(q[None], first[None, :4]))[0])
        for name, q in _attitudes(scenario)
    }
    faster = {name: float(norms((first[4:] - omega)[None])[0]) for name, omega in _rates(scenario)}
    for deviations, unit in (turned, 1.0), (faster, rate):
        best = min(deviations, key=deviations.__getitem__)
        if deviations[best] > FITS * unit:
            return ""
        words += [best] if best else []
    return f"it started elsewhere: {', and '.join(words)}" if words else ""


def _attitudes(scenario: Scenario) -> Iterator[tuple[str, FloatArray]]:
    """Yield the attitude of a scene's start, scalar first, (4,): as it is, then as misread.

    Each attitude comes after words on how it was misread, which are empty for the first.
    """
    q_wxyz, angles = scenario.start.q_world_body_wxyz, scenario.document.start.euler_zyz_deg
    yield "", q_wxyz
    yield "its attitude is that of the world in the body", conjugate(q_wxyz)
    if angles is None:
        return
    for convention in CONVENTIONS:
        axes = "-".join(convention.lower())
        fixed = " about the world's axes" if convention.islower() else ""
        words = f"the angles of its attitude are read as {axes}{fixed}, not as z-y-z"
        turned = Rotation.from_euler(convention, angles, degrees=True)
        yield words, turned.as_quat(scalar_first=True)


def _rates(scenario: Scenario) -> Iterator[tuple[str, FloatArray]]:
    """Yield the ω of a scene's start, rad/s, body axes, (3,): as it is, then as misread.

    Each ω comes after words on how it was misread, which are empty for the first.
    """
    omega, R_world_body = scenario.start.omega_body, matrix(scenario.start.q_world_body_wxyz)
    yield "", omega
    yield "its ω along world axes is taken to be along body axes", R_world_body @ omega
    yield "its ω along body axes is taken to be along world axes", R_world_body.T @ omega
    yield "its ω in rad/s is taken to be in degrees a second", np.radians(omega)
    yield "its ω has the other sign", -omega
