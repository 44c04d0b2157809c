"""The version of the interface that adapters are written for: `spincheck.engine`.

The rules of growth and deprecation are in docs/project/releases.md.
"""

import warnings

#: The newest version of the interface; it is raised by one when something is added.
NEWEST = 2
#: The oldest version for which an adapter may be written; it is raised when something deprecated is
#: removed.
OLDEST = 1


class Adapted:
    """Base of the classes that adapters implement: it warns of overridden deprecated members.

    A member is deprecated by the decorator `typing_extensions.deprecated`, whose message names the
    replacement. The decorator itself warns only those who call the member.
    """

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        for name in vars(cls):
            member = getattr(super(cls, cls), name, None)
            if message := getattr(getattr(member, "fget", member), "__deprecated__", ""):
                words = f"{cls.__module__}.{cls.__qualname__}.{name}: {message}"
                warnings.warn(words, DeprecationWarning, stacklevel=3)


def misfit(what: str, stated: object, oldest: int = OLDEST, newest: int = NEWEST) -> str:
    """Return why the version that an engine states cannot be used; empty if it can.

    Parameters
    ----------
    what : name of the key or attribute with the version, for the message
    stated : the version that the engine states; its type is not checked yet
    oldest, newest : the first and the last version that can be used
    """
    if type(stated) is int and oldest <= stated <= newest:
        return ""
    if not isinstance(stated, int):
        remedy = "state the version that it is written for"
    elif stated > newest:
        remedy = "it needs a newer spincheck"
    else:
        remedy = "it needs an older spincheck, or a newer version of itself"
    known = f"{oldest}" if oldest == newest else f"{oldest} to {newest}"
    return f"'{what}' must be {known}, got {stated!r}: {remedy}"
