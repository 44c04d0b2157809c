"""The verdict on a derivative, from its gain and the model of the gains of steps.

The gain of a derivative is the Jacobian of a step minus that of the exact motion, divided by the
timestep. If the derivative is consistent, its gain is a series that vanishes with the timestep
(`measuring/gain_series.py`).
"""

from dataclasses import dataclass, replace

import numpy as np

from ....scenarios import FloatArray
from ...results.evidence import CONSISTENT, LEVEL
from ...results.verdict_words import VerdictWord
from ..measuring.gain_series import GainSeries, fitted
from ..measuring.noise import SURE, ULPS
from .candidates import KNOWN, Exact, candidates
from .jacobians import CHART, Own, Units

#: A Jacobian has two halves, the rows of attitude and those of ω. Each is judged by itself.
HALVES = 2


@dataclass(frozen=True)
class Judged:
    """The verdict on a derivative, and the values that it rests on.

    Attributes
    ----------
    verdict : converges, disagrees, unresolved, unsupported or failed
    reason : why, in words; empty if the derivative converges and is that of the engine's step
    order : order with which the derivative approaches the exact motion's as timesteps vanish
    limit : size of the limit of the gain as timesteps vanish, relative to the fastest rate
    known_to : standard error of that limit, relative to the fastest rate
    off_own : relative distance from finite differences of the engine's own steps; None if the
        derivative is not that of a step, is not finite, or is itself these differences
    is_own : whether that distance is no more than rounding and the truncation error of finite
        differences explain; None if it was not tested
    """

    verdict: VerdictWord
    reason: str = ""
    order: int = 0
    limit: float = 0.0
    known_to: float = 0.0
    off_own: float | None = None
    is_own: bool | None = None


def noise_of(units: Units, timesteps: FloatArray, condition: float, epsilon: float) -> FloatArray:
    """Return the standard deviation of the noise of gains in each column of Jacobians, (J, 6).

    It is in 1/s; components of Jacobians are in `units`.

    Parameters
    ----------
    units : units of attitude and ω
    timesteps : J timesteps, s, (J,)
    condition : factor by which a relative error of moments of inertia grows: `Places.condition`
    epsilon : ε of finite differences, rad and rad/s; 0 for exact derivatives. The truncation error
        of differences grows with ε. It counts as noise up to ε = the cube root of an ulp, which is
        best for central differences; what exceeds this counts as a fault
    """
    rounding, each = ULPS * units.ulp, units.each
    of_state = rounding * (each / epsilon if epsilon else np.ones(CHART))
    omitted = ULPS * units.rate * np.minimum(epsilon / each, units.ulp ** (1 / 3))
    of_body = rounding * condition * units.rate
    return np.asarray(of_state / timesteps[:, None] + omitted + of_body)


def judged(exact: Exact, found: FloatArray, noise: FloatArray) -> Judged:
    """Return the verdict on the Jacobians of steps, by comparison with the exact ones.

    If they disagree, the verdict's reason is the first of `candidates` that explains them, if any.

    Parameters
    ----------
    exact : the exact Jacobians
    found : the Jacobians to be judged, from K states over J spans of time, (J, K, 6, 6)
    noise : standard deviation of the gains' noise in each column of Jacobians, 1/s, (J, 6)
    """
    units = exact.units
    if not np.isfinite(found).all():
        wrong = int((~np.isfinite(found).all(axis=(2, 3))).sum())
        words = f"it is not finite from {wrong} of {found[..., 0, 0].size} states"
        return Judged("disagrees", words)
    series = _series(exact, found - exact.jacobians, noise)
    limits = np.linalg.norm(_joined(series), axis=(1, 2)) / units.rate
    known_to = max(float(one.limit_error.max()) for one in series) / units.rate
    one = Judged("converges", "", min(one.order for one in series), float(limits.max()), known_to)
    if _tail(series) < LEVEL:
        off = np.abs(_gains(exact, found - exact.jacobians))[-1].max()
        rough = np.hypot(noise, KNOWN * units.rate)
        per_rate = _joined(series) * units.each[:, None] / units.each
        for name, made in candidates(exact, per_rate):
            unlike = np.abs(_gains(exact, made - exact.jacobians)).max()
            left = np.abs(_gains(exact, found - made))[-1].max()
            if unlike < SURE * KNOWN * units.rate or left > off / 2:
                continue
            if _tail(_series(exact, found - made, rough)) >= LEVEL:
                return replace(one, verdict="disagrees", reason=name)
        words = f"off by {off / units.rate:.2g}, by no known mistake"
        return replace(one, verdict="disagrees", reason=words)
    if known_to > CONSISTENT:
        return replace(one, verdict="unresolved", reason=f"known to {known_to:.1g} only")
    return one


def beside_own(one: Judged, exact: Exact, found: FloatArray, own: Own, noise: FloatArray) -> Judged:
    """Return a verdict, completed by comparing the derivative with the engine's own steps.

    Parameters
    ----------
    one : the verdict by comparison with the exact Jacobians
    exact : the exact Jacobians
    found : the Jacobians that the engine computes, from K states with J timesteps, (J, K, 6, 6)
    own : the Jacobians that finite differences of the engine's steps give
    noise : standard deviation of the gains' noise in each column of Jacobians, 1/s, (J, 6)
    """
    units = exact.units
    wanted = units.of(own.jacobians)
    apart = units.of(found) - wanted
    of_found = noise * exact.spans[:, None]
    most = SURE * (of_found + own.known_to[:, None])[:, None, None, :]
    is_own = bool((np.abs(apart) <= most).all())
    reason = one.reason
    if is_own and reason:
        reason += "; the engine's own steps do the same"
    elif not is_own and not reason:
        # If the engine does not normalise q, the norm of q is a factor of the attitude's rows.
        rows, turned = apart[..., :3, :], wanted[..., :3, :]
        factor = (rows * turned).sum((2, 3), keepdims=True) / (turned**2).sum((2, 3), keepdims=True)
        left = np.concatenate([rows - factor * turned, apart[..., 3:, :]], axis=2)
        unnormed = ": the attitude is not normalised" if (np.abs(left) <= most).all() else ""
        reason = f"it is not the derivative of the engine's own step{unnormed}"
    far = np.abs(apart[0]).max() / np.abs(wanted - np.eye(CHART)).max()
    return replace(one, reason=reason, off_own=float(far), is_own=is_own)


def _series(exact: Exact, off: FloatArray, noise: FloatArray) -> list[GainSeries]:
    """Return the series that are fitted to the gains in attitude and to those in ω.

    In each column of the Jacobian from each of K states, the three components of attitude, or of ω,
    are fitted like the gain from one state.

    Parameters
    ----------
    exact : the exact Jacobians
    off : differences of Jacobians from the exact ones, over J spans of time, (J, K, 6, 6)
    noise : standard deviation of the gains' noise in each column, 1/s, (J, 6)
    """
    J, K = off.shape[:2]
    columns = np.swapaxes(_gains(exact, off), 2, 3).reshape(J, K * CHART, CHART)
    each = np.tile(noise, (1, K))
    # Columns by finite differences share a step. So they are not independent, and are not pooled.
    return [
        fitted(exact.spans, half, each, LEVEL / HALVES, may_split=False, is_pooled=False)
        for half in np.split(columns, HALVES, axis=2)
    ]


def _gains(exact: Exact, off: FloatArray) -> FloatArray:
    """Return gains, 1/s: differences of Jacobians in `exact.units`, divided by the spans of time.

    Their shape is that of `off`.

    Parameters
    ----------
    off : the differences, for J spans of time and K states, (J, K, 6, 6)
    """
    return np.asarray(exact.units.of(off) / exact.spans[:, None, None, None])


def _tail(series: list[GainSeries]) -> float:
    """Return the tail of all tests of both series together (Bonferroni).

    Parameters
    ----------
    series : two: of the gains in attitude, and of the gains in ω
    """
    return min(1.0, HALVES * min(one.tail for one in series))


def _joined(series: list[GainSeries]) -> FloatArray:
    """Return the limits of gains from K states, 1/s, as entries of Jacobians, (K, 6, 6).

    Parameters
    ----------
    series : two: of the gains in attitude, and of the gains in ω
    """
    rows = np.concatenate([one.limit for one in series], axis=1)
    return np.swapaxes(rows.reshape(-1, CHART, CHART), 1, 2)
