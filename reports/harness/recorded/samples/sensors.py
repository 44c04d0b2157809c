"""Errors of sensors, as changes (`Change`) of how ω and attitude are read, and words for them."""

from collections.abc import Callable

import numpy as np
from numpy.polynomial.laguerre import laggauss
from scipy.spatial.transform import Rotation

from .....reference.following import follow, follow_each
from .....reference.other_equations import inverse
from .....scenarios import FloatArray
from .....scenarios.rotation import norms, times
from ...explaining.hypothesis import Change, Hypothesis

#: Largest turn of the body, rad, in a lag of ω, a delay of the attitude, or a filter's time
#: constant.
FURTHEST = 1.0
#: Relative tolerance with which a scale factor is recognised as that from rad to degrees.
DEGREES = 1e-2
#: Least rotation of a gyroscope's axes, rad, and least change of its scale factors, that a fit does
#: not find from zero. Weight of the rotations that ω does not show, relative to those that it does.
NEAR, LEAST_CHANGE, UNSHOWN = 1.0, 0.5, 1e-4
#: Number of nodes of a filter's quadrature. With one less, the error exceeds a noise of 1e-4 of ω.
NODES = 4
#: The change in which I ω + h is recorded in place of ω.
MOMENTUM = Change(
    "momentum",
    lambda h, _: h.of(read=h.inertia, bias=h.kept),
    np.empty(0),
)
#: Which entries of a gyroscope's matrix are cross-axis sensitivities.
OFF_DIAGONAL = ~np.eye(3, dtype=bool)


def _cross_axis(parameters: FloatArray) -> FloatArray:
    """Return the matrices by which H gyroscopes multiply ω, (H, 3, 3).

    Parameters
    ----------
    parameters : cross-axis sensitivities, which are the entries off the diagonal, row by row,
        (H, 6)
    """
    read = np.tile(np.eye(3), (len(parameters), 1, 1))
    read[:, OFF_DIAGONAL] = parameters
    return read


def _mounting(actual: FloatArray, read: FloatArray) -> FloatArray:
    """Return the rotation vector, rad, (3,), of the gyroscope's axes that explains ω best.

    It is found without iteration (W. Kabsch, Acta Cryst. A32 (1976) 922), from changes of ω alone,
    as its mean may have a bias. What these do not show of the rotation is as small as possible. The
    vector is 0 if it is shorter than `NEAR`, or if such axes explain less than half of the mean
    square difference.

    Parameters
    ----------
    actual, read : the body's ω, and ω as it was recorded, rad/s, (n, 3) each
    """
    actual, read = actual - actual.mean(axis=0), read - read.mean(axis=0)
    overlap = actual.T @ read
    overlap += UNSHOWN * np.linalg.norm(overlap) * np.eye(3)
    left, _, right = np.linalg.svd(overlap)
    R = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    turn = np.asarray(Rotation.from_matrix(R).as_rotvec())
    is_far = norms(turn[None])[0] > NEAR
    return turn if is_far and _explains_half(actual, read, actual @ R) else np.zeros(3)


def _scale_factors(actual: FloatArray, read: FloatArray) -> FloatArray:
    """Return the scale factors of the gyroscope's axes less 1, (3,), that explain ω best.

    They are those of a linear regression, or 0 if none of them is as large as `LEAST_CHANGE`, or if
    they explain less than half of the mean square difference.

    Parameters
    ----------
    actual, read : the body's ω, and ω as it was recorded, rad/s, (n, 3) each
    """
    squares = np.sum(actual**2, axis=0)
    ratios = np.divide(np.sum(actual * read, axis=0), squares, np.ones(3), where=squares > 0)
    is_far = np.abs(ratios - 1).max() >= LEAST_CHANGE
    return ratios - 1 if is_far and _explains_half(actual, read, ratios * actual) else np.zeros(3)


def _explains_half(actual: FloatArray, read: FloatArray, made: FloatArray) -> bool:
    """Return whether an ω explains half of the mean square difference of two others, or more.

    Parameters
    ----------
    actual, read, made : the body's ω, ω as it was recorded, and the ω that should explain it,
        rad/s, (n, 3) each
    """
    return bool(2 * np.sum((read - made) ** 2) < np.sum((read - actual) ** 2))


SENSORS = (
    Change("bias", lambda h, n: h.of(bias=n), np.ones(3)),
    Change(
        "scale",
        lambda h, n: h.of(read=h.read * (1 + n[:, None])),
        np.ones(3),
        guess=_scale_factors,
    ),
    Change(
        "axes",
        lambda h, n: h.of(read=h.read @ Rotation.from_rotvec(-n).as_matrix()),
        np.ones(3),
        guess=_mounting,
    ),
    Change("lag", lambda h, n: h.of(lag=n[:, 0]), np.ones(1)),
    Change("drift", lambda h, n: h.of(drift=n), np.ones(3)),
    Change("turned attitude", lambda h, n: h.of(turned=n), np.ones(3)),
    Change("delay", lambda h, n: h.of(delay=n[:, 0]), np.ones(1)),
)
#: A gyroscope's cross-axis sensitivity. Its six parameters can be told from those of other mistakes
#: only if there is no noise.
CROSS_AXIS = Change("cross-axis", lambda h, n: h.of(read=h.read @ _cross_axis(n)), np.ones(6))
#: Filters of ω. They cannot be undone, as what they suppress is lost.
FILTERS = (
    Change("low-pass", lambda h, n: h.of(low_pass=n[:, 0]), np.ones(1)),
    Change(
        "low-pass from the start",
        lambda h, n: h.of(low_pass=n[:, 0], is_begun=1.0),
        np.ones(1),
    ),
)
#: The changes that can be undone at each sample. Only these are tried in intervals, which start
#: from the actual state at a sample.
READINGS = (MOMENTUM, *SENSORS, CROSS_AXIS)
#: The changes that are tried with a flight log.
OF_LOGS = (*SENSORS, *FILTERS)
#: By kind of change: the sentence, a, and f, where a + f p is shown for a parameter p.
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

#: The kinds of changes whose parameters are a rotation vector.
TURNED = ("axes", "turned attitude")
#: By kind of change: the sentence if its parameter is negative; the absolute value is shown.
AHEAD = {
    "lag": "ω is ahead of the attitude by {} s",
    "delay": "the attitude is that of {} s after its time, and ω is that of its time",
}


def of_sensor(
    change: Change, parameters: FloatArray, in_words: Callable[[FloatArray, float], str]
) -> str:
    """Return a sentence on a sensor's error.

    Parameters
    ----------
    change : the error, as a change of how states are read
    parameters : the k fitted parameters of the change, SI units, (k,)
    in_words : returns numbers as text. It is called with the numbers to show and with f, the factor
        from SI units to their unit
    """
    words, added, factor = WORDS[change.kind]
    if change.kind in AHEAD and parameters[0] < 0:
        words, parameters = AHEAD[change.kind], -parameters
    if not len(parameters):
        return words
    if change.kind in TURNED:
        parameters = shortest(parameters)
    shown = added + factor * parameters
    in_degrees = change.kind == "scale" and np.isclose(shown, 180 / np.pi, rtol=DEGREES).any()
    return words.format(in_words(shown, factor)) + ", as in degrees" * bool(in_degrees)


def shortest(rotation_vector: FloatArray) -> FloatArray:
    """Return the rotation vector, rad, (3,), of the same rotation by at most π."""
    return Rotation.from_rotvec(rotation_vector).as_rotvec()


def as_read(hypotheses: Hypothesis, states: FloatArray, t: FloatArray) -> FloatArray:
    """Return what the sensors of H hypotheses read in S states each, (H, S, 7).

    Parameters
    ----------
    states : the actual states: q, scalar first, and ω, rad/s, body axes, (H, S, 7)
    t : times of the states, s, (S,)
    """
    read, lag, delay = states.copy(), hypotheses.lag, hypotheses.delay
    if lag.any():
        at = lag != 0
        read[at, :, 4:] = _propagated(hypotheses[at], states[at], -lag[at])[..., 4:]
    for k in np.flatnonzero(hypotheses.low_pass):
        read[k, :, 4:] = _filtered(hypotheses[k], states[k], t)
    if delay.any():
        at = delay != 0
        read[at, :, :4] = _propagated(hypotheses[at], states[at], -delay[at])[..., :4]
    _turn(read, hypotheses.turned)
    by = np.swapaxes(hypotheses.read, 1, 2)
    read[..., 4:] = read[..., 4:] @ by + _bias_and_drift(hypotheses, t)
    return read


def as_it_was(hypotheses: Hypothesis, read: FloatArray, t: FloatArray) -> FloatArray:
    """Return the actual states, (H, S, 7), if the sensors of H hypotheses read S given states.

    This is the inverse of `as_read`, except that filters are not undone. States are not finite for
    a hypothesis with which ω as it is read does not determine ω.

    Parameters
    ----------
    read : the states that were read: q, scalar first, and ω, rad/s, body axes, (S, 7)
    t : times of the states, s, (S,)
    """
    states, lag, delay = np.tile(read, (len(hypotheses), 1, 1)), hypotheses.lag, hypotheses.delay
    by = np.swapaxes(inverse(hypotheses.read), 1, 2)
    states[..., 4:] = (read[:, 4:] - _bias_and_drift(hypotheses, t)) @ by
    _turn(states, -hypotheses.turned)
    if lag.any():
        at = lag != 0
        states[at, :, 4:] = _propagated(hypotheses[at], states[at], lag[at])[..., 4:]
    if delay.any():
        at = delay != 0
        before = _propagated(hypotheses[at], states[at], -delay[at])
        before[..., :4] = states[at, :, :4]
        states[at, :, :4] = _propagated(hypotheses[at], before, delay[at])[..., :4]
    return states


def _bias_and_drift(hypotheses: Hypothesis, t: FloatArray) -> FloatArray:
    """Return what bias and drift of H hypotheses add to ω as it is read at S times t, s, (S,).

    Returns
    -------
    The sum of both, rad/s, (H, S, 3); (H, 1, 3) if there is no drift
    """
    added, drift = hypotheses.bias[:, None], hypotheses.drift[:, None]
    return np.asarray(added + t[:, None] * drift) if drift.any() else added


def _turn(states: FloatArray, turns: FloatArray) -> None:
    """Turn the attitudes of S states of H hypotheses, (H, S, 7), in place.

    Parameters
    ----------
    turns : rotation vector for each hypothesis, rad, body axes, (H, 3)
    """
    for k in np.flatnonzero(turns.any(axis=1)):
        of_turn = Rotation.from_rotvec(turns[k]).as_quat(scalar_first=True)
        states[k, :, :4] = states[k, :, :4] @ times(of_turn)


def _filtered(hypothesis: Hypothesis, states: FloatArray, t: FloatArray) -> FloatArray:
    """Return the output of a low-pass filter of ω in S states, rad/s, (S, 3).

    It is a mean of past ω with exponential weights, by Gauß–Laguerre quadrature. It is nan if the
    time constant is negative, or if the body turns by more than `FURTHEST` in that time.

    Parameters
    ----------
    hypothesis : one hypothesis, which has the time constant and the equations of the past motion
    states : q, scalar first, and the actual ω, rad/s, (S, 7)
    t : times of the states, s, (S,)
    """
    time_constant = float(hypothesis.low_pass)
    if not 0 <= time_constant * norms(states[:, 4:]).max() < FURTHEST:
        return np.full((len(states), 3), np.nan)
    nodes, weights = laggauss(NODES)
    spans = np.tile(-time_constant * np.diff(nodes, prepend=0.0), (len(states), 1))
    past = follow(hypothesis, states, spans)[..., 4:]
    output = np.asarray(weights @ past)
    if hypothesis.is_begun and time_constant:
        output += np.exp((t[0] - t) / time_constant)[:, None] * (states[0, 4:] - output[0])
    return output


def _propagated(hypotheses: Hypothesis, states: FloatArray, by: FloatArray) -> FloatArray:
    """Return the states, (H, S, 7), to which the equations of H hypotheses lead after some time.

    S states are followed with each hypothesis. They are nan for a hypothesis with which the body
    turns by more than `FURTHEST` in that time.

    Parameters
    ----------
    states : states at the beginning, (H, S, 7)
    by : the time, s, (H,); if it is negative, earlier states are returned
    """
    speeds = np.linalg.norm(states[..., 4:], axis=-1).max(axis=-1)
    is_near = np.abs(by) * speeds < FURTHEST
    spans = np.where(is_near, by, 0.0)[:, None, None] * np.ones((states.shape[1], 1))
    ends = follow_each(hypotheses, states, spans)[:, :, 0]
    ends[~is_near] = np.nan
    return ends
