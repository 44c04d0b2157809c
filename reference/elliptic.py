"""Elliptic integrals, theta and Jacobi functions in extended precision, at any modulus.

The parameter m = k² and its complement m1 = 1 − m are both given, since subtracting either from 1
would lose digits of the other. Theta functions are summed with the nome q where m <= 1/2 and, by
Jacobi's imaginary transformation, with q' where m > 1/2: the nome in use never exceeds e^−π, and
m1 = 0, the separatrix, is a case like any other, q' = 0.

Sources: NIST Digital Library of Mathematical Functions (DLMF) chapters 19, 20, 22; D. F. Lawden,
Elliptic Functions and Applications (1989), chapters 1 and 2.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from mpmath import mp, mpc, mpf

#: Number of harmonics of a series. Harmonic k is at most nome^(k²) times the first, and a nome at
#: most e^(−π/2), that of the doubled lattice: the terms left out are below e^(−π/2·12²) = 6e-99.
TERMS = 12

#: Kinds of harmonics of a real series; in a hyperbolic series, sine and cosine mean sinh and cosh.
ODD_SINE, ODD_COSINE, EVEN_SINE, EVEN_COSINE = range(4)


@dataclass(frozen=True)
class Lattice:
    """The periods of the elliptic functions of parameter m.

    They are computed at first use, in the working precision that mpmath has then.

    Attributes
    ----------
    m, m1 : parameter and complementary parameter, in [0, 1], each with its own full precision
    """

    m: mpf
    m1: mpf

    @cached_property
    def K(self) -> mpf:
        """Quarter period K(m); inf where m1 = 0."""
        return _quarter_period(self.m1)

    @cached_property
    def K1(self) -> mpf:
        """Quarter period K' = K(m1); inf where m = 0."""
        return _quarter_period(self.m)

    @property
    def hyperbolic(self) -> bool:
        """Whether theta functions are summed as series of sinh and cosh, with the nome q'.

        These converge faster than series of sines and cosines if m > 1/2, and are used then.
        """
        return bool(self.m > self.m1)

    @cached_property
    def nome(self) -> mpf:
        """The nome of the theta series: q = exp(−π K'/K), or q' = exp(−π K/K') if `hyperbolic`.

        See DLMF 20.9.1.
        """
        long, short = (self.K, self.K1) if self.hyperbolic else (self.K1, self.K)
        return mpf(0) if mp.isinf(long) else mp.exp(-mp.pi * long / short)

    @cached_property
    def scale(self) -> mpf:
        """The ratio x/u of the argument x of the theta series to the argument u of sn.

        It is π/2K, or π/2K' if `hyperbolic`.
        """
        return mp.pi / (2 * (self.K1 if self.hyperbolic else self.K))

    @property
    def half_period(self) -> mpf:
        """The half period 2K of sn and cn, as a change of the series' argument x; inf if m1 = 0."""
        return 2 * self.K * self.scale


def first_kind(sin_squared: mpf, cos_squared: mpf, m1: mpf) -> mpf:
    """Return the elliptic integral F(φ | 1 − m1) for φ in [0, π/2], given sin²φ and cos²φ.

    It is computed by Carlson's R_F (DLMF 19.25.5).
    """
    return mp.sqrt(sin_squared) * mp.elliprf(cos_squared, cos_squared + m1 * sin_squared, 1)


class Harmonics(NamedTuple):
    """A series Σ a_k f(j_k x), where a_k are its coefficients.

    `kind` says whether f is a sine or a cosine, and whether j_k is 2k + 1 or 2k.
    """

    kind: int
    coefficients: tuple[mpf, ...]


@dataclass(frozen=True)
class Theta:
    """A theta function of s x − iη as a function of real x, up to a constant factor.

    s is `stretch`. If the series is hyperbolic, the factor exp(−(K'/πK)(s x − iη)²) of Jacobi's
    transformation is left out, too; on the doubled lattice this factor has 2K' in place of K'.

    Attributes
    ----------
    real, imaginary : series of its real and its imaginary part
    hyperbolic : whether the harmonics are sinh and cosh
    stretch : s, the factor of x in the argument of the series
    eta : η of the argument s x − iη
    """

    real: Harmonics
    imaginary: Harmonics
    hyperbolic: bool
    stretch: mpf
    eta: mpf

    def value_and_slope(self, x: mpf) -> tuple[mpc, mpc]:
        """Return the values of this function and of its derivative by x at a real x."""
        value, slope = mpc(0), mpc(0)
        for harmonics, unit in ((self.real, mpc(1)), (self.imaginary, mpc(0, 1))):
            f, df = _sum(harmonics, self.stretch * x, self.hyperbolic)
            value += unit * f
            slope += unit * self.stretch * df
        return value, slope


def theta(n: int, lattice: Lattice, y: mpf = 0, doubled: bool = False) -> Theta:
    """Return θ_n(π(u − iy)/2K, q) as a function of x = lattice.scale · u, up to a factor.

    The factor is left out. It depends on n, being 2 q^(1/4) for θ1 and θ2, so that quotients must
    be normalised, as `jacobi` does; `Theta` says what else is left out. The formulas are DLMF
    20.2.1–4 and 20.7.30–33.

    Parameters
    ----------
    n : which theta function, 1 to 4
    y : shift of the argument along the imaginary axis, in the unit of u
    doubled : whether to use the lattice with 2K' in place of K', whose nome is q² (hyperbolic: √q')
    """
    nome, stretch = lattice.nome, mpf(1)
    if doubled and lattice.hyperbolic:
        nome, stretch = mp.sqrt(nome), mpf(1) / 2
    elif doubled:
        nome = nome**2
    eta = stretch * lattice.scale * y
    odd, alternating, sine = _SERIES[_TRANSFORMED[n] if lattice.hyperbolic else n]
    harmonic = [2 * k + 1 if odd else 2 * k for k in range(TERMS)]
    size = [
        nome ** (k * (k + 1)) if odd else (2 if k else 1) * nome ** (k * k) for k in range(TERMS)
    ]
    a = [(-1) ** k * s if alternating else s for k, s in enumerate(size)]
    # f(j(x − iη)) by the addition theorem: sines and cosines exchange in the imaginary part.
    even_part, odd_part = (mp.cos, mp.sin) if lattice.hyperbolic else (mp.cosh, mp.sinh)
    sign = -1 if sine or lattice.hyperbolic else 1
    real = tuple(c * even_part(j * eta) for c, j in zip(a, harmonic, strict=True))
    imaginary = tuple(sign * c * odd_part(j * eta) for c, j in zip(a, harmonic, strict=True))
    sines, cosines = (ODD_SINE, ODD_COSINE) if odd else (EVEN_SINE, EVEN_COSINE)
    kinds = (sines, cosines) if sine else (cosines, sines)
    return Theta(
        Harmonics(kinds[0], real), Harmonics(kinds[1], imaginary), lattice.hyperbolic, stretch, eta
    )


@dataclass(frozen=True)
class Jacobi:
    """sn, cn and dn as quotients of real theta functions of x (DLMF 22.2.4–6).

    Attributes
    ----------
    sn, cn, dn : numerators, scaled so that sn'(0) = cn(0) = dn(0) = 1
    denominator : θ4
    """

    sn: Harmonics
    cn: Harmonics
    dn: Harmonics
    denominator: Theta

    def __call__(self, x: mpf) -> tuple[mpf, mpf, mpf]:
        """Return sn, cn and dn at real x = lattice.scale · u."""
        hyperbolic = self.denominator.hyperbolic
        below, _ = self.denominator.value_and_slope(x)
        sn, cn, dn = (
            _sum(numerator, x, hyperbolic)[0] / below.real
            for numerator in (self.sn, self.cn, self.dn)
        )
        return sn, cn, dn


def jacobi(lattice: Lattice) -> Jacobi:
    """Return the standard Jacobi functions sn, cn and dn whose periods are those of a lattice."""
    below = theta(4, lattice)
    at_zero = below.value_and_slope(mpf(0))[0].real
    first, second, third = (theta(n, lattice) for n in (1, 2, 3))
    slope = first.value_and_slope(mpf(0))[1].real * lattice.scale
    return Jacobi(
        scaled(first.real, at_zero / slope),
        scaled(second.real, at_zero / second.value_and_slope(mpf(0))[0].real),
        scaled(third.real, at_zero / third.value_and_slope(mpf(0))[0].real),
        below,
    )


def scaled(harmonics: Harmonics, factor: mpf) -> Harmonics:
    """Return a real series with all its coefficients multiplied by a factor."""
    return Harmonics(harmonics.kind, tuple(factor * a for a in harmonics.coefficients))


# For θ1 to θ4 with nome q: whether the harmonics are odd, whether their signs alternate, whether
# they are sines.
_SERIES = {
    1: (True, True, True),
    2: (True, False, False),
    3: (False, False, False),
    4: (False, True, False),
}
# Jacobi's imaginary transformation exchanges θ2 and θ4 and makes circular functions hyperbolic.
_TRANSFORMED = {1: 1, 2: 4, 3: 3, 4: 2}


def _quarter_period(complement: mpf) -> mpf:
    """Return the quarter period K = π/2 AGM(1, √(1 − m)), given 1 − m (DLMF 19.8.5)."""
    return mp.pi / (2 * mp.agm(1, mp.sqrt(complement))) if complement else mp.inf


def _sum(harmonics: Harmonics, x: mpf, hyperbolic: bool) -> tuple[mpf, mpf]:
    """Return the value of a real series, and that of its derivative, at x.

    If `hyperbolic`, the harmonics are sinh and cosh.
    """
    sine: Callable[[mpf], mpf] = mp.sinh if hyperbolic else mp.sin
    cosine: Callable[[mpf], mpf] = mp.cosh if hyperbolic else mp.cos
    kind = harmonics.kind
    is_sine = kind in (ODD_SINE, EVEN_SINE)
    first = 1 if kind in (ODD_SINE, ODD_COSINE) else 0
    turned = 1 if is_sine or hyperbolic else -1
    f, other = (sine, cosine) if is_sine else (cosine, sine)
    value, slope = mpf(0), mpf(0)
    for k, a in enumerate(harmonics.coefficients):
        if a:
            j = first + 2 * k
            value += a * f(j * x)
            slope += turned * a * j * other(j * x)
    return value, slope
