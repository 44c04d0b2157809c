"""A body with two equal moments that nothing acts on: a turn about L, and one about its own axis.

(Landau & Lifshitz, Mechanics, §33.)
"""

from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.scenarios.exact import Quaternion, Vector, conjugate, dot, product, rotate


def two_turns(p: Problem, odd: int, t: mpf) -> tuple[Quaternion, Vector]:
    """q(t) = exp(L t/2 I1) q(0) exp(e3 ω3 (1 − I3/I1) t/2) and ω(t), in the caller's precision.

    Parameters
    ----------
    odd : the axis of the other moment
    """
    across, along = p.moments[odd - 1], p.moments[odd]
    L = tuple(i * w for i, w in zip(p.moments, p.omega_axes, strict=True))
    axis = tuple(mpf(int(k == odd)) for k in range(3))
    own = _turn(axis, p.omega_axes[odd] * (1 - along / across) * t)
    about_L = _turn(rotate(p.q_world_axes, L), mp.sqrt(dot(L, L)) * t / across)
    return product(product(about_L, p.q_world_axes), own), rotate(conjugate(own), p.omega_axes)


def _turn(vector: Vector, angle: mpf) -> Quaternion:
    """A turn about a vector of any length."""
    length = mp.sqrt(dot(vector, vector))
    x, y, z = (mp.sin(angle / 2) * c / length for c in vector)
    return (mp.cos(angle / 2), x, y, z)
