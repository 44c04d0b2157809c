"""Where Genesis and its compiler keep what they make: in spincheck's folder of the user's cache."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ...native_output import silent
from ...user_cache import user_cache

#: The environment variables by which Genesis and its compiler find their caches, and the name of
#: the folder for each. A variable that the user has set is left as it is.
FOLDERS = {"GS_CACHE_FILE_PATH": "genesis", "QD_OFFLINE_CACHE_FILE_PATH": "quadrants"}


@contextmanager
def kernels_kept() -> Iterator[None]:
    """Keep the kernels that Genesis compiles inside the block, and discard what it prints.

    Later processes load the kernels from the user's cache.
    """
    for variable, name in FOLDERS.items():
        os.environ.setdefault(variable, str(user_cache() / name))
    with silent():
        yield
