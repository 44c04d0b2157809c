"""A recorded motion: its numbers, and what holds between its samples."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray
from .columns import QUANTITIES

#: How far a quaternion's norm may be off: what is printed with four digits passes.
UNIT_SLACK = 1e-3


class RecordingError(ValueError):
    """A file that holds no motion that can be judged: one sentence with file, place and remedy."""


@dataclass(frozen=True, eq=False)
class Recording:
    """The numbers of a file in SI units, as it states them.

    Attributes
    ----------
    path : the file
    arrays : t (n,), q (n, 4) and, where the file has them, omega, com, velocity, (n, 3)
    settings : what the file states of itself, by the names of `SETTINGS`
    ignored : headings of columns that mean nothing here
    """

    path: Path
    arrays: dict[str, FloatArray]
    settings: dict[str, str] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()

    @property
    def is_single(self) -> bool:
        """Whether it was computed in single precision: says so, or its attitudes have 24 bits."""
        q = self.arrays["q"]
        has_24_bits = np.array_equal(q, q.astype(np.float32)) and not np.array_equal(q, np.rint(q))
        return self.settings.get("precision", "single" if has_24_bits else "double") == "single"


def check_motion(arrays: dict[str, FloatArray]) -> None:
    """Check what holds between samples: times, and the norms of quaternions."""
    for quantity in QUANTITIES[:2]:
        if quantity.name not in arrays:
            raise RecordingError(f"must have an array '{quantity.name}'")
    times = arrays["t"]
    for name, values in arrays.items():
        if len(values) != len(times):
            raise RecordingError(f"'{name}' must have a row for each time, got {len(values)}")
        if not np.isfinite(values).all():
            raise RecordingError(
                f"'{name}' must be finite, sample {_first(~np.isfinite(values))} is not"
            )
    if len(times) < 2:
        raise RecordingError(f"must have at least two samples, got {len(times)}")
    if times[0] < 0:
        raise RecordingError(f"times must be counted from the scene's start, got {times[0]:g} s")
    if (back := np.diff(times) <= 0).any():
        k = _first(back)
        raise RecordingError(
            f"times must increase, got {times[k - 1]:.17g} s and then {times[k]:.17g} s in samples "
            f"{k - 1} and {k}, counted from 0; sort the samples, and leave out doubled ones"
        )
    norms = np.linalg.norm(arrays["q"], axis=1)
    if (off := np.abs(norms - 1) > UNIT_SLACK).any():
        k = _first(off) - 1
        raise RecordingError(
            f"quaternions must be of unit norm, that of sample {k} is {norms[k]:.4g} long"
        )


def _first(wrong: NDArray[np.bool_]) -> int:
    """The number of the first row with something wrong, counted from one."""
    return int(np.argmax(wrong.reshape(len(wrong), -1).any(axis=1))) + 1
