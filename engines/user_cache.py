"""The folder for files that can be made again."""

import os
import sys
from pathlib import Path


def user_cache() -> Path:
    """The folder `spincheck` of the user's cache; it may not exist yet.

    `$XDG_CACHE_HOME` or `~/.cache` (XDG Base Directory Specification); `~/Library/Caches` on macOS.
    """
    own = "Library/Caches" if sys.platform == "darwin" else ".cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / own) / "spincheck"
