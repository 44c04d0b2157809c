"""Compares the recorded spins of rotors with those that follow from the recorded ω."""

import numpy as np

from .....scenarios import Scenario, Trajectory
from .....scenarios.rotation import norms
from ..files.recording import RATES, Recording
from .translation import far_off, rounding_of


def other_spins(
    scenario: Scenario,
    exact: Trajectory,
    recording: Recording,
    motion: Trajectory,
    timestep: float | None,
) -> list[str]:
    """Return a list of the sentence that spins are not those that follow from the recorded ω.

    The list is empty if they are, up to a method's error, or if spins were not recorded.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    recording : the recording, from which spins are taken
    motion : the recorded motion
    timestep : timestep with which the motion was computed, s; None if unknown
    """
    if (recorded := recording.arrays.get("spins")) is None:
        return []
    spins = scenario.spins(motion.omega_body, scenario.kept_at_start)
    step = float(np.diff(exact.t).max())
    h = min(timestep or step, step)
    # The spins by a method of order 1 are late by one step at most.
    late = float(norms(np.diff(exact.spins, axis=0)).max()) * h / step
    rounding = rounding_of(recorded, RATES, len(exact.t) * step / h)
    size = float(norms(exact.spins).max())
    is_off = "the spins are not those of the motion: they are"
    return far_off(is_off, "rad/s", recorded - spins, late, rounding, size)
