"""Whether a scene's numbers can be computed with: sizes that doubles hold, a span that ends.

Physics has no largest spin; arithmetic has. A scene beyond it is refused as it is read, in one
sentence, rather than found out about as an overflow in one engine and a hang in the next.
"""

from collections.abc import Iterable, Iterator
from typing import Any

from mpmath import mp, mpf

from .errors import Misfit
from .exact import DIGITS
from .principal import principal_axes
from .scenario import Scenario

#: SI. The square of such a number is a double still; the moment of inertia of a hydrogen molecule
#: is 1e-48 kg m², that of the Milky Way 1e82.
SMALLEST, LARGEST = mpf("1e-150"), mpf("1e150")
#: Quantities that are divided by, and so must not be below `SMALLEST`; others act as 0 there.
NEVER_SMALL = ("the time", "the mass", "the least moment of inertia")
#: Of the moments about the fixed point: a grain of 1e-8 m on a thread of 1 m. Conversions with
#: `DIGITS` digits then leave each moment exact to far more than a double-double.
MAX_MOMENT_RATIO = mpf("1e16")
#: Fastest rate × window. A closed form is exact far beyond; no engine or integrator gets there.
MAX_SPAN = mpf("1e9")

#: Where a quantity is written in a file, what it is, its size and its unit.
Size = tuple[tuple[str, ...], str, mpf, str]
#: Where a rate is written, what it is, and 1/s.
Rate = tuple[tuple[str, ...], str, mpf]
#: kg m², ascending.
Moments = tuple[mpf, mpf, mpf]


def check_scales(scenario: Scenario, until: float | None = None) -> None:
    """See that a scene can be computed with.

    Parameters
    ----------
    until : s, of the time to be looked at; the window's duration if left out

    Raises
    ------
    Misfit
        If it cannot.
    """
    span = mpf(scenario.window.duration if until is None else until)
    with mp.workdps(DIGITS):
        moments = _moments(scenario)
        for keys, what, size, unit in _sizes(scenario, span, moments):
            too_small = size < SMALLEST and what in NEVER_SMALL
            if too_small or size > LARGEST:
                raise Misfit(
                    f"{what} is {mp.nstr(size, 3)} {unit}, too {'small' if too_small else 'large'} "
                    "to be computed with: sizes must lie between 1e-150 and 1e150 in SI units",
                    *keys,
                )
        for keys, what, rate in _rates(scenario, span, moments):
            if rate * span > MAX_SPAN:
                raise Misfit(
                    f"{what} of {mp.nstr(rate, 3)} /s over {mp.nstr(span, 3)} s cannot be "
                    f"followed: rate × time must not exceed {mp.nstr(MAX_SPAN, 3)}",
                    *keys,
                )


def _sizes(scenario: Scenario, span: mpf, moments: Moments) -> Iterator[Size]:
    """The quantities of a scene, and those that are computed from them."""
    body, start = scenario.body, scenario.start
    mass, arm, fastest = body.mass_exact, _norm(body.com_exact), _norm(start.omega_body_exact)
    least, _, greatest = moments
    where = _inertia_keys(scenario)
    yield ("window", "duration"), "the time", span, "s"
    yield ("body",), "the mass", mass, "kg"
    yield ("body",), "the com's distance from the origin", arm, "m"
    yield where, "the least moment of inertia", least, "kg m²"
    yield where, "the greatest moment of inertia", greatest, "kg m²"
    yield ("start",), "the angular velocity", fastest, "rad/s"
    yield ("start",), "the angular momentum", greatest * fastest, "kg m²/s"
    yield ("start",), "the kinetic energy", greatest * fastest**2, "J"
    g = _norm(scenario.gravity_world)
    speed, distance = (_norm(vector) for vector in (start.velocity_world, start.position_world))
    yield ("effects", "gravity", "acceleration"), "the acceleration", g, "m/s²"
    yield ("start",), "the speed", speed + g * span, "m/s"
    height = arm if scenario.has_pivot else distance + speed * span + g * span**2 / 2
    yield ("start",), "the com's distance from the world's origin", height, "m"
    yield ("effects", "gravity", "acceleration"), "the potential energy", mass * g * height, "J"
    yield ("effects", "drag", "rotational"), "the drag", mpf(scenario.drag), "N m s"
    yield ("effects", "torque"), "the torque", _torque(scenario), "N m"


def _rates(scenario: Scenario, span: mpf, moments: Moments) -> Iterator[Rate]:
    """The rates that limit an integrator's timestep, 1/s."""
    least, middle, _ = moments
    yield ("start",), "an angular velocity", _norm(scenario.start.omega_body_exact)
    if scenario.has_pivot:
        lever = scenario.body.mass_exact * _norm(scenario.body.com_exact)
        pull = lever * _norm(scenario.gravity_world)
        yield ("effects", "gravity"), "a swing under gravity", mp.sqrt(pull / middle)
    drag = mpf(scenario.drag)
    yield ("effects", "drag", "rotational"), "a decay by drag", drag / least
    if torque := _torque(scenario):
        gained = torque * span / least
        reached = min(gained, torque / drag) if drag else gained
        yield ("effects", "torque"), "a spin that the torque leads to,", reached


def _moments(scenario: Scenario) -> Moments:
    """Principal moments about the fixed point, ascending, kg m²."""
    body = scenario.body
    tensor = body.inertia_origin_exact if scenario.has_pivot else body.inertia_com_exact
    least, middle, greatest = sorted(principal_axes(tensor)[0])
    # Lost to rounding, the least would not even be positive.
    if greatest > MAX_MOMENT_RATIO * least:
        about = "pivot" if scenario.has_pivot else "com"
        raise Misfit(
            f"the greatest moment about the {about}, {mp.nstr(greatest, 3)} kg m², is more than "
            f"{mp.nstr(MAX_MOMENT_RATIO, 3)} times the least",
            *_inertia_keys(scenario),
        )
    return least, middle, greatest


def _inertia_keys(scenario: Scenario) -> tuple[str, ...]:
    return ("body", "inertia" if scenario.document.body.particles is None else "particles")


def _torque(scenario: Scenario) -> mpf:
    return max(_norm(t) for t in (scenario.torque_body, scenario.torque_world))


def _norm(vector: Iterable[Any]) -> mpf:
    return mp.sqrt(mp.fsum(mpf(component) ** 2 for component in vector))
