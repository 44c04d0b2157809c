"""Gravity: a force m g on the centre of mass, of potential −m g·r."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from mpmath import mp
from pydantic import Field

from ..float_array import FloatArray
from ..rotation import cross
from ..trajectory import Trajectory
from ..values import Vector
from .effect import Effect, EffectTable, Extent, Rate, Scene, Size, Unit, length


class GravityTable(EffectTable):
    """A uniform gravitational field."""

    EXAMPLE: ClassVar[str] = "acceleration = [0.0, 0.0, -9.81]   # m/s², world axes\n"
    UNITS: ClassVar[dict[str, Unit]] = {"acceleration": Unit(length=1, time=-2, kind="vector")}

    acceleration: Vector = Field(description="m/s², world axes")


def potential(scenario: Scene, motion: Trajectory) -> FloatArray:
    """Return V = −m g·r at a motion's n samples, J, (n,), with r the com's position."""
    return np.asarray(-scenario.body.mass * (motion.com_world @ scenario.gravity_world))


def torque_body(scenario: Scene, R_world_body: FloatArray) -> FloatArray:
    """Return gravity's torque about the pivot, N m, body axes, (3,); zeros without a pivot.

    `R_world_body` is the rotation matrix of one attitude, (3, 3).
    """
    if not scenario.constraint.is_pivot:
        return np.zeros(3)
    return cross(scenario.body.com, scenario.body.mass * (scenario.gravity_world @ R_world_body))


def swing_rate(scenario: Scene) -> float:
    """Return √(m g l / I), the rate of a small swing under gravity, rad/s.

    It is 0 for a free body, and for a body that is held at its com. l is the length of the lever,
    from the held point to the com. I is the least moment about an axis across the lever, as
    gravity's torque is across the lever: a needle that hangs by its end swings slowly, however
    small its moment about its length.
    """
    lever = scenario.constraint.lever
    arm = float(np.linalg.norm(lever))
    if scenario.constraint.is_free or not arm:
        return 0.0
    inverse = np.asarray(np.linalg.inv(scenario.inertia), dtype=float)
    direction = lever / arm
    across = np.eye(3) - np.outer(direction, direction)
    pull = scenario.body.mass * float(np.linalg.norm(scenario.gravity_world)) * arm
    return float(np.sqrt(pull * np.linalg.norm(across @ inverse @ across, 2)))


def _sizes(extent: Extent) -> Iterator[Size]:
    """Yield the acceleration of gravity, m/s², and a bound on the potential energy, J, as sizes."""
    where = ("effects", "gravity", "acceleration")
    g = length(extent.scenario.gravity_world)
    energy = extent.scenario.body.mass_exact * g * extent.distance
    yield where, "the acceleration", g, "m/s²"
    yield where, "the potential energy", energy, "J"


def _rates(extent: Extent) -> Iterator[Rate]:
    """Yield √(m g l/I), the rate of a small swing under gravity, rad/s; none for a free body.

    l is the com's distance from the point that is held, and I the middle moment of inertia.
    """
    constraint = extent.scenario.constraint
    if not constraint.is_free:
        lever = extent.scenario.body.mass_exact * length(constraint.lever_exact)
        pull = lever * length(extent.scenario.gravity_world)
        yield ("effects", "gravity"), "a swing under gravity", mp.sqrt(pull / extent.moments[1])


EFFECT = Effect(
    "gravity",
    "gravity",
    GravityTable,
    sizes=_sizes,
    rates=_rates,
    rate=swing_rate,
    rate_formula="√(m g l/I) of a small swing under gravity",
    potential=potential,
    group="Thrown",
)
