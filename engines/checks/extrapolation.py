"""What the gains of steps tend to as their timesteps vanish, and whether they are of one function.

A gain is a power series of the timestep (Hairer, Nørsett & Wanner I, §II.8), so that Neville's rule
extrapolates it, and each is predicted by the polynomial through its neighbours.
"""

from dataclasses import dataclass

import numpy as np

from ...scenarios import FloatArray

#: An excess counts if it is so many times what its extrapolation is known to.
ABOVE = 8.0
#: A gain is predicted from those with so many coarser timesteps and so many finer ones.
COARSER, FINER = 3, 2
#: Ratio of two timesteps that are not the same.
ANOTHER = 1 + 1e-9
#: A gain is off its prediction if it is by so many times the prediction's error.
DISTINCT = 4.0
#: Gains that the last one is predicted from, to see the noise of all.
PREDICTING = 4


@dataclass(frozen=True, eq=False)
class Gains:
    """Gains with J timesteps, (J, K, 4, 3), and their rounding, (J, K, 4)."""

    timesteps: FloatArray
    values: FloatArray
    rounding: FloatArray


def noise_of(timesteps: FloatArray, gains: FloatArray) -> FloatArray:
    """What noise of the states makes of a gain times its timestep, (4,).

    It is seen where no smooth function is left: the last gain is compared with what four before it
    predict, at the median of all states.
    """
    h = timesteps[-PREDICTING - 1 :]
    weights = _weights(h[:-1], h[-1])
    left = gains[-1] - np.tensordot(weights, gains[-PREDICTING - 1 : -1], 1)
    share = np.sqrt(1 + ((weights * h[-1] / h[:-1]) ** 2).sum())
    noise = np.median(np.abs(left).max(axis=2), axis=0) * h[-1] / share
    return np.asarray(ABOVE * noise)


def surprises(nodes: Gains, at: Gains, least: int) -> FloatArray:
    """How far each gain is from what those with neighbouring timesteps predict, (J, K, 4).

    Consistent gains vanish at h = 0, which is one more point of the polynomial. What leaving out
    one of its two coarsest timesteps changes is the error of a prediction: by accident one such
    change may be small, as may that of a state, so the median of all states counts at least.

    Parameters
    ----------
    least : coarser ones that there must be to predict it
    """
    apart = np.zeros(at.values.shape[:3])
    for j, timestep in enumerate(at.timesteps):
        coarser = np.flatnonzero(nodes.timesteps > ANOTHER * timestep)[-COARSER:]
        finer = np.flatnonzero(nodes.timesteps * ANOTHER < timestep)[:FINER]
        if len(coarser) < least:
            continue
        near = [*coarser, *finer]
        h, values = np.append(nodes.timesteps[near], 0.0), nodes.values[near]
        weights = _weights(h, timestep)[:-1]
        predicted = np.tensordot(weights, values, 1)
        change = np.max([_changed(h, values, k, timestep, predicted) for k in (0, 1)], axis=0)
        error = DISTINCT * np.maximum(change, np.median(change, axis=0))
        error += ABOVE * (at.rounding[j] + np.tensordot(np.abs(weights), nodes.rounding[near], 1))
        apart[j] = np.abs(at.values[j] - predicted).max(axis=2) - error
    return apart


def _changed(
    h: FloatArray, values: FloatArray, left_out: int, timestep: float, predicted: FloatArray
) -> FloatArray:
    """What leaving out one timestep changes of a prediction, (K, 4)."""
    fewer = np.delete(np.arange(len(h) - 1), left_out)
    weights = _weights(np.append(h[fewer], 0.0), timestep)[:-1]
    return np.asarray(np.abs(predicted - np.tensordot(weights, values[fewer], 1)).max(axis=2))


def _weights(nodes: FloatArray, at: float) -> FloatArray:
    """Lagrange's weights of the values at nodes, for the value at another place."""
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    above = np.where(np.eye(len(nodes), dtype=bool), 1.0, at - nodes)
    return np.asarray(np.prod(above / apart, axis=1))


def extrapolated(
    timesteps: FloatArray, gains: FloatArray, rounding: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Limits of the gains, (K, 4, 3), and what they are known to, (K, 4).

    Of each state and quantity the entry of Neville's table that is known best is taken: it differs
    from its neighbour of one order less by more than its own error. By accident that difference may
    be small, so it counts as the median of all states at least.
    """
    h = timesteps[:, None, None]
    table, rounded = gains, rounding
    limit, best = gains[-1], np.full(gains.shape[1:3], np.inf)
    for order in range(1, len(timesteps)):
        coarse, fine = h[:-order], h[order:]
        finer = table[1:]
        weights = coarse / (coarse - fine), fine / (coarse - fine)
        table = finer * weights[0][..., None] - table[:-1] * weights[1][..., None]
        rounded = rounded[1:] * weights[0] + rounded[:-1] * weights[1]
        change = np.abs(table - finer).max(axis=3)
        known = ABOVE * np.maximum(change, np.median(change, axis=1, keepdims=True)) + rounded
        for entry, known_to in zip(table, known, strict=True):
            is_better = known_to < best
            best = np.where(is_better, known_to, best)
            limit = np.where(is_better[..., None], entry, limit)
    return limit, best
