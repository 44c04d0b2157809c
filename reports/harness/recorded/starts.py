"""What was made of a scene's start, where the first sample of a recording is off."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import fdtrc

from ....reference.following import follow
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import conjugate, matrix, norms, rotation_vectors
from ..explaining.hypothesis import as_it_is
from ..explaining.search import LEFT, LEVEL, SAME
from .clamps import TINY
from .intervals import apart, gained, gained_before, states_of
from .mistakes import FITS
from .other_physics import Physics
from .read_omega import OMEGA

#: Conventions of Euler angles, as scipy writes them, that angles of z-y-z are taken for.
CONVENTIONS = ("ZYX", "XYZ", "ZXZ", "ZXY", "YXZ", "zyx", "xyz", "zyz")


def elsewhere(physics: Physics) -> list[str]:
    """Return the sentence that the first sample is off by more than what explains the others.

    What is gained from sample to sample, by noise or a method, is known to so many numbers; a
    method has errors since the scene's start.
    """
    scenario, exact, motion = physics.scenario, physics.exact, physics.motion
    of_method = gained_before(scenario, motion.t, physics.timestep, physics.order)
    off = apart(states_of(exact.until(1)), states_of(motion.until(1))).reshape(2, 3)
    others = gained(scenario, motion)[1:].reshape(-1, 2, 3)
    count = max(1, 3 * len(others))
    least = physics.least
    usual = np.sum(others**2, axis=(0, 2)) / count + least**2
    by_chance = fdtrc(3, count, np.mean(off**2, axis=1) / usual)
    if not ((by_chance < LEVEL / 2) & (norms(off) > of_method)).any():
        return []
    attitudes = apart(states_of(exact.until(2)), states_of(motion.until(2)))[:, :3]
    if norms(off)[0] <= least[0] and norms(attitudes[1:])[0] <= least[0]:
        # By where the attitude goes, ω was right at the start.
        return [OMEGA]
    start = states_of(exact.until(1))
    words = "" if exact.t[0] else _mistaken(scenario, states_of(motion.until(1))[0])
    words = words or _at_another_time(scenario, start, off)
    return [words or started_elsewhere(float(exact.t[0]), norms(off))]


def _at_another_time(scenario: Scenario, start: FloatArray, off: FloatArray) -> str:
    """Return in words that ω at the first sample is that of another time, if that is so.

    Parameters
    ----------
    start : the exact state at the first sample, (1, 7)
    off : how far attitude, rad, and ω, rad/s, are off there, (2, 3)
    """
    equations = as_it_is(scenario).equations
    rate = max(equations.rate, float(norms(start[:, 4:])[0]))
    turned, faster = norms(off) * [rate, 1.0]
    if not faster or turned > SAME * faster:
        return ""

    def later(time: float) -> FloatArray:
        return apart(start, follow(equations, start, np.array([[time]]))[:, 0])[0, 3:]

    # Nearly, ω is off in the direction of its rate of change.
    small = SAME / rate
    change = later(small) / small
    time = float(off[1] @ change / max(change @ change, TINY))
    left = float(norms((later(time) - off[1])[None])[0])
    if abs(time) * rate > LEFT or left > max(SAME, abs(time) * rate) * faster:
        return ""
    when = "after" if time > 0 else "before"
    return f"ω is that of {abs(time):.4g} s {when} its time; the attitude is that of its time"


def started_elsewhere(at: float, off: Sequence[float] | FloatArray) -> str:
    """Return in words how far attitude, rad, and ω, rad/s, are off at a time, s."""
    turned, faster = (0.0 if size < FITS else float(size) for size in off)
    return (
        f"it started elsewhere: at t = {at:g} s the attitude is off by {np.degrees(turned):.3g}° "
        f"and ω by {faster:.3g} rad/s"
    )


def _mistaken(scenario: Scenario, first: FloatArray) -> str:
    """Return in words how a scene's start was read wrongly; empty if no such mistake made it.

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
    for off, unit in (turned, 1.0), (faster, rate):
        best = min(off, key=off.__getitem__)
        if off[best] > FITS * unit:
            return ""
        words += [best] if best else []
    return f"it started elsewhere: {', and '.join(words)}" if words else ""


def _attitudes(scenario: Scenario) -> Iterator[tuple[str, FloatArray]]:
    """Yield the attitude of the scene's start, and what it is if read otherwise, in words."""
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
    """Yield ω of the scene's start, rad/s, and what it is if it is read otherwise, in words."""
    omega, R_world_body = scenario.start.omega_body, matrix(scenario.start.q_world_body_wxyz)
    yield "", omega
    yield "its ω along world axes is taken to be along body axes", R_world_body @ omega
    yield "its ω along body axes is taken to be along world axes", R_world_body.T @ omega
    yield "its ω in rad/s is taken to be in degrees a second", np.radians(omega)
    yield "its ω has the other sign", -omega
