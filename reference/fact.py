"""A derived number of a scene."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fact:
    """One number.

    Attributes
    ----------
    name : what it is called
    value : may be inf: a period on a separatrix
    unit : SI, degrees ("deg") for angles, "" for ratios
    meaning : formula or explanation, in a line
    """

    name: str
    value: float
    unit: str
    meaning: str
