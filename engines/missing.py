"""An engine that spincheck knows but cannot use here."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Missing:
    """An engine that cannot be used here.

    Attributes
    ----------
    name : the engine's name, or its adapter's if the adapter cannot be imported
    package : the distribution that is not installed; empty if importing failed for another reason
    reason : why the engine cannot be used, with how to install it
    family : name by which users ask for several optional engines together; empty if it has none
    """

    name: str
    package: str
    reason: str
    family: str = ""
