"""The folder in the user's cache, for files that can be made again."""

import errno
import os
import sys
from pathlib import Path

from ..scenarios.regular_files import is_own


def user_cache() -> Path:
    """Return the folder `spincheck` in the user's cache folder; it may not exist yet.

    The user's cache folder is `$XDG_CACHE_HOME` if that is an absolute path (XDG Base Directory
    Specification); else it is `~/.cache`, or on macOS `~/Library/Caches`.

    Raises
    ------
    FileNotFoundError
        If the user has no home folder, and `$XDG_CACHE_HOME` names no other place.
    PermissionError
        If the folder belongs to another user, or all may write to it (`is_own`): files in it are
        executed.
    """
    own = "Library/Caches" if sys.platform == "darwin" else ".cache"
    stated = Path(os.environ.get("XDG_CACHE_HOME", ""))
    try:
        folder = (stated if stated.is_absolute() else Path.home() / own) / "spincheck"
    except RuntimeError:
        why = "the user has no home folder; set XDG_CACHE_HOME to a folder"
        raise FileNotFoundError(errno.ENOENT, why, f"~/{own}/spincheck") from None
    if not is_own(folder):
        raise PermissionError(errno.EPERM, "others may write to it, remove it", str(folder))
    return folder
