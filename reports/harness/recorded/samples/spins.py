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
    """Return the sentence that spins are not those that follow from the recorded ω; often none.

    Parameters
    ----------
    exact, motion : the exact and the recorded motion, at the recording's times
    timestep : the timestep that the motion was computed with, s; None if unknown
    """
    if (recorded := recording.arrays.get("spins")) is None:
        return []
    spins = scenario.spins(motion.omega_body, scenario.kept_at_start)
    step = float(np.diff(exact.t).max())
    h = min(timestep or step, step)
    # A method of order 1 is late by one step.
    late = float(norms(np.diff(exact.spins, axis=0)).max()) * h / step
    rounding = rounding_of(recorded, RATES, len(exact.t) * step / h)
    size = float(norms(exact.spins).max())
    is_off = "the spins are not those of the motion: they are"
    return far_off(is_off, "rad/s", recorded - spins, late, rounding, size)
