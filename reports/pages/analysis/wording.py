"""Formats numbers for the report: significant digits, powers of ten, errors with their limits."""

import math
from collections.abc import Sequence
from decimal import ROUND_DOWN, Decimal

from ....scenarios import SIGNAL, Errors
from ...results.records import Row

#: Text in place of a number that is not known or does not exist.
NOTHING = "—"
#: Numbers from 0.01 up to 1000 are printed without a power of ten.
PLAIN_POWERS = range(-2, 3)
SIGNIFICANT_DIGITS, COMPARED_DIGITS, READABLE_DIGITS = 3, 5, 2
#: Significant digits of a recommended timestep.
TYPED_DIGITS = 2

#: Common step rates, 1/s: their timesteps are printed as fractions, such as 1/240 s.
RATES = range(30, 1000, 30)
UNITS = (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9))

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MINUS = "−"


def number(value: float | None, digits: int = SIGNIFICANT_DIGITS) -> str:
    """Return a number as text with some significant digits: 12.3, 4.56×10⁻⁷, ∞.

    None becomes `NOTHING`, and NaN becomes "undefined".

    Parameters
    ----------
    digits : number of significant digits
    """
    if value is None:
        return NOTHING
    if math.isnan(value):
        return "undefined"
    sign = _MINUS if value < 0 else ""
    if math.isinf(value):
        return f"{sign}∞"
    if value == 0:
        return "0"
    mantissa, _, exponent = f"{abs(value):.{digits - 1}e}".partition("e")
    power = int(exponent)
    if power in PLAIN_POWERS:
        decimals = digits - 1 - power
        return f"{sign}{round(abs(value), decimals):.{max(decimals, 0)}f}"
    return f"{sign}{mantissa}×{power_of_ten(power)}"


def readable(value: float | None) -> str:
    """Return a number as text for sentences, with two significant digits: 1.3, 3.1×10⁻⁷.

    A number from 10 to 1000 is rounded to a whole number; None becomes `NOTHING`.
    """
    if value is not None and value >= 10 ** (READABLE_DIGITS - 1) and value < 10**PLAIN_POWERS.stop:
        return f"{value:.0f}"
    return number(value, READABLE_DIGITS)


def power_of_ten(exponent: int) -> str:
    """Return a power of ten as text, such as `10⁻⁶`."""
    return f"10{str(exponent).translate(_SUPERSCRIPT)}"


def duration(seconds: float) -> str:
    """Return a timestep, given in s, as text: 2 ms, 1/240 s, 65.1 µs, 0.5 s."""
    per_second = round(1 / seconds) if seconds else 0
    if per_second in RATES and math.isclose(seconds * per_second, 1.0):
        return f"1/{per_second} s"
    unit, size = next(((u, s) for u, s in UNITS if seconds >= s / 10), UNITS[-1])
    shown = number(seconds / size)
    return f"{shown.rstrip('0').rstrip('.') if '.' in shown else shown} {unit}"


def span(timesteps: Sequence[float]) -> str:
    """Return the range of several timesteps, given in s, as text: 2 ms to 0.1 s."""
    return " to ".join(dict.fromkeys(map(duration, (min(timesteps), max(timesteps)))))


def rounded_down(seconds: float) -> float:
    """Return a timestep, s, rounded down to two significant digits, as users type it."""
    exact = Decimal(repr(seconds))
    digit = Decimal((0, (1,), exact.adjusted() - TYPED_DIGITS + 1))
    return float(exact.quantize(digit, ROUND_DOWN))


def typed(seconds: float) -> str:
    """Return a timestep, given in s, as users write it in a program: 0.002, 1/240."""
    shown = duration(seconds)
    return shown.removesuffix(" s") if shown.startswith("1/") else repr(seconds)


def observed(value: float) -> str:
    """Return a number as text with five significant digits, for readers who compare numbers."""
    return number(value, COMPARED_DIGITS)


def count(value: int) -> str:
    """Return a whole number as text, with spaces between thousands."""
    return f"{value:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def limited(error: float | None, uncertainty: float) -> str:
    """Return an error as text; if it does not exceed the uncertainty, as "≤" and the uncertainty.

    Both numbers are in the unit that is shown. An error of None becomes `NOTHING`.
    """
    if error is None or not error <= uncertainty:
        return number(error)
    return f"≤ {number(uncertainty)}"


def limited_errors(errors: Errors, uncertainty: Errors, names: Sequence[str]) -> list[str]:
    """Return a run's errors in some signals as text, angles in degrees.

    In place of an error that does not exceed the uncertainty of the reference, the text is "≤" and
    the uncertainty.

    Parameters
    ----------
    names : names of the signals
    """
    shown = {name: SIGNAL[name].shown for name in names}
    return [limited(errors[name] * n, uncertainty[name] * n) for name, n in shown.items()]


def ended(row: Row) -> str:
    """Return how a run ended, and when if it ended early, as text: `ok`, `diverged at 1.25 s`."""
    return row.outcome + (f" at {number(row.stopped_at)} s" if row.stopped_at is not None else "")


def order(value: float | None) -> str:
    """Return an order of accuracy as text with two decimals; `NOTHING` for None."""
    return NOTHING if value is None else f"{value:.2f}".replace("-", _MINUS)


def plural(amount: int, thing: str) -> str:
    """Return a number with a noun, such as `1 scene` or `2 scenes`."""
    return f"{amount} {thing}" if amount == 1 else f"{amount} {thing}s"
