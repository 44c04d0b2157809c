"""The numbers of a version, by which versions are compared."""

import re


def numbers_of(version: str) -> tuple[int, ...]:
    """Return the leading numbers of a version, such as (3, 1, 6) for ``3.1.6.post1``.

    The tuple is empty if the version does not begin with a number.
    """
    leading = re.match(r"\d+(\.\d+)*", version)
    return tuple(int(part) for part in leading[0].split(".")) if leading else ()
