"""Functions that engines on NVIDIA's Warp share: its cache of kernels, its output, its device."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from spincheck.engine import UnsupportedError

from .native_output import silent
from .user_cache import user_cache


@contextmanager
def kernels_kept() -> Iterator[None]:
    """Store kernels that Warp compiles inside the block, for later processes; discard output.

    They are stored in the user's cache, since compiling takes minutes. All output and Python
    warnings of the block are discarded.
    """
    with silent():
        import warp

        warp.config.kernel_cache_dir = str(user_cache() / "warp")
        yield


def use_warp_device(world: str, name: str) -> None:
    """Make an adapter's stand-alone module step on a given device of Warp from now on.

    Parameters
    ----------
    world : full name of the module, which imports Warp as `wp`
    name : Warp's name of the device, such as cuda:0

    Raises
    ------
    UnsupportedError
        If Warp has no device of that name.
    """
    with kernels_kept():
        warp: Any = import_module(world).wp
        if not warp.is_device_available(name):
            there = ", ".join(one.alias for one in warp.get_devices())
            raise UnsupportedError(f"there is no device '{name}' here; Warp has {there}")
        warp.set_device(name)


def warp_device() -> str:
    """Return the name of the device that Warp steps on: "CPU", or a GPU's name and alias."""
    warp: Any = import_module("warp")
    device = warp.get_device()
    return "CPU" if device.is_cpu else f"{device.name} ({device.alias})"
