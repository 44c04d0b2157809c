"""Errors of sensors as changes of how ω and the attitude are read, and the words for them."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial.laguerre import laggauss
from scipy.spatial.transform import Rotation

from .....reference.following import follow
from .....reference.other_equations import inverse
from .....scenarios import FloatArray
from .....scenarios.rotation import norms, times
from ...explaining.hypothesis import Change, Hypothesis

#: Largest turn of the body, rad, in the time by which ω or the attitude is late.
FURTHEST = 1.0
#: Relative tolerance at which a scale factor is recognised as that from rad to degrees.
DEGREES = 1e-2
#: Nodes of a filter's quadrature. With one fewer, its error exceeds a noise of 1e-4 of ω.
NODES = 4
#: Iω + h is recorded in place of ω.
MOMENTUM = Change(
    "momentum",
    lambda h, _: h._replace(read=h.equations.inertia, bias=h.equations.kept),
    np.empty(0),
)
#: The entries of a matrix that hold a gyroscope's cross-axis sensitivity.
OFF_DIAGONAL = ~np.eye(3, dtype=bool)


def _cross_axis(parameters: FloatArray) -> FloatArray:
    """Return the matrix, (3, 3), of a gyroscope with a cross-axis sensitivity, (6,), row by row."""
    read = np.eye(3)
    read[OFF_DIAGONAL] = parameters
    return read


SENSORS = (
    Change("bias", lambda h, n: h._replace(bias=n), np.ones(3)),
    Change("scale", lambda h, n: h._replace(read=h.read @ np.diag(1 + n)), np.ones(3)),
    Change(
        "axes",
        lambda h, n: h._replace(read=h.read @ Rotation.from_rotvec(-n).as_matrix()),
        np.ones(3),
    ),
    Change("lag", lambda h, n: h._replace(lag=n[0]), np.ones(1)),
    Change("drift", lambda h, n: h._replace(drift=n), np.ones(3)),
    Change("turned attitude", lambda h, n: h._replace(turned=n), np.ones(3)),
    Change("delay", lambda h, n: h._replace(delay=n[0]), np.ones(1)),
)
#: A gyroscope's cross-axis sensitivity. Its six parameters can be told from those of other mistakes
#: only if there is no noise.
CROSS_AXIS = Change("cross-axis", lambda h, n: h._replace(read=h.read @ _cross_axis(n)), np.ones(6))
#: Filters of ω. They are not undone, as what they suppress is lost.
FILTERS = (
    Change("low-pass", lambda h, n: h._replace(low_pass=n[0]), np.ones(1)),
    Change(
        "low-pass from the start",
        lambda h, n: h._replace(low_pass=n[0], is_begun=True),
        np.ones(1),
    ),
)
#: The changes of reading that can be undone at each sample, as is needed to compare intervals.
READINGS = (MOMENTUM, *SENSORS, CROSS_AXIS)
#: The changes of reading that are tried with a flight log.
OF_LOGS = (*SENSORS, *FILTERS)
#: By kind of change: the words, and a and f of a + f p, as which the parameters p are shown.
WORDS = {
    "bias": ("the gyroscope has a bias of {} rad/s", 0.0, 1.0),
    "scale": ("the gyroscope's axes read {} times ω", 1.0, 1.0),
    "axes": (
        "the gyroscope's axes are turned against the body's by {}°",
        *(0.0, 180 / np.pi),
    ),
    "cross-axis": (
        "the gyroscope has a cross-axis sensitivity: wx reads y and z besides, wy x and z, wz x "
        "and y, {} times",
        *(0.0, 1.0),
    ),
    "momentum": ("the angular momentum is recorded in place of ω", 0.0, 1.0),
    "low-pass": ("ω is what a low-pass filter of a time constant of {} s leaves of it", 0.0, 1.0),
    "low-pass from the start": (
        "ω is what a low-pass filter of a time constant of {} s leaves of it, which begins with "
        "the first sample",
        *(0.0, 1.0),
    ),
    "lag": ("ω lags the attitude by {} s", 0.0, 1.0),
    "drift": ("the gyroscope's bias drifts by {} rad/s²", 0.0, 1.0),
    "turned attitude": (
        "the attitude is that of axes that are turned in the body by {}°, and ω is not",
        *(0.0, 180 / np.pi),
    ),
    "delay": ("the attitude is that of {} s before its time, and ω is that of its time", 0.0, 1.0),
}


#: By kind of change: the words if the parameter is negative, of which the absolute value is shown.
AHEAD = {
    "lag": "ω is ahead of the attitude by {} s",
    "delay": "the attitude is that of {} s after its time, and ω is that of its time",
}


def of_sensor(
    change: Change, parameters: FloatArray, in_words: Callable[[FloatArray, float], str]
) -> str:
    """Return a sensor's error in words.

    Parameters
    ----------
    parameters : the fitted parameters of the change, SI units, (k,)
    in_words : returns numbers as text, given the numbers to show, and the factor f from the
        parameters to their unit
    """
    words, added, factor = WORDS[change.kind]
    if change.kind in AHEAD and parameters[0] < 0:
        words, parameters = AHEAD[change.kind], -parameters
    if not len(parameters):
        return words
    shown = added + factor * parameters
    in_degrees = change.kind == "scale" and np.isclose(shown, 180 / np.pi, rtol=DEGREES).any()
    return words.format(in_words(shown, factor)) + ", as in degrees" * bool(in_degrees)


def as_read(hypotheses: Sequence[Hypothesis], states: FloatArray, t: FloatArray) -> FloatArray:
    """Return the states of H hypotheses as their sensors read them, (H, S, 7).

    Parameters
    ----------
    states : the actual q, scalar first, and ω, rad/s, body axes, (H, S, 7)
    t : s, (S,)
    """
    read = states.copy()
    for h, actual, output in zip(hypotheses, states, read, strict=True):
        if h.lag:
            output[:, 4:] = _propagated(h, actual, -h.lag)[:, 4:]
        if h.low_pass:
            output[:, 4:] = _filtered(h, actual, t)
        if h.delay:
            output[:, :4] = _propagated(h, actual, -h.delay)[:, :4]
        output[:, :4] = _turned(output[:, :4], h.turned)
    by = np.stack([one.read for one in hypotheses])
    read[..., 4:] = read[..., 4:] @ np.swapaxes(by, 1, 2) + _bias_and_drift(hypotheses, t)
    return read


def as_it_was(hypotheses: Sequence[Hypothesis], read: FloatArray, t: FloatArray) -> FloatArray:
    """Return the actual states if the sensors of H hypotheses read the given ones, (H, S, 7).

    This is the inverse of `as_read`, except that filters are not undone. States are not finite
    where ω cannot be recovered from what a hypothesis reads.

    Parameters
    ----------
    read : q, scalar first, and ω, rad/s, body axes, as they were read, (S, 7)
    t : s, (S,)
    """
    by = np.stack([inverse(one.read) for one in hypotheses])
    states = np.tile(read, (len(hypotheses), 1, 1))
    states[..., 4:] = (read[:, 4:] - _bias_and_drift(hypotheses, t)) @ np.swapaxes(by, 1, 2)
    for h, true in zip(hypotheses, states, strict=True):
        true[:, :4] = _turned(true[:, :4], -h.turned)
        if h.lag:
            true[:, 4:] = _propagated(h, true, h.lag)[:, 4:]
        if h.delay:
            before = _propagated(h, true, -h.delay)
            true[:, :4] = _propagated(h, np.hstack([true[:, :4], before[:, 4:]]), h.delay)[:, :4]
    return states


def _bias_and_drift(hypotheses: Sequence[Hypothesis], t: FloatArray) -> FloatArray:
    """Return what bias and drift add to ω as it is read at times t, s, (S,), rad/s, (H, S, 3)."""
    added = np.stack([(one.bias, one.drift) for one in hypotheses])[:, :, None]
    return np.asarray(added[:, 0] + t[:, None] * added[:, 1])


def _turned(q: FloatArray, turn: FloatArray) -> FloatArray:
    """Return attitudes, scalar first, (S, 4), of axes turned in the body by a rotation vector."""
    if not turn.any():
        return q
    return q @ times(Rotation.from_rotvec(turn).as_quat(scalar_first=True))


def _filtered(hypothesis: Hypothesis, states: FloatArray, t: FloatArray) -> FloatArray:
    """Return ω after a low-pass filter, rad/s, (S, 3), by Gauß–Laguerre quadrature of past ω.

    It is nan if the time constant is negative, or the body turns too far in it.

    Parameters
    ----------
    states : q, scalar first, and the actual ω, (S, 7)
    t : s, (S,)
    """
    time_constant = hypothesis.low_pass
    if not 0 <= time_constant * norms(states[:, 4:]).max() < FURTHEST:
        return np.full((len(states), 3), np.nan)
    nodes, weights = laggauss(NODES)
    spans = np.tile(-time_constant * np.diff(nodes, prepend=0.0), (len(states), 1))
    past = follow(hypothesis.equations, states, spans)[..., 4:]
    output = np.asarray(weights @ past)
    if hypothesis.is_begun and time_constant:
        output += np.exp((t[0] - t) / time_constant)[:, None] * (states[0, 4:] - output[0])
    return output


def _propagated(hypothesis: Hypothesis, states: FloatArray, by: float) -> FloatArray:
    """Return states, (S, 7), as they are `by` s later; nan if the body turns too far by then."""
    if not abs(by) * norms(states[:, 4:]).max() < FURTHEST:
        return np.full_like(states, np.nan)
    return follow(hypothesis.equations, states, np.full((len(states), 1), by))[:, 0]
