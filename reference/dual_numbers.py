"""Numbers with their derivative by one parameter, for the recurrences of a Taylor series.

A recurrence that is run on duals also computes the derivatives of its results, term by term: the
variational equations of the motion need no derivation of their own (R. E. Wengert, Commun. ACM 7
(1964) 463). A dual consists of two doubles or two double-doubles, and a table of duals of two
tables.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from .kernel import kernel
from .taylor_numbers import (
    FOR_DUALS,
    Number,
    add,
    add_product,
    load,
    load_double,
    multiply,
    negative,
    reciprocal,
    rounded,
    store,
    zero,
)


class Dual(NamedTuple):
    """A number, or a table of numbers, and its derivative by one parameter.

    Attributes
    ----------
    value : the number or table: doubles, or pairs of high and low parts
    tangent : its derivative, of the same type
    """

    value: Any
    tangent: Any


def of_duals(in_double: Any) -> Callable[[Any], Any]:
    """Return a decorator for a function on dual numbers that stands in for `in_double`.

    Compiled code calls `in_double` by name. If the first argument of the call is a `Dual`, the
    decorated function runs instead.

    Parameters
    ----------
    in_double : the function that does the same with doubles
    """

    def decorate(in_duals: Any) -> Any:
        FOR_DUALS[in_double] = in_duals
        return in_duals

    return decorate


@of_duals(load)
def _load(table: Dual, row: int, column: int) -> Dual:
    return Dual(load(table.value, row, column), load(table.tangent, row, column))


@of_duals(store)
def _store(table: Dual, row: int, column: int, x: Dual) -> None:
    store(table.value, row, column, x.value)
    store(table.tangent, row, column, x.tangent)


@of_duals(load_double)
def _load_double(table: Dual, row: int, column: int) -> float:
    return float(load_double(table.value, row, column))


@of_duals(zero)
def _zero(table: Dual) -> Dual:
    return Dual(zero(table.value), zero(table.tangent))


@of_duals(add)
def _add(a: Dual, b: Dual) -> Dual:
    return Dual(add(a.value, b.value), add(a.tangent, b.tangent))


@of_duals(multiply)
def _multiply(a: Dual, b: Dual) -> Dual:
    tangent = add(multiply(a.value, b.tangent), multiply(a.tangent, b.value))
    return Dual(multiply(a.value, b.value), tangent)


@kernel
def _slope(inverse: Number, tangent: Number) -> Number:
    return negative(multiply(multiply(inverse, inverse), tangent))


@of_duals(reciprocal)
def _reciprocal(a: Dual) -> Dual:
    inverse = reciprocal(a.value)
    return Dual(inverse, _slope(inverse, a.tangent))


@of_duals(negative)
def _negative(a: Dual) -> Dual:
    return Dual(negative(a.value), negative(a.tangent))


@of_duals(add_product)
def _add_product(total: Dual, a: Dual, b: Dual) -> Dual:
    tangent = add_product(add_product(total.tangent, a.value, b.tangent), a.tangent, b.value)
    return Dual(add_product(total.value, a.value, b.value), tangent)


@of_duals(rounded)
def _rounded(total: Dual) -> Dual:
    return Dual(rounded(total.value), rounded(total.tangent))
