"""Rotors: parts of the body that turn in it, in an array of tables of their own."""

from collections.abc import Iterable, Iterator
from typing import ClassVar, Literal, Self

import numpy as np
from mpmath import mp, mpf
from pydantic import Field, model_validator

from ..errors import Misfit
from ..exact import DIGITS, vector
from ..gyrostat import Rotor, Rotors
from ..values import Number, Positive
from ..values import Vector as Numbers
from .effect import Effect, EffectTable, Extent, Rate, Scene, Size, length

#: Relative slack: the moment about the axis may exceed twice the moment across it by rounding.
FLAT_SLACK = 4 * float(np.finfo(float).eps)


class RotorTable(EffectTable):
    """An axisymmetric rotor on a hinge in the body. Mass and inertia in `[body]` are without it."""

    EXAMPLE: ClassVar[str] = """axis = [0.0, 0.0, 1.0]           # body axes
position = [0.0, 0.0, 0.05]      # m, of its com, from the body's origin
mass = 0.1                       # kg
inertia = [2e-5, 4e-5]           # kg m²: across, along the axis
spin = 300.0                     # rad/s, relative to the body, at the start
hinge = "free"                   # or "driven", or "locked"
"""

    axis: Numbers = Field(description="direction of the hinge, body axes, of any length")
    position: Numbers = Field(description="m, of its com, from the body's origin, body axes")
    mass: Positive = Field(description="kg")
    inertia: tuple[Positive, Positive] = Field(
        description="kg m², about its com: across and along the axis"
    )
    spin: Number = Field(
        0.0, description="rad/s about the axis, relative to the body, at t = 0; 0 if left out"
    )
    hinge: Literal["free", "driven", "locked"] = Field(
        description="turns without friction; keeps its spin; or is fixed to the body"
    )

    @model_validator(mode="after")
    def _is_a_rotor(self) -> Self:
        across, along = self.inertia
        if not any(self.axis):
            raise Misfit("must have a length, got [0, 0, 0]", "axis")
        if along > 2 * across * (1 + FLAT_SLACK):
            raise Misfit(
                "the moment along the axis must not exceed twice that across it, "
                f"got {across:g}, {along:g} kg m²",
                "inertia",
            )
        if self.hinge == "locked" and self.spin:
            raise Misfit(f"must be 0 on a locked hinge, got {self.spin:g} rad/s", "spin")
        return self

    def rotor(self) -> Rotor:
        """Return the rotor that the table describes."""
        with mp.workdps(DIGITS):
            size = length(self.axis)
            x, y, z = (mpf(component) / size for component in self.axis)
        across, along, spin = map(mpf, (*self.inertia, self.spin))
        position = vector(self.position)
        return Rotor((x, y, z), position, mpf(self.mass), across, along, spin, self.hinge)


def rotors_of(tables: Iterable[RotorTable] | None) -> Rotors:
    """Return the rotors that the tables of a scene file describe; no rotors for None."""
    return Rotors(tuple(table.rotor() for table in tables or ()))


def gyroscopic_rate(scenario: Scene) -> float:
    """Return ‖h‖/I, the rate at which h × ω turns ω, rad/s.

    h is the sum of the rotors' constant angular momenta, and I the least moment across h. The
    rate is 0 if h is zero.
    """
    h = scenario.kept_body(scenario.kept_at_start)
    size = float(np.linalg.norm(h))
    if not size:
        return 0.0
    across = np.eye(3) - np.outer(h, h) / size**2
    inverse = np.linalg.inv(scenario.inertia)
    return size * float(np.linalg.norm(across @ inverse @ across, 2))


def _sizes(extent: Extent) -> Iterator[Size]:
    """Yield three sizes of each rotor: its place, and bounds on its angular momentum and energy.

    The place is its distance from the body's origin, m. With C its moment about its axle and s its
    spin, the bounds are C (|s| + ‖ω‖), kg m²/s, and C (|s| + ‖ω‖)², J, both at t = 0.
    """
    speed = length(extent.scenario.start.omega_body_exact)
    for k, rotor in enumerate(extent.scenario.rotors.each):
        where = ("rotors", k)
        fast = abs(rotor.spin) + speed
        yield where, "the distance from the body's origin", length(rotor.position), "m"
        yield where, "the rotor's angular momentum", rotor.along * fast, "kg m²/s"
        yield where, "the rotor's kinetic energy", rotor.along * fast**2, "J"


def _rates(extent: Extent) -> Iterator[Rate]:
    """Yield the rate at which the rotors' angular momentum turns ω, `gyroscopic_rate`, rad/s."""
    rate = mpf(gyroscopic_rate(extent.scenario))
    yield ("rotors",), "the rotors' momentum over the body's moment", rate


EFFECT = Effect(
    "rotors",
    "rotors",
    RotorTable,
    is_part=True,
    sizes=_sizes,
    rates=_rates,
    rate=gyroscopic_rate,
    rate_formula="h/I of rotors, h their angular momentum",
    momentum_body=lambda scene, motion: scene.rotors.momentum_body(motion.spins),
    kinetic=lambda scene, motion: scene.rotors.energy(motion.omega_body, motion.spins),
    work=lambda scene, motion: scene.rotors.work(motion.omega_body, motion.spins),
    wrong_momentum="the rotors had {} times their angular momentum",
)
