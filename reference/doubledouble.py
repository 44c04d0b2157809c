"""Double-double arithmetic for numba: a number is the unevaluated sum of two doubles.

A pair ``(hi, lo)`` with ``|lo| <= ulp(hi) / 2`` carries about 106 bits. Kernels whose names begin
with ``dd_`` take such pairs, the others take doubles; all return pairs, can be called from Python
or from other numba kernels, and allocate nothing. None may be compiled with ``fastmath``: the
compiler would cancel the error terms.

Sources: T. J. Dekker, "A floating-point technique for extending the available precision",
Numer. Math. 18 (1971) 224-242; T. Ogita, S. M. Rump & S. Oishi, "Accurate sum and dot product",
SIAM J. Sci. Comput. 26 (2005) 1955-1988; M. Joldes, J.-M. Muller & V. Popescu, "Tight and rigorous
error bounds for basic building blocks of double-word arithmetic", ACM Trans. Math. Softw. 44 (2017)
15res. The bounds below are on the relative error, with u = 2⁻⁵³, and hold short of overflow and
underflow.
"""

from fractions import Fraction
from typing import Any

from llvmlite import ir
from mpmath import mpf, workprec
from numba import types
from numba.extending import intrinsic

from .kernel import kernel

DoubleDouble = tuple[float, float]

# Precision in which the difference of any two doubles is exact: their bits span 2⁻¹⁰⁷⁴ to 2¹⁰²³.
_EXACT_BITS = 2200


def _fma(_context: Any, x: Any, y: Any, z: Any) -> Any:
    """Return for numba the signature and code generator of x y + z, rounded once.

    This is fusedMultiplyAdd of IEEE 754-2008, section 5.4.1. x, y and z are numba's types of the
    arguments; its context of typing, `_context`, is not used.
    """

    def generate(_: Any, builder: ir.IRBuilder, __: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(x, y, z), generate


# The LLVM instruction itself: LLVM never splits it, and the C library supplies it where the
# processor has none.
fma: Any = intrinsic(_fma)


@kernel
def two_sum(a: float, b: float) -> DoubleDouble:
    """Return a + b and its rounding error, for any a, b (Ogita, Rump & Oishi, algorithm 3.1)."""
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


@kernel
def quick_two_sum(a: float, b: float) -> DoubleDouble:
    """Return a + b and its rounding error, for a = 0 or |a| >= |b| (Dekker)."""
    s = a + b
    return s, b - (s - a)


@kernel
def two_prod(a: float, b: float) -> DoubleDouble:
    """Return a b and its rounding error (Ogita, Rump & Oishi, algorithm 3.5)."""
    p = a * b
    return p, fma(a, b, -p)


@kernel
def dd_neg(a: DoubleDouble) -> DoubleDouble:
    """Return −a, which is exact."""
    return -a[0], -a[1]


@kernel
def dd_add(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """Return a + b with a relative error of at most 4 u², u = 2⁻⁵³, even where a and b cancel.

    The algorithm is number 6 of Joldes, Muller & Popescu.
    """
    s, e = two_sum(a[0], b[0])
    t, f = two_sum(a[1], b[1])
    s, e = quick_two_sum(s, e + t)
    return quick_two_sum(s, e + f)


@kernel
def dd_mul(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """Return a b with a relative error of at most 7 u², u = 2⁻⁵³.

    It is algorithm 11 of Joldes, Muller & Popescu with fused multiply-adds. The product of the low
    parts, u² at most, is left out; rounding of the two fused operations adds 2 u² and 3 u².
    """
    p, e = two_prod(a[0], b[0])
    return quick_two_sum(p, fma(a[0], b[1], fma(a[1], b[0], e)))


def split(x: mpf | Fraction) -> DoubleDouble:
    """Return the double-double nearest to x, whatever mpmath's working precision."""
    hi = float(x)
    if isinstance(x, Fraction):
        return hi, float(x - Fraction(hi))
    with workprec(_EXACT_BITS):
        return hi, float(x - hi)
