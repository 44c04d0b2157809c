"""A body with two equal moments that nothing acts on: a turn about L, and one about its own axis.

(Landau & Lifshitz, Mechanics, §33; with rotors along the axis: Wittenburg, §4.6.)
"""

from mpmath import mp, mpf
from spincheck.scenarios.exact import Quaternion, Vector, conjugate, dot, product, rotate


def turn(vector: Vector, angle: mpf) -> Quaternion:
    """The quaternion of a turn about a vector of any length."""
    length = mp.sqrt(dot(vector, vector))
    x, y, z = (mp.sin(angle / 2) * c / length for c in vector)
    return (mp.cos(angle / 2), x, y, z)


def two_turns(
    across: mpf, L: Vector, q: Quaternion, omega: Vector, odd: int, t: mpf
) -> tuple[Quaternion, Vector]:
    """q(t) = exp(L t/2 I1) q(0) exp(e3 (ω3 − L3/I1) t/2) and ω(t), in the precision of the caller.

    Parameters
    ----------
    across : I1, kg m²
    L : angular momentum at the start along the body's axes, that of its rotors in it, kg m²/s
    odd : the axis of the other moment
    """
    axis = tuple(mpf(int(k == odd)) for k in range(3))
    own = turn(axis, (omega[odd] - L[odd] / across) * t)
    about_L = turn(rotate(q, L), mp.sqrt(dot(L, L)) * t / across)
    return product(product(about_L, q), own), rotate(conjugate(own), omega)
