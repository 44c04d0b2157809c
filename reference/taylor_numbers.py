"""What the recurrences of a Taylor series ask of a number: a double, a double-double, or a dual.

A table of numbers is one array, or two: (high parts, low parts). A `Dual` has a table or number of
either kind with its derivative by one parameter (R. E. Wengert, Commun. ACM 7 (1964) 463). Each
function here has a body for doubles, another for pairs and one for duals, and numba picks one by
type when it compiles: a recurrence is written once, runs at full speed in every arithmetic, and is
never differentiated by hand.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from numba import types
from numba.extending import overload

from .doubledouble import DoubleDouble, dd_add, dd_mul, dd_neg, fma, two_prod, two_sum
from .kernel import kernel

Number = Any
Table = Any


class Dual(NamedTuple):
    """A number, or a table of them, and its derivative by one parameter."""

    value: Any
    tangent: Any


def for_pairs(
    in_double_double: Callable[..., Any], in_duals: Callable[..., Any]
) -> Callable[[Any], Any]:
    """Let compiled code run other functions where the first argument is made of pairs, or duals."""

    def decorate(in_double: Any) -> Any:
        def choose(first: types.Type, *_: types.Type) -> Callable[..., Any]:
            if isinstance(first, types.BaseNamedTuple):
                return in_duals
            double = isinstance(first, types.Array | types.Float)
            chosen: Callable[..., Any] = in_double if double else in_double_double
            return chosen

        overload(in_double, strict=False)(choose)
        return in_double

    return decorate


@for_pairs(
    lambda table, row, column: (table[0][row, column], table[1][row, column]),
    lambda table, row, column: Dual(
        load(table.value, row, column), load(table.tangent, row, column)
    ),
)
def load(table: Table, row: int, column: int) -> Number:
    """Return one number of a table."""
    return table[row, column]


def _store_pair(table: Table, row: int, column: int, x: DoubleDouble) -> None:
    table[0][row, column] = x[0]
    table[1][row, column] = x[1]


def _store_dual(table: Dual, row: int, column: int, x: Dual) -> None:
    store(table.value, row, column, x.value)
    store(table.tangent, row, column, x.tangent)


@for_pairs(_store_pair, _store_dual)
def store(table: Table, row: int, column: int, x: Number) -> None:
    """Write one number of a table."""
    table[row, column] = x


@for_pairs(lambda table: table[0], lambda table: high(table.value))
def high(table: Table) -> Table:
    """Return the table of doubles that comes nearest."""
    return table


@for_pairs(lambda _: (0.0, 0.0), lambda table: Dual(zero(table.value), zero(table.tangent)))
def zero(_: Table) -> Number:
    """Return 0 as a number of a table."""
    return 0.0


@for_pairs(
    lambda a, b: dd_add(a, b),
    lambda a, b: Dual(add(a.value, b.value), add(a.tangent, b.tangent)),
)
def add(a: Number, b: Number) -> Number:
    """Return a + b."""
    return a + b


@for_pairs(
    lambda a, b: dd_mul(a, b),
    lambda a, b: Dual(
        multiply(a.value, b.value), add(multiply(a.value, b.tangent), multiply(a.tangent, b.value))
    ),
)
def multiply(a: Number, b: Number) -> Number:
    """Return a b."""
    return a * b


@kernel
def _reciprocal(a: DoubleDouble) -> DoubleDouble:
    guess = (1.0 / a[0], 0.0)
    left = dd_add((1.0, 0.0), dd_neg(dd_mul(a, guess)))
    return dd_add(guess, dd_mul(left, guess))


@kernel
def _reciprocal_of_dual(a: Dual) -> Dual:
    inverse = reciprocal(a.value)
    return Dual(inverse, negative(multiply(multiply(inverse, inverse), a.tangent)))


@for_pairs(lambda a: _reciprocal(a), lambda a: _reciprocal_of_dual(a))
def reciprocal(a: Number) -> Number:
    """Return 1/a; a pair's by a step of Newton's method from the double."""
    return 1.0 / a


@for_pairs(lambda a: dd_neg(a), lambda a: Dual(negative(a.value), negative(a.tangent)))
def negative(a: Number) -> Number:
    """Return -a."""
    return -a


@kernel
def _add_product(total: DoubleDouble, a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    p, e = two_prod(a[0], b[0])
    s, f = two_sum(total[0], p)
    return s, total[1] + fma(a[0], b[1], fma(a[1], b[0], e + f))


@for_pairs(
    lambda total, a, b: _add_product(total, a, b),
    lambda total, a, b: Dual(
        add_product(total.value, a.value, b.value),
        add_product(add_product(total.tangent, a.value, b.tangent), a.tangent, b.value),
    ),
)
def add_product(total: Number, a: Number, b: Number) -> Number:
    """Return total + a b, to be finished by `rounded`.

    In double-double the rounding errors are summed beside the sum, not folded in term by term:
    a dot product in twice the working precision, at half the work of sums of products and with
    an error bound of n u² times the sum of sizes (Ogita, Rump & Oishi 2005, algorithm 5.3).
    """
    return fma(a, b, total)


@for_pairs(
    lambda total: two_sum(total[0], total[1]),
    lambda total: Dual(rounded(total.value), rounded(total.tangent)),
)
def rounded(total: Number) -> Number:
    """Return the sum that `add_product` built, as a number."""
    return total
