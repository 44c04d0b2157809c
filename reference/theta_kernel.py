"""Evaluates a top's motion from tables of theta quotients, at full speed in double precision.

The argument and the phases grow with time without bound. Each is the product of a time and of a
constant in double-double. Whole turns are subtracted exactly, and only the rest is rounded: after a
billion periods the error is that of the first.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scenarios import FloatArray
from .doubledouble import two_prod, two_sum
from .elliptic import EVEN_SINE, ODD_COSINE, ODD_SINE
from .kernel import allocating, kernel

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Quaternion = tuple[float, float, float, float]

#: On the separatrix, a motion is at its saddle beyond this argument: it is e^-300 = 5e-131 away.
FAR = 300.0

#: Rows of the tables: the quotients, and the denominator θ4.
A, B, W, OMEGA3, THETA4, ROWS = 0, 1, 2, 3, 4, 5


class ThetaTables(NamedTuple):
    """The constants of a closed form for the kernel; the formulas are in `theta_quotients`.

    A and B are the Cayley–Klein parameters, and W = ω2 + iω1.

    Attributes
    ----------
    hyperbolic : whether harmonics are sinh and cosh
    endless : whether the motion never repeats, on a separatrix: its argument is not reduced
    clock : (3, 2) double-doubles: cells per second, cells at t = 0, and argument per cell. A cell
        is a half period 2K of sn and cn, or 1 for a motion that never repeats
    kinds : (ROWS, 2) kind of harmonics of the real and the imaginary part
    coefficients : (ROWS, 2, n) coefficients of the harmonics
    halved : (ROWS,) whether the series is in x/2
    power : (ROWS,) power of √θ4 in the denominator
    phases : (ROWS, 3, 2) double-doubles: each phase in turns, per second, at t = 0 and per cell
    left, right : (4,) quaternions by which that of A and B is multiplied on the left and the right
    axes : (3, 3) matrix from ω in the frame of A, B and W to ω along the principal axes
    """

    hyperbolic: bool
    endless: bool
    clock: FloatArray
    kinds: IntArray
    coefficients: FloatArray
    halved: BoolArray
    power: IntArray
    phases: FloatArray
    left: FloatArray
    right: FloatArray
    axes: FloatArray


@kernel
def _cell(t: float, clock: FloatArray, endless: bool) -> tuple[float, float, float]:
    """Return the theta functions' argument at a time t, s, in cells: whole cells, and the rest.

    A cell is a half period of sn and cn. The first two rows of `clock` are double-doubles: cells
    per second, and cells at t = 0. The rest is a double-double, as high and low part, in
    [-1/2, 1/2]. For an endless motion, which never repeats, the number of whole cells is 0, and the
    rest is all of the argument.
    """
    p, e = two_prod(t, clock[0, 0])
    s, f = two_sum(p, clock[1, 0])
    cell = 0.0 if endless else np.rint(s)
    high, low = two_sum(s - cell, e + f + t * clock[0, 1] + clock[1, 1])
    return cell, high, low


@kernel
def _unit(t: float, cell: float, phase: FloatArray) -> tuple[float, float]:
    """Return cosine and sine of the phase t · phase[0] + phase[1] + cell · phase[2], in turns.

    t is the time, s, and `cell` the number of whole cells that `_cell` returns. `phase` has a
    double-double in each of its three rows: the phase per second, at t = 0 and per cell.
    """
    p, e = two_prod(t, phase[0, 0])
    r, f = two_prod(cell, phase[2, 0])
    s, g = two_sum(p - np.rint(p), r - np.rint(r))
    s, h = two_sum(s, phase[1, 0])
    rest = e + f + g + h + t * phase[0, 1] + cell * phase[2, 1] + phase[1, 1]
    quarter = np.rint(4.0 * s)
    angle = ((s - 0.25 * quarter) + rest) * math.tau
    c, s = math.cos(angle), math.sin(angle)
    which = int(quarter) & 3
    if which == 0:
        return c, s
    if which == 1:
        return -s, c
    if which == 2:
        return -c, -s
    return s, -c


@kernel
def _series(kind: int, a: FloatArray, s: float, c: float, s2: float, c2: float) -> float:
    """Return the sum of a series of harmonics by Clenshaw's recurrence (DLMF 3.11.ii).

    `kind` and `a` are the kind of the harmonics and their coefficients; s, c and s2, c2 are sine
    and cosine of x and of 2x.
    """
    b0 = b1 = 0.0
    for k in range(a.size - 1, -1, -1):
        b0, b1 = a[k] + 2.0 * c2 * b0 - b1, b0
    if kind == ODD_SINE:
        return s * (b0 + b1)
    if kind == ODD_COSINE:
        return c * (b0 - b1)
    if kind == EVEN_SINE:
        return s2 * b1
    return b0 - c2 * b1  # even cosines


@kernel
def _harmonics(x: float, hyperbolic: bool) -> tuple[float, float, float, float]:
    """Return sine and cosine of x and of 2x, hyperbolic or circular."""
    if hyperbolic:
        s, c = math.sinh(x), math.cosh(x)
        return s, c, 2.0 * s * c, 1.0 + 2.0 * s * s
    s, c = math.sin(x), math.cos(x)
    c2 = 1.0 - 2.0 * s * s if abs(s) < abs(c) else 2.0 * c * c - 1.0
    return s, c, 2.0 * s * c, c2


@kernel
def _product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return Hamilton's product p q."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@kernel
def _quotients(t: float, tables: ThetaTables, values: FloatArray) -> None:
    """Write real and imaginary part of A, B, W and ω3 at a time t, s, into `values`, (ROWS, 2).

    A and B are the Cayley–Klein parameters, and W = ω2 + iω1, rad/s.
    """
    cell, high, low = _cell(t, tables.clock, tables.endless)
    if tables.endless:
        high = min(max(high, -FAR), FAR)
    x = high * tables.clock[2, 0] + (high * tables.clock[2, 1] + low * tables.clock[2, 0])
    s, c, s2, c2 = _harmonics(x, tables.hyperbolic)
    s_half, c_half, _, _ = _harmonics(0.5 * x, tables.hyperbolic)
    a = tables.coefficients
    below = _series(tables.kinds[THETA4, 0], a[THETA4, 0], s, c, s2, c2)
    for row in range(THETA4):
        for part in range(2):
            kind = tables.kinds[row, part]
            if tables.halved[row]:
                values[row, part] = _series(kind, a[row, part], s_half, c_half, s, c)
            else:
                values[row, part] = _series(kind, a[row, part], s, c, s2, c2)
        power = tables.power[row]
        divisor = 1.0 if power == 0 else below if power == 2 else math.sqrt(below)
        u, v = values[row, 0] / divisor, values[row, 1] / divisor
        cosine, sine = _unit(t, cell, tables.phases[row])
        values[row, 0] = u * cosine - v * sine
        values[row, 1] = u * sine + v * cosine


@allocating
def evaluate(
    tables: ThetaTables, times: FloatArray, q_world_axes: FloatArray, omega_axes: FloatArray
) -> None:
    """Write the motion at given times into two arrays.

    Parameters
    ----------
    tables : constants of the motion's closed form
    times : s, (n,)
    q_world_axes : attitudes, w x y z, which are written, (n, 4)
    omega_axes : ω along the principal axes, rad/s, which is written, (n, 3)
    """
    values = np.empty((ROWS, 2))
    left = (tables.left[0], tables.left[1], tables.left[2], tables.left[3])
    right = (tables.right[0], tables.right[1], tables.right[2], tables.right[3])
    axes = tables.axes
    for i in range(times.size):
        _quotients(times[i], tables, values)
        q = (values[A, 0], -values[B, 1], values[B, 0], values[A, 1])
        q = _product(_product(left, q), right)
        for k in range(4):
            q_world_axes[i, k] = q[k]
        omega1, omega2, omega3 = values[W, 1], values[W, 0], values[OMEGA3, 0]
        for k in range(3):
            omega_axes[i, k] = axes[k, 0] * omega1 + axes[k, 1] * omega2 + axes[k, 2] * omega3
