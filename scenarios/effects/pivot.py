"""A pivot: a force of whatever size holds the body's origin, and does no work."""

from ..constraint import Constraint
from .effect import Effect, EffectTable


class PivotTable(EffectTable):
    """The body's origin is held at the world's origin by a frictionless ball joint."""


EFFECT = Effect(
    "pivot",
    "pivot",
    PivotTable,
    constraint=lambda _, body: Constraint((True, True, True), body.com_exact),
    place_formula="r_com − R com: where the body's origin is",
    group="On a pivot",
)
