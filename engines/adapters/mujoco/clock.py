"""The clock that MuJoCo's Python package installs in the library, and how to step without it.

From 3.3.1 on the package sets the callback `mjcb_time`, a clock that the library reads some 31
times a step to fill `mjData.timer`. The callback is one pointer for the whole process, NULL without
a clock. Python's API can replace it, but not remove it.
"""

import ctypes
from pathlib import Path

import mujoco

#: File names of the library in the package's folder, as patterns: Linux, macOS, Windows.
_LIBRARIES = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
#: Name of the clock in `Engine.left_out` and in the audit.
CLOCK = "clock"


def _pointer() -> ctypes.c_void_p:
    """Return MuJoCo's variable `mjcb_time`; its value is the address of a clock, or None."""
    folder = Path(mujoco.__file__).parent
    file = next(file for pattern in _LIBRARIES for file in folder.glob(pattern))
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(file)), "mjcb_time")


# Older versions install the clock only when the first of these functions is called.
mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>"))
_hung = _pointer()
#: The package's clock as it was when this module was imported; None before 3.3.1.
SHIPPED = _hung.value


def hang(clock: int | None) -> None:
    """Set the clock with which MuJoCo's library times its steps from now on, `mjcb_time`.

    `clock` is the address of a C function without arguments that returns a time as a double; with
    None nothing is timed.
    """
    _hung.value = clock


def is_hung() -> bool:
    """Whether MuJoCo's library reads a clock at present."""
    return _hung.value is not None
