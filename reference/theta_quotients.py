"""Motions whose Cayley–Klein parameters are quotients of theta functions.

In a frame fixed in the top and one fixed in the world, which each class of top chooses, the
attitude q = (Re A, −Im B, Re B, Im A) and the angular velocity W = ω2 + iω1, ω3 are::

    A, B, W = G e^{iΩt} θ(x − iη)/θ4(x)^(1 or 1/2)        x = x' t + x0

(F. Klein & A. Sommerfeld, Über die Theorie des Kreisels, ch. VI; derivation:
docs/explanation/closed-forms.md).
Each class of top supplies θ, η, and the logarithmic derivative of A, B and W in time. This module
computes Ω and G from them in extended precision; the kernel then sums a few terms at each time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpc, mpf

from ..scenarios import FloatArray
from ..scenarios.exact import Quaternion, Vector
from .doubledouble import split
from .elliptic import EVEN_COSINE, EVEN_SINE, Harmonics, Lattice, Theta, scaled, theta
from .kernel import as_kernels_take
from .theta_kernel import ROWS, ThetaTables, evaluate

#: Number of harmonics kept. Harmonic k is at most e^(−k² π/2) of the first (see `elliptic.TERMS`):
#: the rest is < 4e-34.
KERNEL_TERMS = 7
#: Arguments x at which Ω is computed and checked, in the first half of a cell: it is >= π/2 long.
CHECKED = (mpf(1) / 2, mpf(1))


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """The exact motion of a top, evaluated to double precision at any time.

    Attributes
    ----------
    label : how it was solved, in words
    tables : constants of the theta quotients
    residual : relative error with which the constants solve the equations of motion;
        a rounding error of extended precision if the formulas are right
    period : period of the angular velocity of a free body, or of the nutation of a heavy top, s;
        inf on a separatrix, None where neither varies
    """

    label: str
    tables: ThetaTables
    residual: float
    period: float | None

    def states(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return attitude and angular velocity at given times.

        Parameters
        ----------
        t : (n,) s, any finite times

        Returns
        -------
        q_world_axes (n, 4), w x y z, continuous in t, and omega_axes (n, 3), rad/s
        """
        times = as_kernels_take(t)
        q_world_axes, omega_axes = np.empty((len(times), 4)), np.empty((len(times), 3))
        evaluate(self.tables, times, q_world_axes, omega_axes)
        return q_world_axes, omega_axes


@dataclass(frozen=True)
class Clock:
    """The argument x = rate · t + start of a motion's theta functions.

    Attributes
    ----------
    lattice : periods of the theta functions
    rate : dx/dt, rad/s
    start : x at t = 0, rad, at most half a cell; a cell is the change of x by a half period 2K of
        sn and cn (`Lattice.half_period`)
    """

    lattice: Lattice
    rate: mpf
    start: mpf

    @cached_property
    def theta4(self) -> Theta:
        """The theta function θ4, the denominator of the quotients."""
        return theta(4, self.lattice)


class Quotient(NamedTuple):
    """A complex function of time: numerator over √θ4^power, times a phase factor.

    Attributes
    ----------
    real, imaginary : series of the numerator's real and imaginary part
    halved : whether these series are in x/2
    power : power of √θ4 in the denominator
    turns_per_second, turns_at_start, turns_per_cell : the phase, in turns: its rate, its value at
        t = 0, and its change by each cell of the argument x (see `Clock`)
    """

    real: Harmonics
    imaginary: Harmonics
    halved: bool
    power: int
    turns_per_second: mpf
    turns_at_start: mpf
    turns_per_cell: mpf


class InitialValue(NamedTuple):
    """The value of a function of time at t = 0, and its derivative by time, in its unit per s."""

    value: mpc
    slope: mpc


class Frames(NamedTuple):
    """The rotations from the two frames that A and B relate to the world and to the principal axes.

    A and B are the Cayley–Klein parameters, and q(A, B) is their quaternion.

    Attributes
    ----------
    q_left, q_right : q_world_axes = q_left q(A, B) q_right
    columns_axes : vectors c1, c2, c3 in principal components: ω is ω1 c1 + ω2 c2 + ω3 c3
    """

    q_left: Quaternion
    q_right: Quaternion
    columns_axes: tuple[Vector, Vector, Vector]


NOTHING = Harmonics(EVEN_SINE, ())
ONE = Harmonics(EVEN_COSINE, (mpf(1),))


def turning(value: mpc, rate: mpf = 0) -> Quotient:
    """Return value · e^{i rate t} as a quotient without theta functions; `rate` is in rad/s."""
    real = Harmonics(EVEN_COSINE, (abs(value),))
    turns = mp.arg(value) / (2 * mp.pi)
    return Quotient(real, NOTHING, False, 0, rate / (2 * mp.pi), turns, mpf(0))


def over_theta4(real: Harmonics, imaginary: Harmonics, turns_per_cell: mpf) -> Quotient:
    """Return the quotient (real + i imaginary)/θ4, with a phase that changes only between cells.

    A cell is a half period of sn and cn. `turns_per_cell` is the change of phase from one cell to
    the next, in turns: 1/2 for a function that changes its sign, else 0.
    """
    return Quotient(real, imaginary, False, 2, mpf(0), mpf(0), turns_per_cell)


def fitted(
    clock: Clock, numerator: Theta, power: int, start: InitialValue, log_rate: Callable[[mpf], mpc]
) -> tuple[Quotient, mpf]:
    """Return the quotient f = G e^{iΩt} θ/√θ4^power with f' = f · log_rate(x), and its residual.

    iΩ = log_rate − (ln(θ/√θ4^power))' is the same at every x: it is computed at one x and checked
    at another. G is fitted to value and derivative at t = 0 by least squares, as one of the two may
    vanish.

    Parameters
    ----------
    clock : x as a function of t
    numerator : θ
    power : power of √θ4 in the denominator
    start : f and f' at t = 0
    log_rate : f'/f, 1/s, as a function of x

    Returns
    -------
    The quotient, and the sum of the relative residuals of Ω and of the fit
    """
    rates = []
    for x in CHECKED:
        value, slope = _without_phase(clock, numerator, power, x)
        rates.append(log_rate(x) - clock.rate * slope / value)
    rate = rates[0].imag
    value, slope = _without_phase(clock, numerator, power, clock.start)
    slope = slope + mpc(0, 1) * rate / clock.rate * value
    size = abs(value) ** 2 + abs(slope) ** 2
    wanted = start.value, start.slope / clock.rate
    factor = (mp.conj(value) * wanted[0] + mp.conj(slope) * wanted[1]) / size
    misfit = abs(factor * value - wanted[0]) + abs(factor * slope - wanted[1])
    residual = sum(abs(r - mpc(0, rate)) for r in rates) / max(abs(rate), clock.rate)
    residual += misfit / (abs(factor) * mp.sqrt(size))
    # From a cell to the next θ changes sign; the factor that a hyperbolic series leaves out changes
    # the phase as well.
    turns_per_cell = mpf(1) / 2 - (numerator.eta / mp.pi if numerator.hyperbolic else 0)
    quotient = Quotient(
        scaled(numerator.real, abs(factor)),
        scaled(numerator.imaginary, abs(factor)),
        numerator.stretch != 1,
        power,
        rate / (2 * mp.pi),
        mp.arg(factor) / (2 * mp.pi),
        turns_per_cell,
    )
    return quotient, residual


def tables(clock: Clock | None, quotients: Sequence[Quotient], frames: Frames) -> ThetaTables:
    """Return the constants of a closed form for the kernel, rounded to doubles and double-doubles.

    Parameters
    ----------
    clock : the argument of the theta functions; None if all quotients are made by `turning`
    quotients : the Cayley–Klein parameters A and B, W = ω2 + iω1, and ω3
    frames : the rotations that relate the frames of A and B to the world and to principal axes
    """
    denominator = ONE if clock is None else clock.theta4.real
    rows = [*quotients, over_theta4(denominator, NOTHING, mpf(0))]
    coefficients = np.zeros((ROWS, 2, KERNEL_TERMS))
    for row, quotient in enumerate(rows):
        for part, harmonics in enumerate(quotient[:2]):
            kept = harmonics.coefficients[:KERNEL_TERMS]
            coefficients[row, part, : len(kept)] = [float(a) for a in kept]
    endless = clock is not None and clock.lattice.m1 == 0
    return ThetaTables(
        hyperbolic=clock is not None and clock.lattice.hyperbolic,
        endless=endless,
        clock=_clock_constants(clock, endless),
        kinds=np.array([[q.real.kind, q.imaginary.kind] for q in rows]),
        coefficients=coefficients,
        halved=np.array([q.halved for q in rows]),
        power=np.array([q.power for q in rows]),
        phases=np.array([[split(turns) for turns in q[4:]] for q in rows]),
        left=np.array(frames.q_left, dtype=float),
        right=np.array(frames.q_right, dtype=float),
        axes=np.array(frames.columns_axes, dtype=float).T.copy(),
    )


def _clock_constants(clock: Clock | None, endless: bool) -> FloatArray:
    if clock is None:
        return np.zeros((3, 2))
    cell = mpf(1) if endless else clock.lattice.half_period
    return np.array([split(clock.rate / cell), split(clock.start / cell), split(cell)])


def _without_phase(clock: Clock, numerator: Theta, power: int, x: mpf) -> tuple[mpc, mpc]:
    """Return θ/√θ4^power at real x, with θ the numerator, and its derivative by x."""
    above, above_slope = numerator.value_and_slope(x)
    below, below_slope = (part.real for part in clock.theta4.value_and_slope(x))
    root = mp.sqrt(below) ** power
    value = above / root
    return value, above_slope / root - mpf(power) / 2 * below_slope / below * value
