"""Double-doubles against exact fractions: error-free where they say so, else within their bound."""

from fractions import Fraction

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from spincheck.reference.doubledouble import (
    DoubleDouble,
    dd_add,
    dd_mul,
    dd_neg,
    quick_two_sum,
    split,
    two_prod,
    two_sum,
)

U = Fraction(1, 2**53)
#: Products of two of these, and their errors, are normal numbers.
SCALE = 2.0**200

#: The first call of a kernel compiles it.
compiled = settings(deadline=None)

doubles = st.floats(min_value=-SCALE, max_value=SCALE).filter(lambda x: abs(x) > 1 / SCALE)


@st.composite
def double_doubles(draw: st.DrawFn) -> DoubleDouble:
    """Pairs that fill all bits of both parts."""
    hi = draw(doubles)
    return quick_two_sum(hi, hi * draw(st.floats(min_value=-1, max_value=1)) * float(U))


@st.composite
def nearly_opposite(draw: st.DrawFn) -> tuple[DoubleDouble, DoubleDouble]:
    """Two pairs whose sum loses most of its digits."""
    a = draw(double_doubles())
    left = draw(st.floats(min_value=-1, max_value=1)) * 2.0 ** draw(st.integers(-100, -1))
    return a, dd_add(dd_neg(a), (a[0] * left, 0.0))


pairs = st.tuples(double_doubles(), double_doubles()) | nearly_opposite()


def exact(x: DoubleDouble | float) -> Fraction:
    return Fraction(x[0]) + Fraction(x[1]) if isinstance(x, tuple) else Fraction(x)


def within(result: DoubleDouble, exact_value: Fraction, bound: int) -> bool:
    """Whether a result is within a bound, in units of u², of the exact value."""
    return abs(exact(result) - exact_value) <= bound * U**2 * abs(exact_value)


@compiled
@given(doubles, doubles)
def test_two_sum_has_no_error(a: float, b: float) -> None:
    assert exact(two_sum(a, b)) == Fraction(a) + Fraction(b)


@compiled
@given(doubles, doubles)
def test_quick_two_sum_has_no_error_if_the_larger_comes_first(a: float, b: float) -> None:
    large, small = (a, b) if abs(a) >= abs(b) else (b, a)
    assert exact(quick_two_sum(large, small)) == Fraction(a) + Fraction(b)
    assert exact(quick_two_sum(0.0, a)) == Fraction(a)


@compiled
@given(doubles, doubles)
def test_two_prod_has_no_error(a: float, b: float) -> None:
    assert exact(two_prod(a, b)) == Fraction(a) * Fraction(b)


@compiled
@given(pairs)
def test_sums_keep_their_bound_even_where_they_cancel(
    operands: tuple[DoubleDouble, DoubleDouble],
) -> None:
    a, b = operands
    assert within(dd_add(a, b), exact(a) + exact(b), 4)


@compiled
@given(double_doubles(), double_doubles())
def test_products_keep_their_bound(a: DoubleDouble, b: DoubleDouble) -> None:
    assert within(dd_mul(a, b), exact(a) * exact(b), 7)


@compiled
@given(double_doubles(), double_doubles())
def test_a_low_part_left_out_breaks_that_bound(a: DoubleDouble, b: DoubleDouble) -> None:
    assume(abs(a[1]) > abs(a[0]) * 2.0**-80)
    cut = (a[0], 0.0)
    assert not within(dd_mul(cut, b), exact(a) * exact(b), 7)


@compiled
@given(double_doubles(), double_doubles())
def test_results_are_normalised(a: DoubleDouble, b: DoubleDouble) -> None:
    for hi, lo in (dd_add(a, b), dd_mul(a, b)):
        assert hi + lo == hi


@compiled
@given(double_doubles())
def test_split_gives_back_what_a_pair_holds(a: DoubleDouble) -> None:
    assert split(exact(a)) == a
    with mp.workprec(2200):
        x = mpf(a[0]) + mpf(a[1])
    assert split(x) == a


@compiled
@given(st.fractions().filter(lambda x: x == 0 or abs(x) > Fraction(1, 10**30)))
def test_split_is_the_nearest_pair(x: Fraction) -> None:
    assert within(split(x), x, 1)


def test_split_does_not_depend_on_the_working_precision() -> None:
    with mp.workdps(60):
        third = mpf(1) / 3
    coarse = split(third)
    with mp.workdps(60):
        assert split(third) == coarse
        assert (
            abs(mpf(coarse[0]) + mpf(coarse[1]) - third)
            < third * mpf(U.numerator) / U.denominator**2
        )
    assert coarse[1] != 0
