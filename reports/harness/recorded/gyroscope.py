"""Mistakes of a gyroscope, as changes of how ω is read, and their words."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.following import follow
from ....reference.other_equations import inverse
from ....scenarios import FloatArray
from ..explaining.hypothesis import Change, Hypothesis

#: Iω + h, by mistake.
MOMENTUM = Change(
    "momentum",
    lambda h, _: h._replace(read=h.equations.inertia, bias=h.equations.kept),
    np.empty(0),
)
GYROSCOPE = (
    Change("bias", lambda h, n: h._replace(bias=n), np.ones(3)),
    Change("scale", lambda h, n: h._replace(read=h.read @ np.diag(1 + n)), np.ones(3)),
    Change(
        "axes",
        lambda h, n: h._replace(read=h.read @ Rotation.from_rotvec(-n).as_matrix()),
        np.ones(3),
    ),
    Change("lag", lambda h, n: h._replace(lag=n[0]), np.ones(1)),
)
#: By mistake, its words, and what is added to its numbers, and the factor, before they are shown.
WORDS = {
    "bias": ("the gyroscope has a bias of {} rad/s", 0.0, 1.0),
    "scale": ("the gyroscope's axes read {} times ω", 1.0, 1.0),
    "axes": (
        "the gyroscope's axes are turned against the body's by {}°",
        *(0.0, 180 / np.pi),
    ),
    "momentum": ("the angular momentum is recorded in place of ω", 0.0, 1.0),
    "lag": ("ω lags the attitude by {} s", 0.0, 1.0),
}


def of_gyroscope(
    change: Change, numbers: FloatArray, in_words: Callable[[FloatArray, float], str]
) -> str:
    """Return a mistake in words.

    Parameters
    ----------
    in_words : prints its numbers, in other units than SI by the factor that it is given
    """
    words, added, factor = WORDS[change.kind]
    return words.format(in_words(added + factor * numbers, factor)) if len(numbers) else words


def as_read(hypothesis: Hypothesis, states: FloatArray) -> FloatArray:
    """Return states, q and ω, (S, 7), with ω as it is read."""
    h, q, omega = hypothesis, states[:, :4], states[:, 4:]
    if h.lag:
        omega = _later(h, states, -h.lag)[:, 4:]
    return np.hstack([q, omega @ h.read.T + h.bias])


def as_it_was(hypothesis: Hypothesis, read: FloatArray) -> FloatArray:
    """Return the states, q and ω, (S, 7), of which ω was read so; nan if ω does not tell."""
    h = hypothesis
    states = np.hstack([read[:, :4], (read[:, 4:] - h.bias) @ inverse(h.read).T])
    if h.lag:
        states[:, 4:] = _later(h, states, h.lag)[:, 4:]
    return states


def _later(hypothesis: Hypothesis, states: FloatArray, by: float) -> FloatArray:
    """Return where states lead in a time, s, before or after."""
    return follow(hypothesis.equations, states, np.full((len(states), 1), by))[:, 0]
