"""L and energy of a trajectory: one piece of code, for reference and engines alike."""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from .float_array import FloatArray
from .rotation import cross
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .scenario import Scenario

#: Of so many motions L and energy are kept: errors, drifts and judgements all ask for them.
RECENT = 16


@lru_cache(maxsize=RECENT)
def angular_momentum_world(scenario: "Scenario", motion: Trajectory) -> FloatArray:
    """L about the pivot, or the com where there is none, kg m²/s, (n, 3), read-only.

    L = R I_com ω, with what rotors add to I_com ω, and m r × v besides where there is a pivot
    (Goldstein, Classical Mechanics, eq. 1.28: L of the centre of mass plus L about it).
    """
    body = scenario.body
    L_body = motion.omega_body @ body.inertia_com
    if scenario.rotors:
        L_body = L_body + scenario.rotors.momentum_body(motion.spins)
    L_world = motion.to_world(L_body)
    if not scenario.constraint.is_pivot:
        return _readonly(L_world)
    momentum_world = body.mass * motion.velocity_world
    return _readonly(L_world + cross(motion.com_world, momentum_world))


def kinetic_energy(scenario: "Scenario", motion: Trajectory) -> FloatArray:
    """T = ½ m v² + ½ ω·I_com ω, with what rotors add, J, (n,) (Goldstein, eq. 1.31 and 5.16)."""
    body = scenario.body
    omega = motion.omega_body
    rotation: FloatArray = np.einsum("ni,ij,nj->n", omega, body.inertia_com, omega)
    speed_squared: FloatArray = np.einsum("ni,ni->n", motion.velocity_world, motion.velocity_world)
    rigid = 0.5 * (rotation + body.mass * speed_squared)
    return rigid + scenario.rotors.energy(omega, motion.spins) if scenario.rotors else rigid


def potential_energy(scenario: "Scenario", motion: Trajectory) -> FloatArray:
    """V of all effects that have one, J, (n,)."""
    total = np.zeros(len(motion.t))
    for effect in scenario.acting:
        if effect.potential is not None:
            total += effect.potential(scenario, motion.com_world)
    return total


@lru_cache(maxsize=RECENT)
def energy(scenario: "Scenario", motion: Trajectory) -> FloatArray:
    """T + V, J, (n,), read-only."""
    return _readonly(kinetic_energy(scenario, motion) + potential_energy(scenario, motion))


def energy_base(scenario: "Scenario", motion: Trajectory) -> float:
    """The energy that errors in energy are measured against: max T + m |g| max |r_com|, J."""
    height = np.linalg.norm(motion.com_world, axis=1).max()
    weight = scenario.body.mass * np.linalg.norm(scenario.gravity_world)
    return float(kinetic_energy(scenario, motion).max() + weight * height)


def _readonly(values: FloatArray) -> FloatArray:
    values.setflags(write=False)
    return values
