"""The heavy symmetric top in its constants of motion: V_eff, turning points, steady precession.

β is the angle between the top's axis, from the pivot to the com, and the upward vertical −g; its
cosine is u. With I1 the moment across the axis and I3 about it, both about the pivot, and
κ = M g l > 0 (Goldstein §5.7; Landau & Lifshitz, Mechanics, §35, problem 1):

    p_α = L·(−ĝ)        p_γ = I3 ω3        E' = E − p_γ²/2 I3 = ½ I1 β̇² + V_eff(β)
    V_eff(β) = (p_α − p_γ cos β)² / (2 I1 sin²β) + κ cos β
    u̇² = (2 κ/I1) (u − u1)(u − u2)(u − u3),   −1 ≤ u1 ≤ u ≤ u2 ≤ 1 ≤ u3

A top whose tip slides on a smooth table obeys the same with l from the tip's centre, both moments
about the com, and ½ m l² sin²β β̇² more of kinetic energy, as the com rises and falls: u̇² is
divided by 1 + ε (1 − u²), ε = m l²/I1. The turning points are the same, and what is an elliptic
integral on a pivot is a quadrature.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from mpmath import mp, mpf

from ..scenarios import FloatArray
from ..scenarios.exact import DIGITS, ZERO, Vector, conjugate, cross, dot, rotate
from ..scenarios.principal import EQUAL_TO_WORKING_PRECISION
from .nutation import turning_points
from .problem import Problem
from .symmetry import (
    angular_momentum_axes,
    equal,
    gravity_torque_scale,
    moments_across_and_along,
    norm,
    scaled,
    symmetry_axis,
)

#: Digits in which roots are computed: where two or three roots of the nutation cubic meet, a
#: root has only half or a third of the digits.
ROOT_DIGITS = 3 * DIGITS
#: Number of tops whose elliptic integrals are kept, because every run of a scene asks for them.
RECENT_TOPS = 8


@dataclass(frozen=True)
class HeavySymmetricTop:
    """A heavy symmetric top at one instant, in extended precision.

    Attributes
    ----------
    I1, I3 : moments across the axis and about it, kg m²: about the pivot, on a table about the com
    kappa : M g l, N m, positive
    p_alpha, p_gamma : angular momentum along the vertical and along the axis, kg m²/s
    energy : kinetic energy, without that of the com's horizontal motion on a table, plus κ cos β, J
    cos_beta : cosine of the axis's angle from the upward vertical
    heave : m l²/I1 on a table, 0 on a pivot
    """

    I1: mpf
    I3: mpf
    kappa: mpf
    p_alpha: mpf
    p_gamma: mpf
    energy: mpf
    cos_beta: mpf
    heave: mpf = ZERO[0]

    @cached_property
    def E_prime(self) -> mpf:
        """The energy of nutation, precession and height, J: all but that of the spin, p_γ²/2 I3."""
        with mp.workdps(ROOT_DIGITS):
            return self.energy - self.p_gamma**2 / (2 * self.I3)

    @cached_property
    def roots(self) -> Vector:
        """The zeros u1 ≤ u2 ≤ 1 ≤ u3 of u̇² as a cubic in u = cos β.

        They are computed as distances from the pole u = 1 or u = −1 that is nearer to the start, so
        that roots close to this pole stay distinct however close they are to each other.
        """
        with mp.workdps(ROOT_DIGITS):
            pole = 1 if self.cos_beta >= 0 else -1
            at_pole = pole * self.kappa
            spare = mpf(0) if equal(self.E_prime, at_pole) else self.E_prime - at_pole
            deltas = turning_points(
                pole,
                2 * self.kappa / self.I1,
                self.p_gamma / self.I1,
                2 * spare / self.I1,
                (self.p_alpha - pole * self.p_gamma) / self.I1,
            )
            u1, u2, u3 = (pole * (1 - delta) for delta in deltas)
            return (_at_most_one(u1), _at_most_one(u2), u3)

    @property
    def reaches_the_vertical(self) -> bool:
        """Whether β reaches 0 or π, where precession and spin are not separate angles."""
        return bool(self.roots[0] == -1 or self.roots[1] == 1)


def heavy_symmetric_top(problem: Problem) -> HeavySymmetricTop | None:
    """Return a problem's state at t = 0 as that of a heavy symmetric top; None if it is not one.

    The top is on a pivot, or on a table with gravity along the vertical. Effects other than gravity
    are ignored: if there are any, the "constants" of motion hold at t = 0 only.
    """
    axis = symmetry_axis(problem)
    with mp.workdps(DIGITS):
        kappa = gravity_torque_scale(problem)
        if axis is None or kappa == 0 or (problem.slides and any(problem.gravity_world[:2])):
            return None
        up_world = scaled(problem.gravity_world, -1 / norm(problem.gravity_world))
        up = rotate(conjugate(problem.q_world_axes), up_world)
        omega = problem.omega_axes
        L = angular_momentum_axes(problem)
        cos_beta, p_gamma, p_alpha = dot(axis, up), dot(L, axis), dot(L, up)
        if equal(abs(cos_beta), mpf(1)):
            cos_beta = mp.sign(cos_beta)
        for sign in (1, -1):
            if equal(p_alpha, sign * p_gamma, norm(L)):
                p_alpha = sign * p_gamma
        I1, I3 = moments_across_and_along(problem, axis)
        heave = problem.heaving / I1
        rising = dot(up, cross(omega, axis))
        energy = (dot(omega, L) + heave * I1 * rising**2) / 2 + kappa * cos_beta
        return HeavySymmetricTop(I1, I3, kappa, p_alpha, p_gamma, energy, cos_beta, heave)


def effective_potential(top: HeavySymmetricTop, beta: FloatArray) -> FloatArray:
    """Return the effective potential V_eff of the nutation, J, at angles β, rad, in [0, π].

    (p_α − p_γ cos β)/sin β is summed as ½ (p_α − p_γ) cot β/2 + ½ (p_α + p_γ) tan β/2: no digits
    cancel in either term, and a term whose factor p_α ∓ p_γ is zero has no pole. Otherwise V_eff is
    infinite at the pole, β = 0 or π. p_α and p_γ are the angular momenta along the vertical and
    along the axis.
    """
    beta = np.asarray(beta, dtype=float)
    with mp.workdps(DIGITS):
        less, more = float(top.p_alpha - top.p_gamma), float(top.p_alpha + top.p_gamma)
    cos_half, sin_half = np.where(beta == np.pi, 0.0, np.cos(beta / 2)), np.sin(beta / 2)
    across = np.zeros_like(beta)
    with np.errstate(divide="ignore"):
        if less:
            across += less * (cos_half / sin_half)
        if more:
            across += more * (sin_half / cos_half)
    return across**2 / (8 * float(top.I1)) + float(top.kappa) * np.cos(beta)


def nutation_bounds(top: HeavySymmetricTop) -> tuple[float, float]:
    """Return the smallest and the largest tilt β, rad, that energy and angular momenta allow.

    If the top sleeps unstably, the largest β is the one that the smallest push would lead to.
    """
    with mp.workdps(ROOT_DIGITS):
        u1, u2, _ = top.roots
        return float(mp.acos(u2)), float(mp.acos(u1))


@lru_cache(maxsize=RECENT_TOPS)
def nutation_period(top: HeavySymmetricTop) -> float:
    """Return the period of cos β, s: on a pivot 2 √(2 I1/κ) R_F(0, u3 − u2, u3 − u1).

    u1, u2, u3 are `top.roots`, κ is M g l, and R_F is Carlson's integral (DLMF 19.25.1). On a
    separatrix the period is inf; for steady precession it is that of a small nutation.
    """
    with mp.workdps(ROOT_DIGITS):
        u1, u2, u3 = top.roots
        if equal(u3, u2):
            return float("inf")
        if top.heave:
            return float(_over_a_nutation(top, lambda _: mpf(1)))
        return float(2 * mp.sqrt(2 * top.I1 / top.kappa) * mp.elliprf(0, u3 - u2, u3 - u1))


@lru_cache(maxsize=RECENT_TOPS)
def mean_precession_rate(top: HeavySymmetricTop) -> float | None:
    """Return the rate of precession α̇ averaged over a nutation, rad/s.

    It is None if the axis reaches the vertical, or if the nutation never ends, on a separatrix.

    With u = cos β, α̇ = [(p_α − p_γ)/(1 − u) + (p_α + p_γ)/(1 + u)]/2 I1; p_α and p_γ are the
    angular momenta about the vertical and the axis. On a pivot u = u1 + (u2 − u1) sn², with u1 and
    u2 the turning points, and each term's mean is its value at u1 times Π(n|m)/K(m), a ratio of
    complete elliptic integrals (DLMF 19.2.7).
    """
    period = nutation_period(top)
    if top.reaches_the_vertical or period == float("inf"):
        return None
    with mp.workdps(ROOT_DIGITS):
        u1, u2, u3 = top.roots
        if top.heave:
            turned = _over_a_nutation(
                top, lambda u: (top.p_alpha - top.p_gamma * u) / (top.I1 * (1 - u * u))
            )
            return float(turned / period)
        m = (u2 - u1) / (u3 - u1)
        down = (top.p_alpha - top.p_gamma) / (1 - u1) * mp.ellippi((u2 - u1) / (1 - u1), m)
        up = (top.p_alpha + top.p_gamma) / (1 + u1) * mp.ellippi((u1 - u2) / (1 + u1), m)
        return float((down + up) / (2 * top.I1 * mp.ellipk(m)))


def steady_precession_rates(top: HeavySymmetricTop, cos_beta: mpf) -> tuple[float, ...]:
    """Return the rates Ω, rad/s, at which the top can precess steadily at a given tilt β.

    They are the roots of I1 cos β Ω² − p_γ Ω + κ = 0 (Goldstein §5.7; Klein & Sommerfeld, Theory of
    the Top, ch. V), the slow one first; p_γ is the angular momentum about the axis, and κ is M g l.
    There are none, one or two; they are real where p_γ² ≥ 4 κ I1 cos β.
    """
    with mp.workdps(DIGITS):
        lead = top.I1 * cos_beta
        square, least = top.p_gamma**2, 4 * top.kappa * lead
        discriminant = mpf(0) if equal(square, least) else square - least
        if discriminant < 0 or (lead == 0 and top.p_gamma == 0):
            return ()
        # The root of the usual formula in which like signs add; the other one follows by Viète.
        larger = (top.p_gamma + (-1 if top.p_gamma < 0 else 1) * mp.sqrt(discriminant)) / 2
        slow = float(top.kappa / larger)
        if lead == 0 or discriminant == 0:
            return (slow,)
        return (slow, float(larger / lead))


def sleeping_threshold(top: HeavySymmetricTop) -> float:
    """Return the least angular momentum about its axis that keeps a top upright, kg m²/s.

    It is √(4 κ I1), with κ = M g l (Arnold §31).
    """
    with mp.workdps(DIGITS):
        return float(mp.sqrt(4 * top.kappa * top.I1))


def steady_angle(top: HeavySymmetricTop) -> float:
    """Return the angle β at the minimum of the effective potential, rad.

    A top with the same angular momenta p_α and p_γ about the vertical and the axis would precess
    steadily at this angle. u = cos β solves
    (p_α − p_γ u)(p_γ − p_α u) = κ I1 (1 − u²)², with κ = M g l; the left side less the right has
    opposite signs at the two turning points.
    """
    with mp.workdps(ROOT_DIGITS):
        return float(mp.acos(_at_most_one(_bottom(top))))


def small_nutation_frequency(top: HeavySymmetricTop) -> float:
    """Return the angular frequency of small oscillations of cos β about V_eff's minimum, rad/s.

    ω² = V_eff''/I1 = (p_γ² − 4 κ I1 cos β)/I1² + Ω² sin²β, where Ω is the rate of steady precession
    at the minimum (Goldstein §5.7 for V_eff; V_eff' = 0 is used to simplify V_eff''), p_γ the
    angular momentum about the axis, and κ = M g l. On a table ω² is divided by 1 + ε sin²β,
    ε = `top.heave`.
    """
    with mp.workdps(ROOT_DIGITS):
        u = _bottom(top)
        square = (top.p_gamma**2 - 4 * top.kappa * top.I1 * u) / top.I1**2
        if abs(u) < 1:
            square += ((top.p_alpha - top.p_gamma * u) / top.I1) ** 2 / (1 - u * u)
        square /= 1 + top.heave * (1 - u * u)
        return float(mp.sqrt(max(square, mpf(0))))


def _over_a_nutation(top: HeavySymmetricTop, rate: Callable[[mpf], mpf]) -> mpf:
    """Return ∫ rate(u) dt over one period of the nutation of a top on a table.

    u is cos β; u1, u2, u3 are `top.roots`; ε is `top.heave`. With u = u1 + (u2 − u1) sin²φ the
    integrand is smooth, dt = √(2 I1/κ) √((1 + ε (1 − u²))/(u3 − u)) dφ, and φ goes from 0 to π.
    """
    u1, u2, u3 = top.roots

    def integrand(phi: mpf) -> mpf:
        u = u1 + (u2 - u1) * mp.sin(phi) ** 2
        return rate(u) * mp.sqrt((1 + top.heave * (1 - u * u)) / (u3 - u))

    with mp.workdps(DIGITS):
        half = mp.quad(integrand, [0, mp.pi / 2])
        return 2 * mp.sqrt(2 * top.I1 / top.kappa) * half


def _bottom(top: HeavySymmetricTop) -> mpf:
    """Return cos β at the effective potential's minimum, found between the turning points."""
    u1, u2, _ = top.roots

    def slope(u: mpf) -> mpf:
        """Return (1 − u²)² I1 dV_eff/du: negative below the minimum, positive above it."""
        pull = top.kappa * top.I1 * (1 - u * u) ** 2
        return pull - (top.p_alpha - top.p_gamma * u) * (top.p_gamma - top.p_alpha * u)

    low, high = u1, u2
    while high - low > EQUAL_TO_WORKING_PRECISION:
        middle = (low + high) / 2
        low, high = (middle, high) if slope(middle) < 0 else (low, middle)
    return (low + high) / 2


def _at_most_one(u: mpf) -> mpf:
    """Return u = cos β, moved to 1 or −1 if it is beyond, or differs from it by rounding only."""
    if equal(abs(u), mpf(1)) or abs(u) > 1:
        return mp.sign(u)
    return u
