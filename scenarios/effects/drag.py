"""Drag: a torque −c ω, which takes the spin away."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from mpmath import mpf
from pydantic import Field

from ..values import Positive
from .effect import DRIVEN, Effect, EffectTable, Extent, Rate, Scene, Size, Unit

_WHERE = ("effects", "drag", "rotational")


class DragTable(EffectTable):
    """A torque against the angular velocity."""

    EXAMPLE: ClassVar[str] = "rotational = 1e-4                # N m s: torque −c ω\n"
    UNITS: ClassVar[dict[str, Unit]] = {"rotational": Unit(mass=1, length=2, time=-1)}

    rotational: Positive = Field(description="N m s: torque −c ω")


def _decay(scenario: Scene) -> float:
    """Return the rate at which drag slows a rotation about the axis of the least moment, 1/s."""
    coefficient = float(scenario.pushed["drag"])
    return coefficient * float(np.linalg.norm(np.linalg.inv(scenario.inertia), 2))


def _sizes(extent: Extent) -> Iterator[Size]:
    """Yield one size, the coefficient of drag, N m s, with its key, name and unit."""
    yield _WHERE, "the drag", mpf(extent.scenario.pushed["drag"]), "N m s"


def _rates(extent: Extent) -> Iterator[Rate]:
    """Yield the fastest rate at which drag slows ω, 1/s, with its key and name."""
    yield _WHERE, "a decay by drag", mpf(extent.scenario.pushed["drag"]) / extent.moments[0]


EFFECT = Effect(
    "drag",
    "drag",
    DragTable,
    pushed=lambda table: table.rotational if table else 0.0,
    sizes=_sizes,
    rates=_rates,
    rate=_decay,
    rate_formula="c/I of drag",
    decay=_decay,
    group=DRIVEN,
)
