"""The operations on numbers in recurrences of a Taylor series, for doubles and double-doubles.

Numbers are held in a table: one array of doubles, or two arrays, high and low parts of
double-doubles ("pairs"). Each function here has a body for doubles and another for pairs, and numba
picks one by type when it compiles. So a recurrence is written once and runs at full speed in either
arithmetic. `dual_numbers` adds bodies for duals.
"""

from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import overload

from .doubledouble import DoubleDouble, dd_add, dd_mul, dd_neg, fma, two_prod, two_sum
from .kernel import OPTIONS, kernel

Number = Any
Table = Any

#: The bodies for duals, by the body for doubles.
FOR_DUALS: dict[Callable[..., Any], Callable[..., Any]] = {}


def for_pairs(in_double_double: Callable[..., Any]) -> Callable[[Any], Any]:
    """Return a decorator for a function on doubles, for which compiled code may run another one.

    Compiled code calls the decorated function by name. What is run depends on the first argument
    of the call, a number or a table: for double-doubles (pairs) it is `in_double_double`, for dual
    numbers the function in `FOR_DUALS`, and for doubles the decorated function itself.

    Parameters
    ----------
    in_double_double : the function that does the same with double-doubles
    """

    def decorate(in_double: Any) -> Any:
        def choose(first: types.Type, *_: types.Type) -> Callable[..., Any]:
            if isinstance(first, types.BaseNamedTuple):
                return FOR_DUALS[in_double]
            double = isinstance(first, types.Array | types.Float)
            chosen: Callable[..., Any] = in_double if double else in_double_double
            return chosen

        overload(in_double, strict=False, jit_options=OPTIONS)(choose)
        return in_double

    return decorate


@for_pairs(lambda table, row, column: (table[0][row, column], table[1][row, column]))
def load(table: Table, row: int, column: int) -> Number:
    """Return one number of a table."""
    return table[row, column]


def _store_pair(table: Table, row: int, column: int, x: DoubleDouble) -> None:
    table[0][row, column] = x[0]
    table[1][row, column] = x[1]


@for_pairs(_store_pair)
def store(table: Table, row: int, column: int, x: Number) -> None:
    """Write one number of a table."""
    table[row, column] = x


@for_pairs(lambda table, row, column: table[0][row, column])
def load_double(table: Table, row: int, column: int) -> float:
    """Return the double that is nearest to one number of a table."""
    return float(table[row, column])


@for_pairs(lambda _: (0.0, 0.0))
def zero(_: Table) -> Number:
    """Return 0 in the arithmetic of the numbers of the table `_`, whose values are not used."""
    return 0.0


@for_pairs(lambda a, b: dd_add(a, b))
def add(a: Number, b: Number) -> Number:
    """Return a + b."""
    return a + b


@for_pairs(lambda a, b: dd_mul(a, b))
def multiply(a: Number, b: Number) -> Number:
    """Return a b."""
    return a * b


@kernel
def _reciprocal(a: DoubleDouble) -> DoubleDouble:
    guess = (1.0 / a[0], 0.0)
    left = dd_add((1.0, 0.0), dd_neg(dd_mul(a, guess)))
    return dd_add(guess, dd_mul(left, guess))


@for_pairs(lambda a: _reciprocal(a))
def reciprocal(a: Number) -> Number:
    """Return 1/a; for a pair by one step of Newton's method from the double-precision result."""
    return 1.0 / a


@for_pairs(lambda a: dd_neg(a))
def negative(a: Number) -> Number:
    """Return −a."""
    return -a


@kernel
def _add_product(total: DoubleDouble, a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    p, e = two_prod(a[0], b[0])
    s, f = two_sum(total[0], p)
    return s, total[1] + fma(a[0], b[1], fma(a[1], b[0], e + f))


@for_pairs(lambda total, a, b: _add_product(total, a, b))
def add_product(total: Number, a: Number, b: Number) -> Number:
    """Return total + a b; after the last product, `rounded` converts the total to a number.

    In double-double the rounding errors are summed apart, and added by `rounded` at the end. This
    is a dot product in twice the working precision. It takes half the work of rounding each term;
    the error of n products is at most n u² times the sum of their sizes, u = 2⁻⁵³ (Ogita, Rump &
    Oishi 2005, algorithm 5.3).
    """
    return fma(a, b, total)


@for_pairs(lambda total: two_sum(total[0], total[1]))
def rounded(total: Number) -> Number:
    """Return the sum that calls of `add_product` have built, as a number."""
    return total
