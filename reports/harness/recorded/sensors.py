"""Mistakes of sensors, as changes of how ω and the attitude are read, and their words."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial.laguerre import laggauss
from scipy.spatial.transform import Rotation

from ....reference.following import follow
from ....reference.other_equations import inverse
from ....scenarios import FloatArray
from ....scenarios.rotation import norms, times
from ..explaining.hypothesis import Change, Hypothesis

#: Largest turn, rad, by which ω or an attitude may be late.
FURTHEST = 1.0
#: Relative error of a factor by which degrees are recognised.
DEGREES = 1e-2
#: Nodes of a filter's quadrature: with one fewer a noise of 1e-4 of ω shows the difference.
NODES = 4
#: Iω + h, by mistake.
MOMENTUM = Change(
    "momentum",
    lambda h, _: h._replace(read=h.equations.inertia, bias=h.equations.kept),
    np.empty(0),
)
#: Where the numbers of a gyroscope's cross-axis sensitivity are in a matrix.
CROSSED = ~np.eye(3, dtype=bool)


def _crossed(numbers: FloatArray) -> FloatArray:
    """Return the matrix of axes that read so many times one another, (6,), besides themselves."""
    read = np.eye(3)
    read[CROSSED] = numbers
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
#: The six numbers of this one are told apart from those of others where there is no noise alone.
CROSS_AXIS = Change("cross-axis", lambda h, n: h._replace(read=h.read @ _crossed(n)), np.ones(6))
#: Filters of ω, which are not undone: what they left out is lost.
FILTERS = (
    Change("low-pass", lambda h, n: h._replace(low_pass=n[0]), np.ones(1)),
    Change(
        "low-pass from the start",
        lambda h, n: h._replace(low_pass=n[0], is_begun=True),
        np.ones(1),
    ),
)
#: All that may be wrong with how ω and the attitude are read, and is undone from sample to sample.
READINGS = (MOMENTUM, *SENSORS, CROSS_AXIS)
#: All that may be wrong with them in a log.
OF_LOGS = (*SENSORS, *FILTERS)
#: By mistake, its words, and what is added to its numbers, and the factor, before they are shown.
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


#: The words of a number below zero, which are of its size.
AHEAD = {
    "lag": "ω is ahead of the attitude by {} s",
    "delay": "the attitude is that of {} s after its time, and ω is that of its time",
}


def of_sensor(
    change: Change, numbers: FloatArray, in_words: Callable[[FloatArray, float], str]
) -> str:
    """Return a mistake in words.

    Parameters
    ----------
    in_words : prints its numbers, in other units than SI by the factor that it is given
    """
    words, added, factor = WORDS[change.kind]
    if change.kind in AHEAD and numbers[0] < 0:
        words, numbers = AHEAD[change.kind], -numbers
    if not len(numbers):
        return words
    shown = added + factor * numbers
    in_degrees = change.kind == "scale" and np.isclose(shown, 180 / np.pi, rtol=DEGREES).any()
    return words.format(in_words(shown, factor)) + ", as in degrees" * bool(in_degrees)


def as_read(hypotheses: Sequence[Hypothesis], states: FloatArray, t: FloatArray) -> FloatArray:
    """Return states of H hypotheses, q and ω, as they are read at times, s, (S,): (H, S, 7)."""
    read = states.copy()
    for h, of_it, made in zip(hypotheses, states, read, strict=True):
        if h.lag:
            made[:, 4:] = _later(h, of_it, -h.lag)[:, 4:]
        if h.low_pass:
            made[:, 4:] = _filtered(h, of_it, t)
        if h.delay:
            made[:, :4] = _later(h, of_it, -h.delay)[:, :4]
        made[:, :4] = _turned(made[:, :4], h.turned)
    by = np.stack([one.read for one in hypotheses])
    read[..., 4:] = read[..., 4:] @ np.swapaxes(by, 1, 2) + _added(hypotheses, t)
    return read


def as_it_was(hypotheses: Sequence[Hypothesis], read: FloatArray, t: FloatArray) -> FloatArray:
    """Return the states, q and ω, that H hypotheses read so, (H, S, 7); nan if ω does not tell.

    Parameters
    ----------
    read : q and ω as they were read at times t, s, (S, 7) and (S,)
    """
    by = np.stack([inverse(one.read) for one in hypotheses])
    states = np.tile(read, (len(hypotheses), 1, 1))
    states[..., 4:] = (read[:, 4:] - _added(hypotheses, t)) @ np.swapaxes(by, 1, 2)
    for h, was in zip(hypotheses, states, strict=True):
        was[:, :4] = _turned(was[:, :4], -h.turned)
        if h.lag:
            was[:, 4:] = _later(h, was, h.lag)[:, 4:]
        if h.delay:
            before = _later(h, was, -h.delay)
            was[:, :4] = _later(h, np.hstack([was[:, :4], before[:, 4:]]), h.delay)[:, :4]
    return states


def _added(hypotheses: Sequence[Hypothesis], t: FloatArray) -> FloatArray:
    """Return what is added to ω at times, s, (S,), before it is read: bias and drift, (H, S, 3)."""
    added = np.stack([(one.bias, one.drift) for one in hypotheses])[:, :, None]
    return np.asarray(added[:, 0] + t[:, None] * added[:, 1])


def _turned(q: FloatArray, turn: FloatArray) -> FloatArray:
    """Return attitudes, scalar first, (S, 4), of axes turned in the body by a rotation vector."""
    if not turn.any():
        return q
    return q @ times(Rotation.from_rotvec(turn).as_quat(scalar_first=True))


def _filtered(hypothesis: Hypothesis, states: FloatArray, t: FloatArray) -> FloatArray:
    """Return what a low-pass filter leaves of ω, (S, 3): Gauß–Laguerre quadrature of its past."""
    constant = hypothesis.low_pass
    if not 0 <= constant * norms(states[:, 4:]).max() < FURTHEST:
        return np.full((len(states), 3), np.nan)
    nodes, weights = laggauss(NODES)
    spans = np.tile(-constant * np.diff(nodes, prepend=0.0), (len(states), 1))
    past = follow(hypothesis.equations, states, spans)[..., 4:]
    made = np.asarray(weights @ past)
    if hypothesis.is_begun and constant:
        made += np.exp((t[0] - t) / constant)[:, None] * (states[0, 4:] - made[0])
    return made


def _later(hypothesis: Hypothesis, states: FloatArray, by: float) -> FloatArray:
    """Return where states lead in a time, s, before or after; nan where they turn too far in it."""
    if not abs(by) * norms(states[:, 4:]).max() < FURTHEST:
        return np.full_like(states, np.nan)
    return follow(hypothesis.equations, states, np.full((len(states), 1), by))[:, 0]
