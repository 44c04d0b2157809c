"""Two heavy tops with a constant of motion of their own: Kovalevskaya's and Goryachev–Chaplygin's.

Both have two equal moments about the pivot and a third one in a fixed ratio to them; the com is in
the plane of the axes of the equal moments. With e1 towards the com, e3 along the axis of the third
moment, γ the upward vertical along e1, e2, e3 and c = M g l:

    Kovalevskaya, I1 = I2 = 2 I3:                 |(ω1 + iω2)² − (c/I3)(γ1 + iγ2)|²
    Goryachev–Chaplygin, I1 = I2 = 4 I3, L·γ = 0:  ω3(ω1² + ω2²) − (c/I3) ω1 γ3

(S. Kowalevski, Acta Mathematica 12 (1889) 177; D. Goryachev, Mat. Sbornik 21 (1900) 431.)
"""

import numpy as np
from mpmath import mp

from ..scenarios import FloatArray, Trajectory
from ..scenarios.exact import DIGITS, Vector, conjugate, cross, dot, rotate
from .effect_terms import is_undriven
from .problem import Problem
from .symmetry import (
    UNIT_VECTORS,
    angular_momentum_axes,
    equal,
    gravity_torque_scale,
    moment_about,
    norm,
    scaled,
    to_body,
    up_world,
)

#: I1 / I3 of Kovalevskaya's and of Goryachev and Chaplygin's case.
KOVALEVSKAYA_RATIO = 2
GORYACHEV_CHAPLYGIN_RATIO = 4

Frame = tuple[Vector, Vector, Vector]


def kovalevskaya_frame(problem: Problem) -> Frame | None:
    """Return the axes e1, e2, e3 of a Kovalevskaya top, in principal components.

    e1 points to the com, and e3 is along the axis of the moment that differs from the other two.
    The result is None for any other top.
    """
    return _equatorial_frame(problem, KOVALEVSKAYA_RATIO)


def goryachev_chaplygin_frame(problem: Problem) -> Frame | None:
    """Return the axes e1, e2, e3 of a Goryachev–Chaplygin top, in principal components.

    e1 points to the com, and e3 is along the axis of the moment that differs from the other two.
    The result is None for any other top, and if L·ĝ is not 0 at t = 0.
    """
    frame = _equatorial_frame(problem, GORYACHEV_CHAPLYGIN_RATIO)
    if frame is None:
        return None
    with mp.workdps(DIGITS):
        L = angular_momentum_axes(problem)
        g = rotate(conjugate(problem.q_world_axes), problem.gravity_world)
        return frame if equal(dot(L, g), 0, norm(L) * norm(g)) else None


def kovalevskaya(problem: Problem, frame: Frame, motion: Trajectory) -> FloatArray:
    """Return Kovalevskaya's constant at the n samples of a trajectory, rad⁴/s⁴, (n,).

    It is |(ω1 + iω2)² − (M g l/I3)(γ1 + iγ2)|², with γ the upward vertical, along e1, e2, e3.

    Parameters
    ----------
    frame : e1, e2, e3, as `kovalevskaya_frame` returns them
    """
    omega, gamma = _along(problem, frame, motion)
    spin = (omega[:, 0] + 1j * omega[:, 1]) ** 2
    weight = pull_over_third_moment(problem, frame) * (gamma[:, 0] + 1j * gamma[:, 1])
    return np.asarray(np.abs(spin - weight) ** 2)


def goryachev_chaplygin(problem: Problem, frame: Frame, motion: Trajectory) -> FloatArray:
    """Return the Goryachev–Chaplygin constant at the n samples of a trajectory, rad³/s³, (n,).

    It is ω3(ω1² + ω2²) − (M g l/I3) ω1 γ3, with γ the upward vertical, along e1, e2, e3.

    Parameters
    ----------
    frame : e1, e2, e3, as `goryachev_chaplygin_frame` returns them
    """
    omega, gamma = _along(problem, frame, motion)
    weight = pull_over_third_moment(problem, frame)
    across = omega[:, 0] ** 2 + omega[:, 1] ** 2
    return np.asarray(omega[:, 2] * across - weight * omega[:, 0] * gamma[:, 2])


def pull_over_third_moment(problem: Problem, frame: Frame) -> float:
    """Return M g l/I3, s⁻²: a factor in both constants of motion, with I3 the moment about e3."""
    with mp.workdps(DIGITS):
        return float(gravity_torque_scale(problem) / moment_about(problem, frame[2]))


def _along(problem: Problem, frame: Frame, motion: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Return components of ω, rad/s, and of the upward vertical along e1, e2, e3 at n samples.

    Both arrays are (n, 3).
    """
    frame_body = np.array([to_body(problem, axis) for axis in frame], dtype=float)
    up_body = motion.R_world_body.inv().apply(up_world(problem))
    return motion.omega_body @ frame_body.T, up_body @ frame_body.T


def _equatorial_frame(problem: Problem, ratio: int) -> Frame | None:
    """Return e1, e2, e3 of a heavy top with I1 = I2 = ratio · I3, in principal components.

    e1 points to the com. The result is None if the moments are others, if the com is not in the
    plane of e1 and e2, or if anything but gravity turns the body, or nothing does.
    """
    with mp.workdps(DIGITS):
        length = norm(problem.lever_axes)
        if gravity_torque_scale(problem) == 0 or not is_undriven(problem):
            return None
        towards_com = scaled(problem.lever_axes, 1 / length)
        for k in range(3):
            first, second = (problem.moments[(k + shift) % 3] for shift in (1, 2))
            fits = equal(first, second) and equal(first, ratio * problem.moments[k])
            if fits and equal(towards_com[k], 0, 1):
                axis = UNIT_VECTORS[k]
                return (towards_com, cross(axis, towards_com), axis)
    return None
