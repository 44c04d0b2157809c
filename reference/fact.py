"""A derived number of a scene."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fact:
    """A derived number of a scene, such as its energy, with its meaning in words."""

    name: str
    value: float
    unit: str
    meaning: str
