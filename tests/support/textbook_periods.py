"""Periods of tops as textbooks print them, in so many digits that cancellations do not matter."""

from typing import NamedTuple

from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.scenarios.exact import conjugate, dot, rotate

#: L² − 2 E I2 and the differences of roots cancel in a third of these, at most.
DIGITS = 200


class Textbook(NamedTuple):
    """Rate p, parameter m and its complement."""

    p: mpf
    m: mpf
    m1: mpf

    @property
    def K(self) -> mpf:
        with mp.workdps(DIGITS):
            return mp.pi / 2 / mp.agm(1, mp.sqrt(self.m1))

    @property
    def pole(self) -> mpf:
        """K'/p, s: how far from the real axis of time the nearest singularity is."""
        with mp.workdps(DIGITS):
            return mp.pi / 2 / mp.agm(1, mp.sqrt(self.m)) / self.p


def free_body(problem: Problem) -> Textbook:
    """Landau & Lifshitz, Mechanics, §37, eqs. 37.8–37.12; I2 in the middle."""
    with mp.workdps(DIGITS):
        I1, I2, I3 = problem.moments
        w = problem.omega_axes
        E2 = sum(i * x * x for i, x in zip(problem.moments, w, strict=True))
        L2 = sum((i * x) ** 2 for i, x in zip(problem.moments, w, strict=True))
        p = mp.sqrt((I3 - I2) * (L2 - E2 * I1) / (I1 * I2 * I3))
        m = (I2 - I1) * (E2 * I3 - L2) / ((I3 - I2) * (L2 - E2 * I1))
        m1 = (I3 - I1) * (L2 - E2 * I2) / ((I3 - I2) * (L2 - E2 * I1))
        return Textbook(p, m, m1)


def heavy_top(problem: Problem) -> Textbook:
    """Goldstein, Classical Mechanics, §5.7: lever along the third axis, gravity along −z."""
    with mp.workdps(DIGITS):
        I1, w = problem.moments[0], problem.omega_axes
        kappa = -problem.lever_axes[2] * problem.gravity_world[2]
        vertical = rotate(conjugate(problem.q_world_axes), (0, 0, 1))
        length = mp.sqrt(dot(problem.q_world_axes, problem.q_world_axes))
        cosine = vertical[2] / length**2
        L = [i * x for i, x in zip(problem.moments, w, strict=True)]
        p_alpha, p_gamma = dot(L, vertical) / length**2, L[2]
        alpha = (I1 * (w[0] ** 2 + w[1] ** 2) + 2 * kappa * cosine) / I1
        beta, a, b = 2 * kappa / I1, p_gamma / I1, p_alpha / I1
        cubic = [(b * b - alpha) / beta, 1 - 2 * a * b / beta, (alpha + a * a) / beta]
        companion = mp.matrix([[0, 0, cubic[0]], [1, 0, cubic[1]], [0, 1, cubic[2]]])
        u1, u2, u3 = sorted(mp.re(root) for root in mp.eig(companion, left=False, right=False))
        p = mp.sqrt(beta * (u3 - u1)) / 2
        return Textbook(p, (u2 - u1) / (u3 - u1), (u3 - u2) / (u3 - u1))
