"""Problems for the Taylor integrator, and what its double-doubles are compared in."""

from collections.abc import Sequence

import numpy as np
from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import DoubleDoubleStates, Orders
from spincheck.scenarios.exact import DIGITS, exact, normalised

#: Far more steps than any motion of these tests takes; errors grow at most as their square.
STEPS = 2_000
ORIGIN = (0.0, 0.0, 0.0)
TILTED = (0.96, 0.1, 0.28, -0.2)


def problem(
    moments: Sequence[float],
    omega_axes: Sequence[float],
    q_world_axes: Sequence[float] = TILTED,
    lever_axes: Sequence[float] = ORIGIN,
    gravity_world: Sequence[float] = ORIGIN,
    torque_axes: Sequence[float] = ORIGIN,
    torque_world: Sequence[float] = ORIGIN,
    drag: float = 0.0,
) -> Problem:
    """A problem whose numbers are exactly these, but for the attitude, made of unit norm."""
    with mp.workdps(DIGITS):
        return Problem(
            moments=exact(moments),
            q_world_axes=normalised(exact(q_world_axes)),
            omega_axes=exact(omega_axes),
            lever_axes=exact(lever_axes),
            gravity_world=exact(gravity_world),
            torque_axes=exact(torque_axes),
            torque_world=exact(torque_world),
            drag=mpf(drag),
            q_axes_body=exact((1, 0, 0, 0)),
        )


def q_and_omega(states: DoubleDoubleStates, sample: int) -> tuple[list[mpf], list[mpf]]:
    """All digits of one sample."""
    q = zip(states.q_world_axes[sample], states.q_low[sample], strict=True)
    omega = zip(states.omega_axes[sample], states.omega_low[sample], strict=True)
    with mp.workdps(DIGITS):
        return [mpf(a) + mpf(b) for a, b in q], [mpf(a) + mpf(b) for a, b in omega]


def distance(a: Sequence[mpf], b: Sequence[mpf]) -> float:
    """Largest difference of two vectors over the largest size in the second."""
    apart = max(abs(x - y) for x, y in zip(a, b, strict=True))
    return float(apart / max(abs(y) for y in b))


def apart(one: DoubleDoubleStates, other: DoubleDoubleStates) -> float:
    """Largest difference of two runs in q, and in ω over its size."""
    q = (one.q_world_axes - other.q_world_axes) + (one.q_low - other.q_low)
    omega = (one.omega_axes - other.omega_axes) + (one.omega_low - other.omega_low)
    speed = np.abs(other.omega_axes).max() or 1.0
    return max(float(np.abs(q).max()), float(np.abs(omega).max()) / speed)


def truncation(orders: Orders) -> float:
    """What is left out of every step, e⁻²ᴺ, grown over the steps of a test."""
    return float(STEPS**2 * np.exp(-2.0 * orders.total))
