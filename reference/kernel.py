"""Compile a function with numba and keep its machine code on disk.

Numba compiles a cached function again if its own file has changed, but not if the file of a
function that it calls has. A reference must not be computed by outdated machine code, so the cache
here is in a folder named by a digest of all sources of kernels: if one changes, all are compiled
again.
"""

import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numpy as np
from numba import njit

from ..scenarios import FloatArray
from ..scenarios.regular_files import is_own

P = ParamSpec("P")
T = TypeVar("T")

config: Any = numba.config

_PACKAGE = Path(__file__).parent
# The digest is of the files that contain one of these texts, which are all that machine code
# depends on: files of kernels import this module or double-doubles, and constants in kernels are
# the places of entries in rows, which `rows.py` and the modules that import it define.
_MARKS = (b"from .kernel", b"from .doubledouble", b"from .rows", b"class Rows")


def digest_of_kernels(package: Path) -> str:
    """Return a digest, 16 hexadecimal digits, of the sources that numba's machine code depends on.

    They are the modules in the folder `package` that contain one of the texts in `_MARKS`.
    """
    digest = sha256()
    for path in sorted(package.glob("*.py")):
        source = path.read_bytes()
        if any(mark in source for mark in _MARKS):
            digest.update(source)
    return digest.hexdigest()[:16]


def _folder() -> Path | None:
    """Return a folder of this user for machine code, not writable by all; None if there is none.

    It is made if it does not exist: in numba's own cache folder if the user has set one, or else
    beside the sources, and if neither can be written, in the user's home.
    """
    places = [Path(config.CACHE_DIR or _PACKAGE / "__pycache__")]
    # Not every user has a home.
    with suppress(RuntimeError):
        places.append(Path("~/.cache/spincheck").expanduser())
    for place in places:
        folder = place / f"kernels-{digest_of_kernels(_PACKAGE)}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK) and is_own(folder):
            return folder
    return None


#: Where machine code is kept; None if nowhere can be written.
FOLDER = _folder()

#: Numba's options for kernels: they divide by zero as IEEE 754 says, and they count no references
#: to arrays, so that no kernel can make a new array.
OPTIONS: Any = {"error_model": "numpy", "_nrt": False}


def kernel(
    function: Callable[P, T], *, is_inlined: bool = True, allocates: bool = False
) -> Callable[P, T]:
    """Return a function that numba compiles at its first call, with machine code kept in `FOLDER`.

    Kernels pass arrays and pairs of floats to short operations: without inlining they take a
    quarter more time, and if numba counts references to the arrays, three times as long.
    ``fastmath`` is never used, as it would cancel the error terms of pairs.

    Parameters
    ----------
    is_inlined : whether the function is inlined into compiled callers
    allocates : whether it makes new arrays, so that references to arrays must be counted
    """
    options = OPTIONS | {"forceinline": is_inlined, "_nrt": allocates}
    if FOLDER is None:
        uncached: Callable[P, T] = njit(**options)(function)
        return uncached
    elsewhere = config.CACHE_DIR
    config.CACHE_DIR = str(FOLDER)
    try:
        compiled: Any = njit(**options, cache=True)(function)
    finally:
        config.CACHE_DIR = elsewhere
    _survive_the_disk(compiled._cache)
    kept: Callable[P, T] = compiled
    return kept


#: As `kernel`, for a function that is long and called in many places: inlined, it would take long
#: to compile.
called = partial(kernel, is_inlined=False)
#: As `kernel`, for a function that makes new arrays.
allocating = partial(kernel, allocates=True)


def as_kernels_take(numbers: FloatArray) -> FloatArray:
    """Return numbers as a writable, contiguous array of doubles; a copy if they are not one.

    Kernels are compiled for such arrays. For one that is read-only, as a scene's own are, or not
    contiguous, numba would compile them again.
    """
    return np.require(numbers, float, ("C", "W"))


def _survive_the_disk(cache: Any) -> None:
    """Make numba compile again where a full disk or a truncated file would raise an error.

    Parameters
    ----------
    cache : numba's cache of one function's machine code
    """
    load, save = cache.load_overload, cache.save_overload

    def load_overload(signature: Any, context: Any) -> Any:
        try:
            return load(signature, context)
        # A truncated pickle may raise any error.
        except Exception:
            with suppress(OSError):
                cache.flush()
            return None

    def save_overload(signature: Any, machine_code: Any) -> None:
        with suppress(OSError):
            save(signature, machine_code)

    cache.load_overload, cache.save_overload = load_overload, save_overload
