"""The free top: stability of its axes, cones of a symmetric body, tumbling of an asymmetric one.

Moments are principal and about the fixed point, ω is along the same axes. Everything is evaluated
in extended precision: near the separatrix L² − 2 E I2 is a small difference of large numbers.
"""

from mpmath import mp, mpf

from ..scenarios.exact import DIGITS, Vector
from .symmetry import equal


def perturbation_rate_squared(moments: Vector, axis: int, rate: float) -> float:
    """Return λ² of small deviations e^{λt} from rotation about a principal axis, s⁻².

    Euler's equations linearised about ω_k = `rate` give
    λ² = ω_k² (I_k − I_i)(I_j − I_k)/(I_i I_j) (Landau & Lifshitz, Mechanics, §37; Goldstein §5.6).
    About the middle axis it is positive, and deviations grow at the rate λ; about the other two it
    is negative, and they oscillate at |λ|; it is 0 where I_k equals another moment.

    Parameters
    ----------
    moments : principal moments, kg m²
    axis : k, 0 to 2
    rate : ω_k, rad/s
    """
    with mp.workdps(DIGITS):
        I_k, I_i, I_j = (moments[(axis + shift) % 3] for shift in range(3))
        return float(mpf(rate) ** 2 * (I_k - I_i) * (I_j - I_k) / (I_i * I_j))


def body_cone_rate(I1: float, I3: float, omega3: float) -> float:
    """Return the rate at which ω goes round a free symmetric body's axis, seen in the body, rad/s.

    ω1 + iω2 ∝ exp(iΩt) with Ω = (I3 − I1)/I1 ω3 (Goldstein §5.6; the Chandler wobble is the
    Earth's).

    Parameters
    ----------
    I1, I3 : moments across and about the axis, kg m²
    omega3 : ω about the axis, rad/s
    """
    with mp.workdps(DIGITS):
        return float((mpf(I3) - I1) / I1 * omega3)


def separatrix_distance(moments: Vector, omega: Vector) -> float:
    """Return (L² − 2 E I2)/L², with I2 the middle moment: 0 on the separatrix, and at rest.

    L is the angular momentum and E the kinetic energy. If the result is positive, ω circulates
    about the axis of the largest moment, if negative about that of the smallest (Landau & Lifshitz,
    Mechanics, §37).

    Parameters
    ----------
    moments : principal moments, kg m²
    omega : ω along the principal axes, rad/s
    """
    with mp.workdps(DIGITS):
        square = mp.fsum((moment * w) ** 2 for moment, w in zip(moments, omega, strict=True))
        return float(_excess(moments, omega, sorted(moments)[1]) / square) if square else 0.0


def tumbling_period(moments: Vector, omega: Vector) -> float | None:
    """Return the period 4K/p of ω(t) of a free asymmetric body, s; the body flips twice in it.

    K is the quarter period of Jacobi's functions and k' their complementary modulus:
    p² = (I3 − I2)(L² − 2 E I1)/(I1 I2 I3) and p² k'² = (I3 − I1)(L² − 2 E I2)/(I1 I2 I3), where 2
    is the middle axis and 3 the one that ω circulates about (Landau & Lifshitz §37, eq. 37.8–12);
    by Carlson, 4K/p = 4 R_F(0, p² k'², p²) (DLMF 19.25.1). In the limit of rotation about the axis
    of the largest or the smallest moment it is the period of a small wobble.

    Parameters
    ----------
    moments : principal moments, kg m²
    omega : ω along the principal axes, rad/s

    Returns
    -------
    inf on the separatrix and for rotation about the middle axis; None at rest and for a body with
    two equal moments.
    """
    with mp.workdps(DIGITS):
        low, middle, high = sorted(range(3), key=lambda k: moments[k])
        if equal(moments[low], moments[middle]) or equal(moments[middle], moments[high]):
            return None
        if not any(omega):
            return None
        excess = _excess(moments, omega, moments[middle])
        other, around = (low, high) if excess > 0 else (high, low)
        product = moments[0] * moments[1] * moments[2]
        p_squared = (moments[around] - moments[middle]) * _excess(moments, omega, moments[other])
        complement = (moments[around] - moments[other]) * excess
        if equal(complement, 0, p_squared):
            return float("inf")
        return float(4 * mp.elliprf(0, complement / product, p_squared / product))


def _excess(moments: Vector, omega: Vector, of: mpf) -> mpf:
    """Return L² − 2 E I for one of the principal moments I, kg² m⁴/s².

    L is the angular momentum, and E the kinetic energy. The result is summed axis by axis, so that
    the axis of this moment drops out exactly.

    Parameters
    ----------
    moments : principal moments, kg m²
    omega : ω along the principal axes, rad/s
    of : the moment I, one of `moments`
    """
    return mp.fsum(moment * (moment - of) * w**2 for moment, w in zip(moments, omega, strict=True))
