"""Mistakes in reading a state, whose error is the same after any step, however short."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....engines import State
from ....scenarios import FloatArray
from ....scenarios.rotation import conjugate, matrices, rotation_vectors, turned, turned_back
from ...results.evidence import CONSISTENT, Explanation


def misreading(read: State, exact: State, *, is_single: bool) -> tuple[Explanation, ...]:
    """The mistake in reading that explains the errors of n states; empty if none does.

    Parameters
    ----------
    read, exact : states after a step as they were read, and the exact ones
    is_single : whether the engine declares single precision
    """
    if not is_single and _is_in_24_bits(read) and not _is_in_24_bits(exact):
        return (Explanation("24 bits", ()),)
    deviation = _largest_deviation(read, exact)
    for kind, mistaken in MISTAKES.items():
        if _largest_deviation(read, mistaken(exact)) < CONSISTENT * deviation:
            return (Explanation(kind, ()),)
    return ()


def _largest_deviation(read: State, exact: State) -> float:
    """The largest error of attitude, rad, or of ω, relative to its largest exact component."""
    turn = rotation_vectors(exact.q_world_body_wxyz, read.q_world_body_wxyz)
    change = (read.omega_body - exact.omega_body) / (np.abs(exact.omega_body).max() or 1.0)
    return float(np.abs([turn, change]).max())


def _with_q(state: State, q_wxyz: FloatArray) -> State:
    return replace(state, q_world_body_wxyz=q_wxyz)


def _with_omega(state: State, as_read: Callable[[FloatArray, FloatArray], FloatArray]) -> State:
    """Return states whose ω `as_read` computes from the attitudes, (n, 3, 3), and ω, (n, 3)."""
    omega = as_read(matrices(state.q_world_body_wxyz), state.omega_body)
    return replace(state, omega_body=omega)


def _is_in_24_bits(state: State) -> bool:
    """Whether all attitudes, or all ω, consist of numbers that single precision can represent."""
    return any(
        np.array_equal(column, column.astype(np.float32))
        for column in (state.q_world_body_wxyz, state.omega_body)
    )


#: Functions that make each mistake, by its kind, in states that are right.
MISTAKES: dict[str, Callable[[State], State]] = {
    "scalar last": lambda s: _with_q(s, np.roll(s.q_world_body_wxyz, -1, axis=1)),
    "scalar first": lambda s: _with_q(s, np.roll(s.q_world_body_wxyz, 1, axis=1)),
    "conjugated": lambda s: _with_q(s, conjugate(s.q_world_body_wxyz)),
    "ω in the world": lambda s: _with_omega(s, turned),
    "ω turned twice": lambda s: _with_omega(s, turned_back),
    "ω reversed": lambda s: _with_omega(s, lambda R, omega: -omega),  # noqa: ARG005
}
