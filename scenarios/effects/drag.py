"""Drag: a torque −c ω, which takes the spin away."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from mpmath import mpf
from pydantic import Field

from ..values import Positive
from .effect import Effect, EffectTable, Extent, Rate, Size

if TYPE_CHECKING:
    from ..scenario import Scenario

_WHERE = ("effects", "drag", "rotational")


class DragTable(EffectTable):
    """A torque against the angular velocity."""

    EXAMPLE: ClassVar[str] = "rotational = 1e-4                # N m s: torque −c ω\n"

    rotational: Positive = Field(description="N m s: torque −c ω")


def _decay(scenario: "Scenario") -> float:
    """The rate at which drag slows the body about the axis of its least moment, 1/s."""
    return scenario.drag * float(np.linalg.norm(np.linalg.inv(scenario.inertia), 2))


def _sizes(extent: Extent) -> Iterator[Size]:
    yield _WHERE, "the drag", mpf(extent.scenario.drag), "N m s"


def _rates(extent: Extent) -> Iterator[Rate]:
    yield _WHERE, "a decay by drag", mpf(extent.scenario.drag) / extent.moments[0]


EFFECT = Effect(
    "drag",
    "drag",
    DragTable,
    is_pushed=True,
    sizes=_sizes,
    rates=_rates,
    rate=_decay,
    rate_formula="c/I of drag",
    decay=_decay,
)
