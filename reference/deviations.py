"""Deviations of recorded states from computed ones, in compiled code for fits of many motions."""

import math

import numpy as np

from ..scenarios import FloatArray
from .kernel import as_kernels_take, kernel


def apart(computed: FloatArray, recorded: FloatArray) -> FloatArray:
    """Return the deviations of S recorded states from computed ones, (..., S, 6).

    Each is a rotation vector from the computed to the recorded attitude, rad, and the recorded less
    the computed ω, rad/s, both in body axes.

    Parameters
    ----------
    computed : q, scalar first, and ω, rad/s, of one or several computations, (..., S, 7)
    recorded : recorded q, scalar first, and ω, rad/s, (S, 7)
    """
    off = np.empty((*computed.shape[:-1], 6))
    shape = math.prod(computed.shape[:-2]), len(recorded)
    each = as_kernels_take(computed).reshape(*shape, 7)
    _fill(each, as_kernels_take(recorded), off.reshape(*shape, 6))
    return off


@kernel
def _fill(computed: FloatArray, recorded: FloatArray, off: FloatArray) -> None:
    """Write the deviations of S recorded states from those of H computations into `off`, (H, S, 6).

    States are q, scalar first, and ω, rad/s, body axes: `computed`, (H, S, 7), and `recorded`,
    (S, 7). Deviations are as `apart` describes them.
    """
    for n in range(computed.shape[0]):
        for s in range(computed.shape[1]):
            a, b = computed[n, s], recorded[s]
            # The quaternion conj(a) b.
            w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
            x = a[0] * b[1] - b[0] * a[1] - (a[2] * b[3] - a[3] * b[2])
            y = a[0] * b[2] - b[0] * a[2] - (a[3] * b[1] - a[1] * b[3])
            z = a[0] * b[3] - b[0] * a[3] - (a[1] * b[2] - a[2] * b[1])
            sine = math.sqrt(x * x + y * y + z * z)
            # For no rotation the vector is zero, whatever the factor is.
            factor = math.copysign(2 * math.atan2(sine, abs(w)), w) / (sine if sine != 0.0 else 1.0)
            off[n, s, 0], off[n, s, 1], off[n, s, 2] = factor * x, factor * y, factor * z
            for i in range(3):
                off[n, s, 3 + i] = b[4 + i] - a[4 + i]
