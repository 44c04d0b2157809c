"""What each default of an engine does to the motion of a scene."""

from dataclasses import dataclass

from ...scenarios import Errors
from .records import MethodKey, Record, Size


@dataclass(frozen=True)
class DefaultEffect:
    """One default of a method as shipped.

    Attributes
    ----------
    name : the engine's own name of it
    alone : errors with it and no other default; None if the run did not finish
    without : errors with all defaults but this; None if the run did not finish
    acts : whether it alone alters the equations of motion, in steps however short; None if unknown
    """

    name: str
    alone: Errors | None
    without: Errors | None
    acts: bool | None = None


@dataclass(frozen=True)
class DefaultEffects(Record):
    """A method as shipped on a scene, its defaults taken away one at a time.

    Attributes
    ----------
    timestep : s
    none, all : errors with none and with all of the defaults; None if the run did not finish
    """

    key: MethodKey
    timestep: Size
    none: Errors | None
    all: Errors | None
    each: tuple[DefaultEffect, ...]
