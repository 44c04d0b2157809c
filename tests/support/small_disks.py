"""Mounts disks of a few kilobytes, to be filled or made read-only."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


class SmallDisk:
    """A file system in memory of its own.

    Parameters
    ----------
    folder : where it is mounted
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def change(self, options: str) -> None:
        """Have another size, or be read-only, from now on."""
        _called("mount", "-o", f"remount,{options}", str(self.folder))


@contextmanager
def small_disk(folder: Path, options: str) -> Iterator[SmallDisk]:
    """Mount one, or skip the test where this user may not.

    Parameters
    ----------
    options : of tmpfs(5), such as `size=64k`
    """
    folder.mkdir()
    try:
        _called("mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder))
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"a disk of this size can only be mounted by root on Linux: {error}")
    try:
        yield SmallDisk(folder)
    finally:
        _called("umount", "--lazy", str(folder))


def _called(*command: str) -> None:
    program = shutil.which(command[0]) or command[0]
    subprocess.run([program, *command[1:]], check=True, capture_output=True)
