"""A pivot: the one constraint. Its force is whatever holds the body's origin; it does no work."""

from .effect import Effect, EffectTable


class PivotTable(EffectTable):
    """The body's origin is held at the world's origin by a frictionless ball joint."""


EFFECT = Effect("pivot", "pivot", PivotTable, is_constraint=True)
