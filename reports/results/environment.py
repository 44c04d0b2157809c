"""Describes the environment in which results are made: machine, operating system, versions."""

import os
import platform
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from ...engines import Engine

PACKAGES = ("spincheck", "numpy", "scipy", "numba", "mpmath")


def environment(engines: Iterable[Engine], max_steps: int | None = None) -> dict[str, str]:
    """Return what results may depend on, as texts by name: machine, operating system, versions.

    Parameters
    ----------
    max_steps : largest number of steps of a ladder's runs; None if no ladder is run
    """
    ladders = {} if max_steps is None else {"longest ladder run": f"{max_steps} steps"}
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "processor": processor(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
        **{engine.name: engine.version for engine in engines},
    } | ladders


def processor() -> str:
    """Return the processor's name; on Linux it is read from /proc/cpuinfo."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown"
