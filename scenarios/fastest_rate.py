"""How fast a motion is: the rate against which a timestep is small or large."""

import numpy as np

from .float_array import FloatArray
from .scenario import Scenario


def fastest_rate(scenario: Scenario, omega_body: FloatArray) -> float:
    """Return the fastest rate at which a scene's state can change, rad/s.

    It is the largest of |ω| and the rates of effects, such as that of a small swing under gravity.
    Euler's equations have no faster rate: as the moments obey the triangle inequality,
    |I₁ − I₂| ≤ I₃, their coefficients are at most |ω| (Landau & Lifshitz, Mechanics, §36).

    Parameters
    ----------
    omega_body : ω, rad/s, body axes, in one state, (3,), or in n states of the motion, (n, 3)
    """
    spin = float(np.linalg.norm(omega_body, axis=-1).max())
    return max(spin, *(effect.rate(scenario) for effect in scenario.acting), 0.0)


def decay_rate(scenario: Scenario) -> float:
    """Return the sum of the fastest rates at which a scene's effects slow the body, 1/s."""
    return sum(effect.decay(scenario) for effect in scenario.acting)
