"""How fast a motion is: the rate by which a timestep is small or large for it."""

import numpy as np

from .float_array import FloatArray
from .scenario import Scenario


def fastest_rate(scenario: Scenario, omega_body: FloatArray) -> float:
    """The fastest rate at which a scene's state can change, rad/s.

    The largest of three: |ω|, that of a small swing under gravity, and that at which drag takes
    the spin away. Euler's equations add none: where all moments obey the triangle inequality,
    |I₁ − I₂| ≤ I₃, their coefficients are at most |ω| (Landau & Lifshitz, Mechanics, §36).

    Parameters
    ----------
    omega_body : angular velocities of the motion, rad/s, (3,) or (n, 3)
    """
    spin = float(np.linalg.norm(omega_body, axis=-1).max())
    return max(spin, swing_rate(scenario), damping_rate(scenario))


def damping_rate(scenario: Scenario) -> float:
    """The rate at which drag slows the body about the axis of its least moment, 1/s."""
    body = scenario.body
    inertia = body.inertia_origin if scenario.has_pivot else body.inertia_com
    return scenario.drag * float(np.linalg.norm(np.linalg.inv(inertia), 2))


def swing_rate(scenario: Scenario) -> float:
    """√(m g l / I) for the axis across the lever about which I is least, rad/s; 0 if free.

    Gravity's torque is across the lever, so that the moment about the lever does not count: a
    needle hanging by its end swings slowly, however easily it spins.
    """
    length = float(np.linalg.norm(scenario.body.com))
    if not (scenario.has_pivot and length):
        return 0.0
    inverse = np.asarray(np.linalg.inv(scenario.body.inertia_origin), dtype=float)
    direction = scenario.body.com / length
    across = np.eye(3) - np.outer(direction, direction)
    pull = scenario.body.mass * float(np.linalg.norm(scenario.gravity_world)) * length
    return float(np.sqrt(pull * np.linalg.norm(across @ inverse @ across, 2)))
