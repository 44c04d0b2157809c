"""Checks whether the rotors of a recorded motion conserve what their hinges make constant.

A rotor on a free hinge has a constant angular momentum about its axle, others a constant spin.
"""

import numpy as np
from scipy.special import ndtri

from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import norms
from ...explaining.search import SIGNIFICANCE


def spins_beyond(
    scenario: Scenario, motion: Trajectory, timestep: float | None, order: int, noise: FloatArray
) -> list[str]:
    """Return a list of the sentence that a spin changes otherwise than its rotor's hinge allows.

    A hinge keeps the spin constant, or the rotor's angular momentum about its axle. The list is
    empty if no spin deviates from that by more than noise and a method's error. The error of a
    method of order p is taken to be proportional to the p-th power of the angle turned in a step,
    by the body or by the rotor, whichever is faster.

    Parameters
    ----------
    motion : the recorded motion
    timestep : timestep with which the motion was computed, s; if None, it is unknown, and the time
        between samples is used
    order : order of accuracy of the method that computed the motion
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,); spins have the same relative
        noise as ω
    """
    if not motion.spins.size:
        return []
    omega_body, spins, spans = motion.omega_body, motion.spins, np.diff(motion.t)[:, None]
    kept = scenario.kept(omega_body, spins)
    excess = spins[1:] - scenario.spins(omega_body[1:], kept[:-1])
    speed = float(norms(omega_body).max()) or 1.0
    fastest = max(speed, float(np.abs(spins).max()))
    angles = fastest * np.minimum(spans, timestep or np.inf)
    of_method = np.minimum(1.0, angles) ** order * speed * spans * fastest / 2
    scale = np.hypot(of_method, noise[1] * fastest / speed)
    if np.abs(excess / scale).max() < -ndtri(SIGNIFICANCE / excess.size / 2):
        return []
    k, rotor = np.unravel_index(np.argmax(np.abs(excess / scale)), excess.shape)
    return [
        f"the spin of rotor {rotor + 1} changes at a rate of {excess[k, rotor] / spans[k, 0]:.3g} "
        f"rad/s² at t = {motion.t[k + 1]:.4g} s beyond what its hinge makes it"
    ]


def keeps_momentum_of_start(scenario: Scenario) -> bool:
    """Return whether any rotor is on a free hinge; its momentum then depends on ω at the start."""
    return bool(scenario.rotors.is_free.any())
