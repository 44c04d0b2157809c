"""Constant torques in body axes, as of a thruster, and in world axes: two effects of one table."""

from collections.abc import Iterator
from typing import ClassVar, Self

from mpmath import mpf
from pydantic import Field, model_validator

from ..exact import ZERO
from ..float_array import read_only
from ..values import Vector
from .effect import DRIVEN, Effect, EffectTable, Extent, Rate, Size, Unit, length

_WHERE = ("effects", "torque")


class TorqueTable(EffectTable):
    """A constant torque: either `body` or `world` must be stated, and not both."""

    EXAMPLE: ClassVar[str] = (
        "body = [0.0, 0.0, 1e-3]          # N m, in body axes; or world = […]\n"
    )
    UNITS: ClassVar[dict[str, Unit]] = {
        "body": Unit(1, 2, -2, "axial", "body"),
        "world": Unit(1, 2, -2, "axial", "world"),
    }

    body: Vector | None = Field(None, description="N m, constant in body axes")
    world: Vector | None = Field(None, description="N m, constant in world axes")

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.body is None) == (self.world is None):
            raise ValueError("takes exactly one of 'body' and 'world'")
        return self


def _sizes(extent: Extent) -> Iterator[Size]:
    yield _WHERE, "the torque", _torque(extent), "N m"


def _rates(extent: Extent) -> Iterator[Rate]:
    """Yield a bound on the ‖ω‖, rad/s, to which the torque can lead from rest in the time span.

    Effects that slow the body lower it.
    """
    torque, least = _torque(extent), extent.moments[0]
    reached = torque * extent.span / least
    if extent.decay:
        reached = min(reached, torque / least / extent.decay)
    yield _WHERE, "a spin that the torque leads to,", reached


def _torque(extent: Extent) -> mpf:
    """Return the size of the scene's constant torque, N m."""
    pushed = extent.scenario.pushed
    return max(length(pushed[f"torque_{axes}"]) for axes in ("body", "world"))


def _constant(axes: str) -> Effect:
    """Return the effect of a torque that is constant along "body" axes or "world" axes."""
    return Effect(
        f"torque_{axes}",
        "torque",
        TorqueTable,
        key=axes,
        pushed=lambda table: read_only((table and getattr(table, axes)) or ZERO),
        sizes=_sizes,
        rates=_rates,
        group=DRIVEN,
    )


TORQUE_BODY, TORQUE_WORLD = map(_constant, ("body", "world"))
