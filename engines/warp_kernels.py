"""What engines on NVIDIA's Warp share: kernels in the user's cache, and silence."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from .native_output import native_output
from .user_cache import user_cache


@contextmanager
def kernels_kept() -> Iterator[None]:
    """Inside the block kernels are compiled once, for minutes, and Warp prints nothing."""
    with native_output(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import warp

        warp.config.kernel_cache_dir = str(user_cache() / "warp")
        yield
