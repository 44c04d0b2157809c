"""What the gains of steps tend to as their timesteps vanish, and whether they are of one function.

A gain is a power series of the timestep (Hairer, Nørsett & Wanner I, §II.8), so that Neville's rule
extrapolates it, and each is predicted by the polynomial through its neighbours.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray
from ...scenarios.float_array import read_only

#: An excess counts if it is so many times what its extrapolation is known to.
ABOVE = 8.0
#: A gain is predicted from those with so many coarser timesteps and so many finer ones.
COARSER, FINER = 3, 2
#: Ratio of two timesteps that are not the same.
ANOTHER = 1 + 1e-9
#: Where it is predicted from one side alone: on the other, steps may be computed otherwise.
ONE_SIDED = 5
#: A gain is off its prediction if it is by so many times the prediction's error.
DISTINCT = 4.0
#: Quantities of which what is as good as nothing may be a formula's for small angles, as in DART.
OF_FORMULAS = np.array([1.0, 0.0, 0.0, 0.0])
#: Gains that the last one is predicted from, to see the noise of all.
PREDICTING = 4
#: Sets of weights kept: all methods take steps of the same lengths.
KEPT = 1 << 10


@dataclass(frozen=True, eq=False)
class Gains:
    """Gains with J timesteps of K states, R times each, and the rounding of one of them.

    `values` is (J, R, K, 4, 3), `rounding` (J, K, 4).
    """

    timesteps: FloatArray
    values: FloatArray
    rounding: FloatArray


def _uncertainty(values: FloatArray, rounding: FloatArray) -> FloatArray:
    """What the mean of repeats is known to, (…, K, 4), from (…, R, K, 4, 3).

    It is seen in their scatter, of all states at the median at least; of a single one it is what
    rounding may be.
    """
    repeats = values.shape[-4]
    if repeats == 1:
        return rounding
    errors = values.std(axis=-4, ddof=1).max(axis=-1) / np.sqrt(repeats)
    return np.asarray(ABOVE * np.maximum(errors, np.median(errors, axis=-2, keepdims=True)))


def noise_of(timesteps: FloatArray, gains: FloatArray) -> FloatArray:
    """What noise of the states makes of a gain times its timestep, (4,).

    It is seen where no smooth function is left: the last gain is compared with what four before it
    predict, at the median of all states.
    """
    h = timesteps[-PREDICTING - 1 :]
    weights = _weights(tuple(h[:-1]), h[-1])
    left = gains[-1] - _weighted(weights, gains[-PREDICTING - 1 : -1])
    share = np.sqrt(1 + ((weights * h[-1] / h[:-1]) ** 2).sum())
    noise = np.median(np.abs(left).max(axis=2), axis=0) * h[-1] / share
    return np.asarray(ABOVE * noise)


def surprises(
    nodes: Gains, at: Gains, least: int, negligible: FloatArray
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """How far each gain is from what those with neighbouring timesteps predict, (J, K, 4) twice.

    The second is of those that timesteps on one side alone do predict: an engine computes steps
    below or above some length otherwise, and what it does there vanishes with the timestep, too.
    That counts where it is less than half of a step's own gain, or as good as nothing, and known
    better than it is large. The third is whether only coarser ones predict it, so that what is
    computed otherwise begins at the next finer timestep.

    A turn by a formula for small angles, which is as good as exact, counts as nothing.

    Parameters
    ----------
    least : coarser ones that there must be to predict it
    negligible : what is as good as nothing, (4,)
    """
    apart, branched = np.zeros((2, *at.rounding.shape))
    of_formulas = negligible * OF_FORMULAS
    is_last = np.zeros(at.rounding.shape, dtype=bool)
    for j, timestep in enumerate(at.timesteps):
        coarser = np.flatnonzero(nodes.timesteps > ANOTHER * timestep)
        finer = np.flatnonzero(nodes.timesteps * ANOTHER < timestep)
        if len(coarser) < least:
            continue
        here = Gains(at.timesteps[j : j + 1], at.values[j], at.rounding[j])
        off, error = _beyond(nodes, [*coarser[-COARSER:], *finer[:FINER]], here)
        small = np.maximum(_sizes(here.values) / 2, negligible)
        is_of = np.zeros((2, *off.shape), dtype=bool)
        for k, side in enumerate((coarser[-COARSER:], finer[:ONE_SIDED])):
            if len(side) >= COARSER:
                off_side, error_side = _beyond(nodes, [*side], here)
                is_clear = error_side <= np.maximum(off, of_formulas)
                is_of[k] = (off_side <= error_side) & is_clear & (off <= small)
        is_branch = is_of.any(axis=0) & (off > error)
        apart[j] = off - margins((off > error) & ~is_branch) * error - of_formulas
        apart[j][is_branch] = 0.0
        branched[j] = np.where(is_branch, off, 0.0)
        is_last[j] = is_branch & ~is_of[1]
    return apart, branched, is_last


def margins(is_beyond: NDArray[np.bool_]) -> FloatArray:
    """The factors by which states, (K, 4), must be beyond a bound to count, (4,).

    One of all states may be by accident: it must be distinctly.
    """
    return np.where(is_beyond.sum(axis=0) == 1, DISTINCT, 1.0)


def _beyond(nodes: Gains, near: list[int], at: Gains) -> tuple[FloatArray, FloatArray]:
    """How far gains with one timestep are off their prediction, and its error, (K, 4) each.

    Consistent gains vanish at h = 0, which is one more point of the polynomial. What leaving out
    one of its two coarsest timesteps, or both, changes is the error of a prediction: by accident
    one such change may be small, as where the coarsest is too long for a series of it to converge
    (Drake's roll-pitch-yaw angles near their pole). So may all of a state: the median of all states
    counts at least.
    """
    timestep = float(at.timesteps[0])
    h, values = nodes.timesteps[near].tolist(), nodes.values[near]
    weights = _weights((*h, 0.0), timestep)[:-1]
    predicted = _weighted(weights, values)
    fewer = [[0], [1]] if len(near) <= COARSER else [[0], [1], [0, 1]]
    change = np.max([_changed(h, values, one, timestep, predicted) for one in fewer], axis=0)
    error = DISTINCT * np.maximum(change, np.median(change, axis=0))
    rounded = at.rounding + _weighted(np.abs(weights), nodes.rounding[near])
    left = at.values - predicted
    error += _uncertainty(left, ABOVE * rounded) + _alike(left, rounded)
    return _sizes(left), error


def _changed(
    h: list[float], values: FloatArray, left_out: list[int], timestep: float, predicted: FloatArray
) -> FloatArray:
    """What leaving out some timesteps changes of a prediction, (K, 4)."""
    fewer = [k for k in range(len(h)) if k not in left_out]
    weights = _weights((*(h[k] for k in fewer), 0.0), timestep)[:-1]
    return _sizes(predicted - _weighted(weights, values[fewer]))


def _sizes(gains: FloatArray) -> FloatArray:
    """The largest component of the mean of repeats, (K, 4), from (R, K, 4, 3)."""
    mean = gains[0] if len(gains) == 1 else gains.mean(axis=0)
    return np.asarray(np.abs(mean).max(axis=2))


def _weighted(weights: FloatArray, values: FloatArray) -> FloatArray:
    """The sum of n values, each an array, in half the time of `numpy.tensordot`."""
    total: FloatArray = np.dot(weights[None], values.reshape(len(values), -1))
    return total.reshape(values.shape[1:])


@lru_cache(maxsize=KEPT)
def _weights(places: tuple[float, ...], at: float) -> FloatArray:
    """Lagrange's weights of the values at nodes, for the value at another place."""
    nodes = np.array(places)
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    above = np.where(np.eye(len(nodes), dtype=bool), 1.0, at - nodes)
    return read_only(np.prod(above / apart, axis=1))


def _alike(values: FloatArray, rounding: FloatArray) -> FloatArray:
    """What rounding that is the same in all repeats may be: gravity adds the same to any speed."""
    return rounding if values.shape[-4] > 1 else np.zeros_like(rounding)


def extrapolated(gains: Gains) -> tuple[FloatArray, FloatArray]:
    """Limits of the gains, (K, 4, 3), and what they are known to, (K, 4).

    Of each state and quantity the entry of Neville's table that is known best is taken: it differs
    from its neighbour of one order less by more than its own error, and rounding adds to that. By
    accident that difference may be small, so it counts as the median of all states at least.
    """
    h = gains.timesteps[:, None, None]
    table, rounded = gains.values, gains.rounding
    limit, best = table[-1].mean(axis=0), np.full(rounded.shape[1:], np.inf)
    accident = np.zeros_like(best)
    for order in range(1, len(h)):
        coarse, fine = h[:-order], h[order:]
        finer = table[1:]
        weights = coarse / (coarse - fine), fine / (coarse - fine)
        table = finer * weights[0][..., None, None] - table[:-1] * weights[1][..., None, None]
        rounded = rounded[1:] * weights[0] + rounded[:-1] * weights[1]
        entries = table.mean(axis=1)
        change = np.abs(entries - finer.mean(axis=1)).max(axis=3)
        unsure = _uncertainty(table, rounded) + _alike(table, rounded)
        known = ABOVE * np.maximum(change, np.median(change, axis=1, keepdims=True)) + unsure
        # A finer entry of the same order that is distinctly elsewhere: this one is by accident.
        finer_off = np.zeros_like(known)
        noise = unsure[1:] * DISTINCT / ABOVE
        finer_off[:-1] = np.abs(np.diff(entries, axis=0)).max(axis=3) - noise
        for entry, known_to, off in zip(entries, known, finer_off, strict=True):
            is_better = known_to < best
            best = np.where(is_better, known_to, best)
            accident = np.where(is_better, ABOVE * off, accident)
            limit = np.where(is_better[..., None], entry, limit)
    return limit, np.maximum(best, accident)
