"""Mistakes in reading a state from an engine; their error does not depend on the timestep."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....engines import State
from ....scenarios import FloatArray
from ....scenarios.rotation import conjugate, matrices, rotation_vectors, turned, turned_back
from ...results.evidence import CONSISTENT, Explanation

#: Numbers that stay the same change by less than this many ulp of the largest.
ULPS = 4.0
#: The largest error of a state that is rounded to single precision, rad or relative: with an ulp
#: for each of the components of a quaternion, and of ω.
ROUNDED = 8 * float(np.finfo(np.float32).eps)


def misreading(read: State, exact: State, *, is_single: bool) -> tuple[Explanation, ...]:
    """Return the mistake in reading that explains the errors of n states; empty if none does.

    Parameters
    ----------
    read, exact : the states as they were read, and as they should have been read
    is_single : whether the engine declares single precision
    """
    deviation = _largest_deviation(read, exact)
    is_rounded = not is_single and deviation < ROUNDED
    if is_rounded and _is_in_24_bits(read) and not _is_in_24_bits(exact):
        return (Explanation("24 bits", ()),)
    for kind, mistaken in MISTAKES.items():
        if _largest_deviation(read, mistaken(exact)) < CONSISTENT * deviation:
            return (Explanation(kind, ()),)
    return ()


def first_step_alone(before: State, after: State, exact: State, ulp: float) -> Explanation:
    """Return what explains that first steps from n given states are wrong, and second ones are not.

    If attitude, ω or both stay the same in all these steps, and should change, they are read late,
    as before the step.

    Parameters
    ----------
    before, after : the states as they were read before and after the first steps
    exact : the states to which the exact motion leads
    ulp : the machine epsilon of the engine's precision
    """

    def is_late(old: FloatArray, new: FloatArray, wanted: FloatArray) -> bool:
        least = ULPS * ulp * np.abs(old).max()
        return bool(np.abs(new - old).max() <= least < np.abs(wanted - old).max() / ULPS)

    attitudes, omegas = zip(
        *((one.q_world_body_wxyz, one.omega_body) for one in (before, after, exact)), strict=True
    )
    kinds = {
        (True, True): "late state",
        (True, False): "late attitude",
        (False, True): "late ω",
        (False, False): "first step",
    }
    return Explanation(kinds[is_late(*attitudes), is_late(*omegas)], ())


def _largest_deviation(read: State, exact: State) -> float:
    """Return the largest error of states that were read: of attitude, rad, or of ω, relative.

    Errors of ω are relative to the largest component of the exact ω of all states.
    """
    turn = rotation_vectors(exact.q_world_body_wxyz, read.q_world_body_wxyz)
    change = (read.omega_body - exact.omega_body) / (np.abs(exact.omega_body).max() or 1.0)
    return float(np.abs([turn, change]).max())


def _with_q(state: State, q_wxyz: FloatArray) -> State:
    return replace(state, q_world_body_wxyz=q_wxyz)


def _with_omega(state: State, as_read: Callable[[FloatArray, FloatArray], FloatArray]) -> State:
    """Return n states with another ω, rad/s, body axes, (n, 3).

    Parameters
    ----------
    as_read : returns that ω, given the attitudes, (n, 3, 3), and the states' own ω, (n, 3)
    """
    omega = as_read(matrices(state.q_world_body_wxyz), state.omega_body)
    return replace(state, omega_body=omega)


def _is_in_24_bits(state: State) -> bool:
    """Return whether single precision can represent all attitudes, or all ω, exactly."""
    return any(
        np.array_equal(column, column.astype(np.float32))
        for column in (state.q_world_body_wxyz, state.omega_body)
    )


#: By the kind of mistake: a function that returns right states as they are read with the mistake.
MISTAKES: dict[str, Callable[[State], State]] = {
    "scalar last": lambda s: _with_q(s, np.roll(s.q_world_body_wxyz, -1, axis=1)),
    "scalar first": lambda s: _with_q(s, np.roll(s.q_world_body_wxyz, 1, axis=1)),
    "conjugated": lambda s: _with_q(s, conjugate(s.q_world_body_wxyz)),
    "ω in the world": lambda s: _with_omega(s, turned),
    "ω turned twice": lambda s: _with_omega(s, turned_back),
    "ω reversed": lambda s: _with_omega(s, lambda R, omega: -omega),  # noqa: ARG005
}
