"""What was made of the body's ω, where the attitudes alone obey equations of motion.

Between two attitudes the equations of motion lead by one ω: that of the body. The recorded ω may
be it, clamped, or what a linear filter makes of it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.special import fdtrc

from ....reference.following import follow
from ....reference.other_equations import OtherEquations
from ....scenarios import FloatArray, Trajectory
from ....scenarios.rotation import norms, rotation_vectors
from ..explaining.fit import Data
from ..explaining.hypothesis import Hypothesis, as_it_is
from ..explaining.search import LEFT, LEVEL, SAME, Search
from .clamps import CLAMPS
from .intervals import NEAR
from .missing import is_attitude_off, turned_off
from .motion_changes import sentences
from .other_physics import Physics
from .sensors import CROSS_AXIS, OF_LOGS, as_read

#: Newton steps to the ω that leads to the next attitude, and the relative step of its slopes.
STEPS, SMALL = 4, 1e-6
#: Samples of earlier filtered ω, and of the body's ω, that a filter is made of at most.
OUTPUTS, INPUTS = 2, 5
#: How many weights of a filter are looked at.
WEIGHTS = 200
#: Most samples that a mean is taken over.
MOST_SMOOTHED = 60
#: Times of samples are equally far apart up to this, relative.
EQUAL = 1e-6
OMEGA = "the attitudes obey the scene's equations, but the recorded ω is not that of the attitudes"


@dataclass(frozen=True, eq=False)
class ReadOmega(Data):
    """The ω of samples, as it was recorded and as it was.

    Attributes
    ----------
    t : s, (n,)
    body : q, scalar first, and the body's ω, rad/s, body axes, (n, 7)
    read : the recorded ω, rad/s, (n, 3)
    error : of the body's ω, rad/s
    """

    t: FloatArray
    body: FloatArray
    read: FloatArray
    error: float

    def deviations(
        self, hypotheses: Sequence[Hypothesis], samples: int | None = None
    ) -> FloatArray:
        """As in `Data`: what each leaves of ω, in units of the error, (H, n, 3)."""
        made = as_read(hypotheses, np.repeat(self.body[None], len(hypotheses), axis=0), self.t)
        return np.asarray((made[..., 4:] - self.read) / self.error)[:, :samples]


def omega_read(physics: Physics, *, is_explained: bool) -> list[str]:
    """Return what was made of ω, in words; nothing if the attitudes are off the scene's equations.

    Parameters
    ----------
    physics : of the motion with the recorded ω; by its `base`, if it has one, the attitudes go
    is_explained : whether other mistakes of reading ω explain the motion: then a clamp alone, which
        has one number, is simpler
    """
    motion = physics.motion
    turns = norms(physics.exact.omega_body)[:-1] * np.diff(motion.t)
    # Attitudes that are late obey the equations, too.
    is_late = physics.base is None and is_attitude_off(motion, physics.exact)
    if is_late or turns.max() > NEAR:
        return []
    base = physics.base or as_it_is(physics.scenario)
    states = np.hstack([motion.q_world_body_wxyz, motion.omega_body])
    of_body = _omega_between(base.equations, states, np.diff(motion.t))
    if of_body is None or physics.intervals is None:
        return []
    read = motion.omega_body[:-1]
    # What an attitude is off by, ω is off by over the distance of two.
    attitude = np.hypot(physics.noise[0], physics.intervals.method[:, 0].max())
    # Attitudes that are the exact motion's at their times are no further off than that.
    off = 0.0 if physics.base else turned_off(motion, physics.exact)
    attitude = min(attitude, max(physics.noise[0], off))
    error = physics.noise[1] + 2 * attitude / float(np.diff(motion.t).min())
    cut = motion.until(len(read))
    by_attitudes = replace(
        physics,
        motion=replace(cut, omega_body=of_body),
        exact=physics.exact.until(len(read)),
        noise=np.array([physics.noise[0], error]),
    )
    apart = norms(read - of_body)
    if by_attitudes.search is None or by_attitudes.is_beyond or np.max(apart) * LEFT < error:
        return []
    body = np.hstack([states[:-1, :4], of_body])
    simple = next(_clamped(body, read, error), []) or _differences(motion)
    # What filters make of ω is off throughout, and not at some samples alone.
    if simple or is_explained or np.mean(apart**2) <= error**2:
        return simple
    return (
        _sensed(ReadOmega(base, motion.t[:-1], body, read, error))
        or _smoothed_or_filtered(motion.t, of_body, read, error)
        or [OMEGA]
    )


def _omega_between(
    equations: OtherEquations, states: FloatArray, spans: FloatArray
) -> FloatArray | None:
    """Return ω, rad/s, body axes, (n - 1, 3), by which each attitude leads to the next one.

    None if there is none near the mean of the turn.
    """
    q, ends = states[:-1, :4], states[1:, :4]
    omega = rotation_vectors(q, ends) / spans[:, None]
    size = float(norms(omega).max()) or 1.0

    def off(omega: FloatArray) -> FloatArray:
        made = follow(equations, np.hstack([q, omega]), spans[:, None])[:, 0, :4]
        return np.nan_to_num(rotation_vectors(made, ends), nan=np.inf)

    for _ in range(STEPS):
        left = off(omega)
        if not np.isfinite(left).all():
            return None
        step = SMALL * size
        slopes = np.stack([(off(omega + step * one) - left) / step for one in np.eye(3)], axis=2)
        if not np.isfinite(slopes).all() or (np.abs(np.linalg.det(slopes)) == 0).any():
            return None
        omega = omega - np.linalg.solve(slopes, left[..., None])[..., 0]
    return omega if norms(off(omega)).max() < SMALL else None


def _clamped(body: FloatArray, read: FloatArray, error: float) -> Iterator[list[str]]:
    """Yield the clamp, in words, that makes the recorded ω of the body's.

    Parameters
    ----------
    body : q and the body's ω, (n, 7)
    read : the recorded ω, (n, 3)
    error : of the body's ω, rad/s
    """
    for words, size_of, limited in CLAMPS:
        bound = float(size_of(np.hstack([body[:, :4], read])).max())
        made = limited(body, bound)[:, 4:]
        off, changed = (float(norms(one - made).max()) for one in (read, body[:, 4:]))
        # Where all of ω is beyond the bound it may as well be a factor.
        is_clamp = size_of(body).min() < bound and changed > error / LEFT
        if is_clamp and off <= max(error, LEFT**2 * changed):
            yield [f"{words} is clamped to {bound:.4g} rad/s"]


def _differences(motion: Trajectory) -> list[str]:
    """Return that ω is a difference of the recorded attitudes, in words, if it is one."""
    t, q, omega = motion.t, motion.q_world_body_wxyz, motion.omega_body
    rates = rotation_vectors(q[:-1], q[1:]) / np.diff(t)[:, None]
    least = LEFT**2 * float(norms(np.diff(rates, axis=0)).max())
    over_two = rotation_vectors(q[:-2], q[2:]) / (t[2:] - t[:-2])[:, None]
    for words, made, read in (
        ("since the sample before, which is half a sample late", rates, omega[1:]),
        ("until the next sample, which is half a sample early", rates, omega[:-1]),
        ("from the sample before to the next one", over_two, omega[1:-1]),
    ):
        if norms(read - made).max() < least:
            return [f"ω is the mean rate of the recorded attitudes {words}"]
    return []


def _sensed(data: ReadOmega) -> list[str]:
    """Return the mistakes of a gyroscope that make the recorded ω of the body's, in words."""
    found = Search(data, (*OF_LOGS, CROSS_AXIS), part=LEFT**2).one()
    return sentences(found) if found else []


def _smoothed_or_filtered(
    t: FloatArray, body: FloatArray, read: FloatArray, error: float
) -> list[str]:
    """Return the mean, or else the filter, of the body's ω that the recorded one is, in words.

    A mean is simpler: a filter must leave far less, of what is more than rounding.
    """
    off = float(np.mean((read - body) ** 2))
    mean, filter_ = (f(t, body, read, error) for f in (_smoothed, _filtered))
    if mean and filter_ and max(filter_[0] / LEFT**2, SAME**2 * off) < mean[0]:
        mean = None
    found = mean or filter_
    return [found[1]] if found else []


def _smoothed(
    t: FloatArray, body: FloatArray, read: FloatArray, error: float
) -> tuple[float, str] | None:
    """Return what the mean over some samples leaves that is the recorded ω, and it in words.

    What it leaves is a mean square, (rad/s)²; None if there is no such mean.
    """
    off = float(np.mean((read - body) ** 2))
    for samples in range(2, min(MOST_SMOOTHED, len(read) // 2)):
        means = np.apply_along_axis(np.convolve, 0, body, np.ones(samples) / samples, "valid")
        for later, words in (((samples - 1) // 2, "around each"), (samples - 1, "up to each")):
            left = float(np.mean((read[later : later + len(means)] - means) ** 2))
            is_even = words == "around each" and samples % 2 == 0
            explains = left <= min(max(error**2, LEFT**4 * off), LEFT**2 * off)
            if not is_even and explains:
                over = (samples - 1) * (t[-1] - t[0]) / (len(t) - 1)
                return left, f"ω is the mean over {samples} samples, {over:.4g} s, {words}"
    return None


@dataclass(frozen=True, eq=False)
class Filter:
    """A linear filter: read(k) = Σ outputs[i] read(k - 1 - i) + Σ inputs[j] body(k - j).

    Attributes
    ----------
    left : the mean square of what it leaves, (rad/s)²
    """

    outputs: FloatArray
    inputs: FloatArray
    left: float

    @property
    def delay(self) -> float:
        """The delay of a slow change, in samples: the slope of the phase at rest."""
        ages = np.arange(len(self.inputs)) @ self.inputs / self.inputs.sum()
        own = np.arange(1, len(self.outputs) + 1) @ self.outputs / (1 - self.outputs.sum())
        return float(ages + own)

    @property
    def is_causal(self) -> bool:
        """Whether it delays what it filters, forgets it, and is a mean; others are no filters.

        Where a filter swings over, weights may be somewhat below zero.
        """
        poles = np.roots([1.0, *-self.outputs])
        if not (self.delay > 0 and self.outputs.sum() >= 0 and (np.abs(poles) < 1).all()):
            return False
        weights: list[float] = []
        for n in range(WEIGHTS):
            direct = float(self.inputs[n]) if n < len(self.inputs) else 0.0
            before = zip(self.outputs, reversed(weights), strict=False)
            weights.append(direct + sum(a * weight for a, weight in before))
        return min(weights) >= -LEFT * max(weights)

    @property
    def words(self) -> str:
        """Its formula."""
        before = ["", " a sample before", *(f" {j} samples before" for j in range(2, INPUTS))]
        parts = [(a, f"of itself{when}") for a, when in zip(self.outputs, before[1:], strict=False)]
        parts += [(b, f"of the body's{when}") for b, when in zip(self.inputs, before, strict=False)]
        return ", ".join(f"{factor:.4g} {what}" for factor, what in parts)


def _filtered(
    t: FloatArray, body: FloatArray, read: FloatArray, error: float
) -> tuple[float, str] | None:
    """Return what the filter with the fewest numbers leaves, as `_smoothed` does, and its words."""
    spans = np.diff(t)
    if np.ptp(spans) > EQUAL * spans.mean():
        return None
    off = float(np.mean((read - body) ** 2))
    filters = (
        _filter(body, read, outputs, inputs)
        for outputs, inputs in sorted(product(range(OUTPUTS + 1), range(1, INPUTS + 1)), key=sum)
    )
    for one in filters:
        count, numbers = 3 * len(read), len(one.outputs) + len(one.inputs)
        fall = (off - one.left) / max(one.left, error**2) * (count - numbers) / numbers
        enough = min(max(error**2, LEFT**4 * off), LEFT**2 * off)
        explains = one.left <= enough and one.is_causal
        if explains and fdtrc(numbers, count - numbers, fall) < LEVEL / (OUTPUTS + 1) / INPUTS:
            delay = one.delay * spans.mean()
            words = f"ω is filtered, which delays it by {delay:.4g} s: it is {one.words}"
            return one.left, words
    return None


def _filter(body: FloatArray, read: FloatArray, outputs: int, inputs: int) -> Filter:
    """Fit a filter with so many numbers to all samples that have as many before them."""
    first = max(outputs, inputs - 1)
    rows = np.arange(first, len(read))
    columns = [read[rows - 1 - i].ravel() for i in range(outputs)]
    columns += [body[rows - j].ravel() for j in range(inputs)]
    A, wanted = np.array(columns).T, read[rows].ravel()
    numbers: FloatArray = np.linalg.lstsq(A, wanted, rcond=None)[0].astype(float)
    a, b = numbers[:outputs], numbers[outputs:]
    # By what was read before, anything smooth is found; a filter makes it of the body's ω alone.
    made = [*read[:first]]
    # One that is not stable grows without bounds.
    with np.errstate(over="ignore", invalid="ignore"):
        for k in rows:
            before = sum((w * made[k - 1 - i] for i, w in enumerate(a)), np.zeros(3))
            made.append(before + b @ body[k - np.arange(inputs)])
        left = float(np.mean((read - np.array(made))[first:] ** 2))
    return Filter(a, b, left if np.isfinite(left) else np.inf)
