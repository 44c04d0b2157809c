"""L and energy of a trajectory, computed by the same code for the reference and for engines."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from .effects.effect import Along, Effect, Scene
from .float_array import FloatArray
from .rotation import cross
from .trajectory import Trajectory

#: Number of motions whose L and energy are kept: errors, drifts and judgements all ask for them.
RECENT = 16
#: After a blow-up, terms may be too large for a double.
IN_BLOW_UPS = np.errstate(over="ignore", invalid="ignore")


@lru_cache(maxsize=RECENT)
@IN_BLOW_UPS
def angular_momentum_world(scenario: Scene, motion: Trajectory) -> FloatArray:
    """Return L about the pivot, or about the com without one, kg m²/s, (n, 3), read-only.

    L = R (I_com ω + h), with h the angular momentum of rotors, plus m r × v of the com if there is
    a pivot (Goldstein, Classical Mechanics, eq. 1.28: L of the centre of mass plus L about it). It
    is computed at the motion's n samples.
    """
    body = scenario.body
    rigid = motion.omega_body @ body.inertia_com
    L_body = _with_effects(scenario, motion, rigid, lambda effect: effect.momentum_body)
    L_world = motion.to_world(L_body)
    if not scenario.constraint.is_pivot:
        return _readonly(L_world)
    momentum_world = body.mass * motion.velocity_world
    return _readonly(L_world + cross(motion.com_world, momentum_world))


@IN_BLOW_UPS
def kinetic_energy(scenario: Scene, motion: Trajectory) -> FloatArray:
    """Return T = ½ m v² + ½ ω·I_com ω plus the energy of rotors, at n samples, J, (n,).

    The samples are those of the motion. The formulas are Goldstein, eq. 1.31 and 5.16.
    """
    body = scenario.body
    omega = motion.omega_body
    rotation: FloatArray = np.einsum("ni,ij,nj->n", omega, body.inertia_com, omega)
    speed_squared: FloatArray = np.einsum("ni,ni->n", motion.velocity_world, motion.velocity_world)
    rigid = 0.5 * (rotation + body.mass * speed_squared)
    return _with_effects(scenario, motion, rigid, lambda effect: effect.kinetic)


@IN_BLOW_UPS
def potential_energy(scenario: Scene, motion: Trajectory) -> FloatArray:
    """Return V, the sum of the potentials of all effects that have one, at n samples, J, (n,)."""
    return _with_effects(scenario, motion, np.zeros(len(motion.t)), lambda effect: effect.potential)


@lru_cache(maxsize=RECENT)
@IN_BLOW_UPS
def energy(scenario: Scene, motion: Trajectory) -> FloatArray:
    """Return kinetic plus potential energy at a motion's n samples, J, (n,), read-only."""
    return _readonly(kinetic_energy(scenario, motion) + potential_energy(scenario, motion))


def energy_base(scenario: Scene, motion: Trajectory) -> float:
    """Return the energy that errors of energy are relative to: max T + m |g| max |r_com|, J.

    T is the kinetic energy, r_com the com's position; maxima are over the samples.
    """
    height = np.linalg.norm(motion.com_world, axis=1).max()
    weight = scenario.body.mass * np.linalg.norm(scenario.gravity_world)
    return float(kinetic_energy(scenario, motion).max() + weight * height)


def _with_effects(
    scenario: Scene,
    motion: Trajectory,
    total: FloatArray,
    term_of: Callable[[Effect], Along | None],
) -> FloatArray:
    """Return `total` plus the term that each effect of the scene adds, if it has one.

    Parameters
    ----------
    total : a quantity of the body along the motion, SI, one row for each sample
    term_of : returns the function that computes an effect's term; None if the effect has none
    """
    for effect in scenario.acting:
        if (term := term_of(effect)) is not None:
            total = total + term(scenario, motion)
    return total


def _readonly(values: FloatArray) -> FloatArray:
    values.setflags(write=False)
    return values
