"""An engine that spincheck knows but cannot use here."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Missing:
    """An engine that cannot be used here.

    Attributes
    ----------
    name : of the engine, or of its adapter where that cannot be imported
    package : the distribution that is not installed; empty where importing failed otherwise
    reason : one sentence, with how to get it
    family : as of an engine
    """

    name: str
    package: str
    reason: str
    family: str = ""
