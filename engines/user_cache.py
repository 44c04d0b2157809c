"""The folder for files that can be made again."""

import errno
import os
import sys
from pathlib import Path

from ..scenarios.regular_files import is_own


def user_cache() -> Path:
    """The folder `spincheck` of the user's cache; it may not exist yet.

    `$XDG_CACHE_HOME`, or if that is not absolute `~/.cache` (XDG Base Directory Specification);
    `~/Library/Caches` on macOS.

    Raises
    ------
    PermissionError
        If others may write to it: what is in it is executed.
    """
    own = "Library/Caches" if sys.platform == "darwin" else ".cache"
    stated = Path(os.environ.get("XDG_CACHE_HOME", ""))
    folder = (stated if stated.is_absolute() else Path.home() / own) / "spincheck"
    if not is_own(folder):
        raise PermissionError(errno.EPERM, "others may write to it, remove it", str(folder))
    return folder
