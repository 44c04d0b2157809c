"""An engine that spincheck knows but cannot use here."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Missing:
    """An engine that cannot be used here.

    Attributes
    ----------
    name : the engine's name, or its adapter's if the adapter cannot be imported
    package : the package that is not installed; empty if the engine is missing for another reason
    reason : why the engine cannot be used, and how to install it if that is known
    family : name by which users ask for several optional engines together; empty if there is none
    """

    name: str
    package: str
    reason: str
    family: str = ""
