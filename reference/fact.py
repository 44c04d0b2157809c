"""A derived number of a scene."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fact:
    """A derived number of a scene."""

    name: str
    value: float
    unit: str
    meaning: str
