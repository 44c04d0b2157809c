"""What theory says of a scene and a timestep before anything is run: rates, and limits on them.

A small deviation that oscillates at the rate λ is multiplied in one step of h by a number of the
size |R(ihλ)|, R being the method's stability function (Hairer & Wanner, Solving Ordinary
Differential Equations II, §IV.2). λ is that of ω in body axes, where engines integrate it: a
symmetric body's ω goes round its axis at (I3 − I1)/I1 ω3, however fast the axis nutates in space.
"""

import math
from dataclasses import dataclass

import numpy as np
from mpmath import mp

from ..scenarios import FloatArray, Scenario
from ..scenarios.exact import DIGITS
from . import stability
from .effect_terms import is_free
from .heavy_symmetric_top import heavy_symmetric_top
from .problem import Problem
from .rotational_problem import rotational_problem
from .symmetry import equal, gravity_torque_scale

#: Classical Runge–Kutta on the imaginary axis, R(z) = 1 + z + z²/2 + z³/6 + z⁴/24:
#: |R(iy)|² = 1 − y⁶/72 + y⁸/576 is at most 1 up to here (Hairer & Wanner II, §IV.2).
RK4_LIMIT = 2 * math.sqrt(2)
#: Where |R(iy)| is least: y⁸/576 − y⁶/72 is, at y² = 6.
RK4_STRONGEST = math.sqrt(6)
#: Semi-implicit Euler and leapfrog on an oscillator: the matrix of a step has determinant 1 and
#: trace 2 − y², so its eigenvalues are on the unit circle up to here (Hairer, Lubich & Wanner,
#: Geometric Numerical Integration, ch. XIII).
LEAPFROG_LIMIT = 2.0
#: rad a step: no method resolves a turn that it sees a few times only.
COARSE_TURN = 1.0
#: rad from the vertical: a top that leans by less has been set up to sleep, and nudged.
UPRIGHT = 0.1


@dataclass(frozen=True)
class StabilityNumbers:
    """What decides on the stability of a scene and of its integration, at t = 0.

    Attributes
    ----------
    turning : ‖ω‖, rad/s
    gyration : the fastest rate of Euler's equations linearised about ω(0), and of a free body about
        ω where it has none about the middle axis, rad/s; |I3 − I1|/I1 |ω3| of a symmetric one
    swinging : the fastest rate of small swings about hanging at rest, rad/s; 0 without gravity
        and pivot
    duration : of the scene's window, s
    sleeping : p_γ²/(4 M g l I1) of an upright heavy symmetric top: from 1 on it stays up
    separatrix : (L² − 2 T I2)/L² of a free body whose moments differ: its sign is the axis that ω
        goes round
    """

    turning: float
    gyration: float
    swinging: float
    duration: float
    sleeping: float | None
    separatrix: float | None


def stability_numbers(scenario: Scenario) -> StabilityNumbers:
    """The stability numbers of a scene."""
    problem = rotational_problem(scenario)
    moments, omega = np.array(problem.moments, float), np.array(problem.omega_axes, float)
    return StabilityNumbers(
        turning=float(np.linalg.norm(omega)),
        gyration=max(_fastest(_euler_jacobian(moments, omega)), _rate_across(problem)),
        swinging=_swinging(problem),
        duration=scenario.window.duration,
        sleeping=_sleeping(problem),
        separatrix=_separatrix(problem),
    )


def rk4_log_amplification(y: float) -> float:
    """ln |R(iy)| of the classical Runge–Kutta method (Hairer & Wanner II, §IV.2)."""
    return math.log1p(y**8 / 576 - y**6 / 72) / 2


def euler_log_amplification(y: float) -> float:
    """ln |R(iy)| of explicit Euler, R(z) = 1 + z; of implicit Euler, 1/(1 − z), with a minus."""
    return math.log1p(y**2) / 2


def euler_folds(rate: float, timestep: float, duration: float) -> float:
    """How many times Euler makes a deviation e times as large (implicit: as small) in a window.

    For small steps ½ λ² h · duration.

    Parameters
    ----------
    rate : λ, rad/s
    timestep, duration : s
    """
    return duration / timestep * euler_log_amplification(rate * timestep)


def rk4_folds(rate: float, timestep: float, duration: float) -> float:
    """How many times classical Runge–Kutta makes a deviation e times as small in a window.

    For small steps λ⁶ h⁵/144 · duration. Beyond its strongest damping as much as there.
    """
    y = min(rate * timestep, RK4_STRONGEST)
    return -duration / timestep * rk4_log_amplification(y)


def _euler_jacobian(moments: FloatArray, omega: FloatArray) -> FloatArray:
    """∂/∂ω of I⁻¹(Iω × ω), 1/s, (3, 3); principal axes (Landau & Lifshitz, Mechanics, eq. 36.5)."""
    spins = np.eye(3)
    columns = np.cross(moments * spins, omega) + np.cross(moments * omega, spins)
    return np.asarray(columns.T / moments[:, None])


def _rate_across(problem: Problem) -> float:
    """The rate about ω where it crosses the plane of the extreme axes, rad/s; 0 if not free.

    λ² = [(I3 − I2)(L² − 2 T I1) + (I2 − I1)(2 T I3 − L²)]/(I1 I2 I3), moments ascending, by what T
    and L² make of ω there (Landau & Lifshitz, Mechanics, §37). A body that starts about its middle
    axis is fastest here.
    """
    if not is_free(problem):
        return 0.0
    with mp.workdps(DIGITS):
        low, middle, high = sorted(problem.moments)
        pairs = list(zip(problem.moments, problem.omega_axes, strict=True))
        above_low = mp.fsum(m * (m - low) * w**2 for m, w in pairs)
        below_high = mp.fsum(m * (high - m) * w**2 for m, w in pairs)
        square = (high - middle) * above_low + (middle - low) * below_high
        return float(mp.sqrt(square / (low * middle * high)))


def _fastest(jacobian: FloatArray) -> float:
    return float(np.abs(np.linalg.eigvals(jacobian)).max())


def _swinging(problem: Problem) -> float:
    """√ of the largest eigenvalue of I⁻¹ M g l (1 − n nᵀ), n the direction of the com."""
    with mp.workdps(DIGITS):
        torque = float(gravity_torque_scale(problem))
    if not torque:
        return 0.0
    lever = np.array(problem.held_lever, float)
    n = lever / np.linalg.norm(lever)
    across = np.eye(3) - np.outer(n, n)
    stiffness = torque * across / np.array(problem.moments, float)[:, None]
    return math.sqrt(_fastest(stiffness))


def _sleeping(problem: Problem) -> float | None:
    """Arnold, Mathematical Methods of Classical Mechanics, §31: stays up from 1 on."""
    top = heavy_symmetric_top(problem)
    if top is None:
        return None
    with mp.workdps(DIGITS):
        upright = bool(top.cos_beta >= mp.cos(UPRIGHT))
        threshold = 4 * top.kappa * top.I1
        return float(top.p_gamma**2 / threshold) if upright else None


def _separatrix(problem: Problem) -> float | None:
    low, middle, high = sorted(problem.moments)
    if not is_free(problem) or equal(low, middle) or equal(middle, high):
        return None
    return stability.separatrix_distance(problem.moments, problem.omega_axes)
