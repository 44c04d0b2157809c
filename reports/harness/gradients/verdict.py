"""The verdict on a derivative: what it gains beyond the exact one, by the model of steps.

A step's Jacobian minus the exact motion's, over the timestep, is a series that vanishes with it
where the derivative is consistent (`measuring/gain_series.py`).
"""

from dataclasses import dataclass, replace

import numpy as np

from ....scenarios import FloatArray
from ...results.evidence import CONSISTENT, LEVEL
from ...results.verdict_words import VerdictWord
from ..measuring.gain_series import GainSeries, fitted
from ..measuring.noise import ULPS
from .candidates import KNOWN, Exact, candidates
from .jacobians import CHART, Own, Units

#: Halves of the rows, each judged by itself: attitude and ω.
HALVES = 2
#: Standard deviations within which a derivative is that of the engine's own step.
SURE = 8.0


@dataclass(frozen=True)
class Judged:
    """What was found of a derivative.

    Attributes
    ----------
    verdict : converges, disagrees, unresolved, unsupported or failed
    reason : in words
    order : with which it approaches the motion's derivative as timesteps vanish
    limit : what is left then, relative to the fastest rate
    known_to : that the limit is known to, likewise
    off_own : distance from differences of the engine's own steps, relative; None if it is a
        derivative of no step, or these differences themselves
    is_own : whether that is no more than rounding and ε make; None likewise
    """

    verdict: VerdictWord
    reason: str = ""
    order: int = 0
    limit: float = 0.0
    known_to: float = 0.0
    off_own: float | None = None
    is_own: bool | None = None


def noise_of(units: Units, timesteps: FloatArray, condition: float, epsilon: float) -> FloatArray:
    """The standard deviation of what a derivative gains, in units, 1/s, (J, 6) by columns.

    Parameters
    ----------
    condition : that rounding of the moments grows by
    epsilon : of finite differences, rad and rad/s; 0 of exact derivatives. What they omit grows
        with it, and is a fault beyond the cube root of an ulp, where central ones are best
    """
    rounding, each = ULPS * units.ulp, units.each
    of_state = rounding * (each / epsilon if epsilon else np.ones(CHART))
    omitted = ULPS * units.rate * np.minimum(epsilon / each, units.ulp ** (1 / 3))
    of_body = rounding * condition * units.rate
    return np.asarray(of_state / timesteps[:, None] + omitted + of_body)


def judged(exact: Exact, found: FloatArray, noise: FloatArray) -> Judged:
    """Judge Jacobians of steps, (J, K, 6, 6), whose noise by columns is known, (J, 6)."""
    units = exact.units
    if not np.isfinite(found).all():
        wrong = int((~np.isfinite(found).all(axis=(2, 3))).sum())
        words = f"it is not finite from {wrong} of {found[..., 0, 0].size} states"
        return Judged("disagrees", words)
    series = _series(exact, found - exact.jacobians, noise)
    limits = np.linalg.norm(_joined(series), axis=(1, 2)) / units.rate
    known_to = max(float(one.known_to.max()) for one in series) / units.rate
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
    """The verdict with how far Jacobians are from those of the engine's own steps."""
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
        # |q| is a factor of the attitude's rows if q is not normalised (`in_chart`).
        rows, turned = apart[..., :3, :], wanted[..., :3, :]
        factor = (rows * turned).sum((2, 3), keepdims=True) / (turned**2).sum((2, 3), keepdims=True)
        left = np.concatenate([rows - factor * turned, apart[..., 3:, :]], axis=2)
        unnormed = ": the attitude is not normalised" if (np.abs(left) <= most).all() else ""
        reason = f"it is not the derivative of the engine's own step{unnormed}"
    far = np.abs(apart[0]).max() / np.abs(wanted - np.eye(CHART)).max()
    return replace(one, reason=reason, off_own=float(far), is_own=is_own)


def _series(exact: Exact, off: FloatArray, noise: FloatArray) -> list[GainSeries]:
    """The series of rows of attitude and of ω: each column of each state is a vector of three."""
    J, K = off.shape[:2]
    columns = np.swapaxes(_gains(exact, off), 2, 3).reshape(J, K * CHART, CHART)
    each = np.tile(noise, (1, K))
    # Columns of differences share a step, so that they are not judged together.
    return [
        fitted(exact.spans, half, each, LEVEL / HALVES, may_split=False, is_pooled=False)
        for half in np.split(columns, HALVES, axis=2)
    ]


def _gains(exact: Exact, off: FloatArray) -> FloatArray:
    return np.asarray(exact.units.of(off) / exact.spans[:, None, None, None])


def _tail(series: list[GainSeries]) -> float:
    """The probability of what both halves gain."""
    return min(1.0, HALVES * min(one.tail for one in series))


def _joined(series: list[GainSeries]) -> FloatArray:
    """The limits of all columns as Jacobians, (K, 6, 6)."""
    rows = np.concatenate([one.limit for one in series], axis=1)
    return np.swapaxes(rows.reshape(-1, CHART, CHART), 1, 2)
