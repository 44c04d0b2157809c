"""A table: a smooth horizontal plane on which the body's tip slides without friction.

The tip is a sphere about a point of the body, or the point itself. Its force N is vertical and
passes through the sphere's centre, whatever the radius; it does no work. With b the torque about
the centre of mass of a unit of N, along body axes, and T all other torque including −ω × Iω::

    I ω' = T + N b,   m z'' = N + m g_z,   z = height + radius + ẑ·lever
    N (1/m + b·I⁻¹b) = −g_z + ẑ·(ω × (ω × lever)) − b·I⁻¹T

(N. Rutstam, SIGMA 8 (2012) 019, for the symmetric top, there with friction besides.)
"""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from mpmath import mp, mpf
from pydantic import Field

from ..body import Body
from ..constraint import Constraint
from ..errors import Misfit
from ..exact import DIGITS
from ..float_array import FloatArray
from ..rotation import cross, matrix
from ..start import StartTable
from ..values import NotNegative, Number, Vector
from .effect import Effect, EffectTable, Extent, Scene, Size, Unit, length
from .pivot import EFFECT as PIVOT
from .push import push

WHERE = ("effects", "table")
#: Largest difference of a stated height or vertical velocity from that of a body on the table,
#: relative to scales of length and speed. The stated decimals are rounded; the exact values on the
#: table are used instead of them.
TYPED = 1e-6
#: Words for a tip that is too low or too high, and for one that moves down or up.
WAYS_OFF = ("pierces the table", "hangs above the table")
WAYS_MOVED = ("drives the tip into the table", "lifts the tip off")


class TableTable(EffectTable):
    """A smooth horizontal plane under the body's tip, which slides on it without friction."""

    EXAMPLE: ClassVar[str] = (
        "height = 0.0                     # m, of the plane, along z\n"
        "tip = [0.0, 0.0, 0.0]            # m, from the body's origin, body axes\n"
        "radius = 0.0                     # m, of a sphere about the tip; 0: a point\n"
    )
    UNITS: ClassVar[dict[str, Unit]] = {
        "height": Unit(length=1),
        "tip": Unit(length=1, kind="vector", axes="body"),
        "radius": Unit(length=1),
    }

    height: Number = Field(description="m, of the plane, along the world's z axis")
    tip: Vector = Field(description="m, of the tip's centre, from the body's origin, body axes")
    radius: NotNegative = Field(description="m, of the sphere about the tip; 0 for a point")


def constraint(table: TableTable, body: Body) -> Constraint:
    """Return the constraint that holds the tip's centre at its height above the table."""
    with mp.workdps(DIGITS):
        x, y, z = (com - mpf(tip) for com, tip in zip(body.com_exact, table.tip, strict=True))
        height = mpf(table.height) + mpf(table.radius)
    return Constraint((False, False, True), (x, y, z), (mpf(0), mpf(0), height))


def arm_body(scenario: Scene, up_body: FloatArray) -> FloatArray:
    """Return b, the torque about the com for each newton of the table's force, (n, 3) or (3,).

    It is in m, body axes. `up_body` is the world's vertical ẑ along body axes, in n states, (n, 3),
    or in one, (3,).
    """
    return cross(up_body, scenario.constraint.lever)


def normal_force(
    scenario: Scene,
    up_body: FloatArray,
    omega_body: FloatArray,
    torque_body: FloatArray,
    pull_world: FloatArray,
) -> FloatArray:
    """Return the table's upward force N in n states, in newtons, (n,), or in one, a number.

    It is negative where the table would have to pull.

    Parameters
    ----------
    up_body : the world's vertical ẑ, body axes, (n, 3) or (3,)
    omega_body : ω, rad/s, body axes, (n, 3) or (3,)
    torque_body : T, all torque but that of N, including −ω × Iω, N m, body axes, (n, 3) or (3,)
    pull_world : acceleration of the com without the table, m/s², (3,)
    """
    circling = cross(omega_body, cross(omega_body, scenario.constraint.lever))
    lift = (up_body * circling).sum(-1) - pull_world[2]
    b, inverse = arm_body(scenario, up_body), np.linalg.inv(scenario.inertia)
    mobility = 1 / scenario.body.mass + (b * (b @ inverse)).sum(-1)
    return np.asarray((lift - (b * (torque_body @ inverse)).sum(-1)) / mobility)


def answer(
    scenario: Scene,
    up_body: FloatArray,
    omega_body: FloatArray,
    torque_body: FloatArray,
    pull_world: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return torque, N m, body axes, and acceleration of the com, m/s², world axes, (3,) each.

    They are `torque_body` and `pull_world` plus what the table's force N contributes.

    Parameters
    ----------
    up_body : the world's vertical ẑ, body axes, (3,)
    omega_body : ω, rad/s, body axes, (3,)
    torque_body : all torque but that of N, including −ω × Iω, N m, body axes, (3,)
    pull_world : acceleration of the com without the table, m/s², (3,)
    """
    force = normal_force(scenario, up_body, omega_body, torque_body, pull_world)
    pushed_up = np.array([0.0, 0.0, force / scenario.body.mass])
    return torque_body + force * arm_body(scenario, up_body), pull_world + pushed_up


def force(
    scenario: Scene, R_world_body: FloatArray, omega_body: FloatArray, kept_body: FloatArray
) -> FloatArray:
    """Return the force N of the table in n states, newtons, (n,), or in one, a number.

    Parameters
    ----------
    R_world_body : rotation matrices, body to world, (n, 3, 3) or (3, 3)
    omega_body : ω, rad/s, body axes, (n, 3) or (3,)
    kept_body : angular momentum of the rotors, kg m²/s, body axes, (n, 3) or (3,)
    """
    omega_world = (R_world_body * omega_body[..., None, :]).sum(-1)
    pushed = push(scenario.pushed, R_world_body, omega_world)
    torque_body = (R_world_body * pushed[..., :, None]).sum(-2)
    torque_body = torque_body - cross(omega_body, omega_body @ scenario.inertia + kept_body)
    up_body = R_world_body[..., 2, :]
    return normal_force(scenario, up_body, omega_body, torque_body, scenario.gravity_world)


def check(scenario: Scene, stated: StartTable) -> None:
    """Check that a scene's body starts on the table and is pressed onto it.

    Parameters
    ----------
    stated : the start as the scene file states it

    Raises
    ------
    Misfit
        If the com is not above the table, a stated height or vertical velocity is not that of a
        body on it, the table would have to pull at the start, or a pivot holds the body as well.
    """
    if PIVOT in scenario.acting:
        raise Misfit("does not go with a pivot: both hold the body; remove one", *WHERE)
    start, table = scenario.start, scenario.table_of(TableTable)
    assert table is not None
    com_height = start.position_world[2] - table.height
    if com_height <= 0:
        raise Misfit(
            f"must touch the table below the centre of mass, which would be {-com_height:.3g} m "
            "under it; turn the body, or state another point",
            *(*WHERE, "tip"),
        )
    _check_stated(scenario, stated)
    R_world_body = matrix(start.q_world_body_wxyz)
    kept_body = scenario.kept_body(scenario.kept_at_start)
    pressed = float(force(scenario, R_world_body, start.omega_body, kept_body))
    if not pressed > 0:
        raise Misfit(
            f"would have to pull at the body with {-pressed + 0.0:.3g} N to keep it from lifting "
            "off at once; it takes gravity along −z, and a start that does not throw the body up",
            *WHERE,
        )


def _check_stated(scenario: Scene, stated: StartTable) -> None:
    """Raise `Misfit` unless stated position and velocity have the z of a body on the table."""
    start, lever = scenario.start, float(np.linalg.norm(scenario.constraint.lever))
    length_scale = lever + abs(start.position_world[2])
    speed_scale = lever * float(np.linalg.norm(start.omega_body))
    for key, typed, here, scale, unit, ways in (
        ("position", stated.position, start.position_world, length_scale, "m", WAYS_OFF),
        ("velocity", stated.velocity, start.velocity_world, speed_scale, "m/s", WAYS_MOVED),
    ):
        wanted = float(here[2])
        if typed is not None and abs(off := typed[2] - wanted) > TYPED * scale:
            raise Misfit(
                f"{ways[off > 0]}, by {abs(off):.3g} {unit}: its third component must be "
                f"{wanted!r} {unit}, got {typed[2]!r}",
                *("start", key),
            )


def _sizes(extent: Extent) -> Iterator[Size]:
    """Yield the table's height, the tip's radius, the com's distance l from the tip, and l²/I.

    The first three are in m. l²/I, 1/kg, has the least moment of inertia for I.
    """
    table = extent.scenario.table_of(TableTable)
    assert table is not None
    yield (*WHERE, "height"), "the table's height", abs(mpf(table.height)), "m"
    yield (*WHERE, "radius"), "the tip's radius", mpf(table.radius), "m"
    lever = length(extent.scenario.constraint.lever_exact)
    yield (*WHERE, "tip"), "the com's distance from the tip", lever, "m"
    turning = lever**2 / extent.moments[0]
    yield (*WHERE, "tip"), "its square over the least moment of inertia", turning, "1/kg"


EFFECT = Effect(
    "table",
    "table",
    TableTable,
    constraint=constraint,
    check=check,
    sizes=_sizes,
    force=force,
    answer=answer,
    place_formula="z of r_com − R (com − tip): the height of the tip",
    group="On a table",
)
