"""Sets the folders, in the user's cache, in which Genesis and its compiler store kernels."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ...native_output import silent
from ...user_cache import user_cache

#: Environment variables that name the cache folders of Genesis and of its compiler, each with the
#: name of the folder in the user's cache. A variable that the user has set is left as it is.
FOLDERS = {"GS_CACHE_FILE_PATH": "genesis", "QD_OFFLINE_CACHE_FILE_PATH": "quadrants"}


@contextmanager
def kernels_kept() -> Iterator[None]:
    """Store kernels that Genesis compiles inside the block, for later processes; discard output.

    They are stored in the user's cache. All output and Python warnings of the block are discarded.
    """
    for variable, name in FOLDERS.items():
        os.environ.setdefault(variable, str(user_cache() / name))
    with silent():
        yield
