"""Which test files can be imported where there is no PyBullet, or on Windows."""

import re
import sys
from importlib.util import find_spec
from pathlib import Path

HAS_PYBULLET = find_spec("pybullet") is not None
NO_PYBULLET = "the package 'pybullet' is not installed"
IMPORTS_PYBULLET = re.compile(r"^(import|from) .*pybullet", re.MULTILINE)
NO_POSIX = "it names what Windows has none of"
NAMES_POSIX = re.compile(
    r"^import (fcntl|pty|resource)$|\bos\.(mkfifo|killpg)\b|\bsignal\.SIG(KILL|STOP|HUP|XCPU)\b",
    re.MULTILINE,
)


def why_skipped(path: Path) -> str:
    """Why a test file cannot be imported here; empty if it can."""
    text = path.read_text(encoding="utf-8")
    if not HAS_PYBULLET and IMPORTS_PYBULLET.search(text):
        return NO_PYBULLET
    return NO_POSIX if sys.platform == "win32" and NAMES_POSIX.search(text) else ""
