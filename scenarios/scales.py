"""Checks that doubles can hold a scene's quantities, and that its time span can be simulated.

Numbers that are too large would overflow in one engine and make another one hang. A scene with
such numbers is therefore refused, with a message of one sentence, when it is read.
"""

from collections.abc import Iterator

from mpmath import mp, mpf

from .effects.effect import Extent, Rate, Size, length
from .errors import Misfit
from .exact import DIGITS
from .fastest_rate import decay_rate
from .principal import principal_axes
from .scenario import Scenario

#: Smallest and largest size of a quantity, SI. Its square is still a double; the moment of inertia
#: of a hydrogen molecule is 1e-48 kg m², that of the Milky Way 1e82.
SMALLEST, LARGEST = mpf("1e-150"), mpf("1e150")
#: Names of quantities that others are divided by, which must not be below `SMALLEST`. Any other
#: quantity may be: it acts as 0.
NEVER_SMALL = ("the time", "the mass", "the least moment of inertia")
#: Largest ratio of the moments about the fixed point: a grain of 1e-8 m on a thread of 1 m.
#: Conversions with `DIGITS` digits then leave each moment exact to far more than a double-double.
MAX_MOMENT_RATIO = mpf("1e16")
#: Largest product of fastest rate and time span. Closed forms are exact far beyond it, but no
#: engine or integrator gets that far.
MAX_SPAN = mpf("1e9")


def check_scales(scenario: Scenario, until: float | None = None) -> None:
    """Check that a scene's sizes and rates are not too large, or too small, to be computed with.

    Parameters
    ----------
    until : end of the time span that is checked, s; by default the window's duration

    Raises
    ------
    Misfit
        If a size is too large or too small, a rate is too large for the time span, or the moments
        of inertia differ by too large a factor.
    """
    span = mpf(scenario.window.duration if until is None else until)
    with mp.workdps(DIGITS):
        extent = Extent(scenario, span, _moments(scenario), mpf(decay_rate(scenario)))
        for keys, what, size, unit in _sizes(extent, _inertia_keys(scenario)):
            too_small = size < SMALLEST and what in NEVER_SMALL
            if too_small or size > LARGEST:
                raise Misfit(
                    f"{what} is {mp.nstr(size, 3)} {unit}, too {'small' if too_small else 'large'} "
                    "to be computed with: sizes must lie between 1e-150 and 1e150 in SI units",
                    *keys,
                )
        for keys, what, rate in _rates(extent):
            if rate * span > MAX_SPAN:
                raise Misfit(
                    f"{what} of {mp.nstr(rate, 3)} /s over {mp.nstr(span, 3)} s cannot be "
                    f"followed: rate × time must not exceed {mp.nstr(MAX_SPAN, 3)}",
                    *keys,
                )


def _sizes(extent: Extent, where: tuple[str, ...]) -> Iterator[Size]:
    """Yield the sizes of a scene's quantities, and of quantities that are computed from them.

    `where` has the keys under which the file states the inertia.
    """
    body, start = extent.scenario.body, extent.scenario.start
    least, _, greatest = extent.moments
    fastest = length(start.omega_body_exact)
    yield ("window", "duration"), "the time", extent.span, "s"
    yield ("body",), "the mass", body.mass_exact, "kg"
    yield ("body",), "the com's distance from the origin", extent.arm, "m"
    yield where, "the least moment of inertia", least, "kg m²"
    yield where, "the greatest moment of inertia", greatest, "kg m²"
    yield ("start",), "the angular velocity", fastest, "rad/s"
    yield ("start",), "the angular momentum", greatest * fastest, "kg m²/s"
    yield ("start",), "the kinetic energy", greatest * fastest**2, "J"
    yield ("start",), "the speed", extent.speed, "m/s"
    yield ("start",), "the com's distance from the world's origin", extent.distance, "m"
    for effect in extent.scenario.acting:
        yield from effect.sizes(extent)


def _rates(extent: Extent) -> Iterator[Rate]:
    """Yield ‖ω‖ at the start and the rates of the scene's effects, 1/s: they limit timesteps."""
    yield ("start",), "an angular velocity", length(extent.scenario.start.omega_body_exact)
    for effect in extent.scenario.acting:
        yield from effect.rates(extent)


def _moments(scenario: Scenario) -> tuple[mpf, mpf, mpf]:
    """Return the principal moments about pivot or com, ascending, kg m².

    Raises `Misfit` if their ratio is too large to be computed with.
    """
    least, middle, greatest = sorted(principal_axes(scenario.inertia_exact)[0])
    # If the least moment is lost to rounding, it may not even be positive.
    if greatest > MAX_MOMENT_RATIO * least:
        raise Misfit(
            f"the greatest moment about the {scenario.about}, {mp.nstr(greatest, 3)} kg m², is "
            f"more than {mp.nstr(MAX_MOMENT_RATIO, 3)} times the least",
            *_inertia_keys(scenario),
        )
    return least, middle, greatest


def _inertia_keys(scenario: Scenario) -> tuple[str, ...]:
    """Return the path of keys under which the file states the inertia."""
    return ("body", "inertia" if scenario.document.body.particles is None else "particles")
