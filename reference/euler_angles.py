"""ZYZ Euler angles α, β, γ: R_world_body = Rz(α) Ry(β) Rz(γ) (Fetter & Walecka §29).

β is the angle between the body's third axis and the world's, α the azimuth of the body's third
axis, γ the turn about it. The angles serve to show attitudes, and precession and nutation:
attitudes are compared as rotations, never by these angles.
"""

import numpy as np

from ..scenarios import FloatArray

TURN = 2 * np.pi


def euler_zyz_from_quaternion(q_world_body_wxyz: FloatArray) -> FloatArray:
    """Return the Euler angles of attitudes, rad: α and γ in [−π, π], β in [0, π].

    With q = (w, x, y, z): tan β/2 = √(x² + y²)/√(w² + z²), tan (α + γ)/2 = z/w and
    tan (α − γ)/2 = −x/y. Arctangents of norms keep every digit near the poles, where an arccosine
    loses half of them. At the poles themselves only α + γ (β = 0) or α − γ (β = π) exists:
    there γ is set to 0, and α is that sum or difference.

    Parameters
    ----------
    q_world_body_wxyz : (..., 4), scalar first; q and −q give the same angles

    Returns
    -------
    (..., 3), columns α, β, γ
    """
    w, x, y, z = np.moveaxis(np.asarray(q_world_body_wxyz, dtype=float), -1, 0)
    upright, tilted = np.hypot(w, z), np.hypot(x, y)
    half_sum, half_difference = np.arctan2(z, w), np.arctan2(-x, y)
    half_difference = np.where(tilted == 0, half_sum, half_difference)
    half_sum = np.where(upright == 0, half_difference, half_sum)
    return np.stack(
        [
            _folded(half_sum + half_difference),
            2 * np.arctan2(tilted, upright),
            _folded(half_sum - half_difference),
        ],
        axis=-1,
    )


def rates_from_omega_body(angles: FloatArray, omega_body: FloatArray) -> FloatArray:
    """Return the rates of the Euler angles, α̇, β̇, γ̇, rad/s, (..., 3).

    They solve Fetter & Walecka eq. 29.7 for the rates. All three are NaN where β is exactly 0 or π:
    there α and γ are not separate angles, and β as a function of time has a corner. Close to these
    poles the rates have an error of about ulp(1)/sin β times |ω|.

    Parameters
    ----------
    angles : (..., 3) α, β, γ in rad
    omega_body : (..., 3) rad/s
    """
    _, beta, gamma = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    omega1, omega2, omega3 = np.moveaxis(np.asarray(omega_body, dtype=float), -1, 0)
    sin_beta = np.where((beta == 0) | (beta == np.pi), np.nan, np.sin(beta))
    alpha_rate = (omega2 * np.sin(gamma) - omega1 * np.cos(gamma)) / sin_beta
    beta_rate = omega1 * np.sin(gamma) + omega2 * np.cos(gamma)
    return np.stack(
        [
            alpha_rate,
            np.where(np.isnan(sin_beta), np.nan, beta_rate),
            omega3 - alpha_rate * np.cos(beta),
        ],
        axis=-1,
    )


def _folded(angle: FloatArray) -> FloatArray:
    """Return angles, rad, less whole turns, so that they are in [−π, π].

    An angle that is in this range already keeps its bits.
    """
    return angle - TURN * np.round(angle / TURN)
