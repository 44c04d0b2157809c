"""Checks that the attitude turns at the rate of the ω that is read with it, one step at a time.

Both are read before and after single steps. However coarse the step, a correct rule turns the body
at a rate between the ω before and the ω after the step, with a margin of their difference: explicit
and implicit rules use one or the other, rules of higher order a value in between, a multistep rule
exceeds one of them by half their difference. If an effect or the engine slows it, or its parts turn
it, the ω in between may differ further, by as much as that changes it. If ω is constant, the
remaining error is that of a rotation about a fixed axis: the coarsest rules, q (1, hω/2) normalised
and Cayley's, turn by 2 atan(h|ω|/2), less than h|ω| by at most (h|ω|)³/12. A rule that steps roll,
pitch β and yaw errs by at most (h|ω|/cos β)²/2 about any axis, by the second derivative of the
rotation, as no angle changes faster than |ω|/cos β. A constraint that is the pivot and corrects a
drift of the com within a step turns the body besides, and ω does not include it: by at most the
drifts before and after the step over the distance of the com.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray
from ...scenarios.rotation import matrices, norms, rotation_vectors, turned, turned_back
from ..fault import Cause, Fault
from .bounds import Bounds
from .read_back import State

#: rad, largest turn that is checked: near π the direction of a turn is ambiguous.
FURTHEST = 3.0
#: Coefficient of x³ in the error of the coarsest rule for a turn by x about a fixed axis.
ATAN = 1 / 12
#: Digits of the angles in a reason; more where it takes more to tell them apart.
DIGITS, MOST_DIGITS = 3, 12


@dataclass(frozen=True, eq=False)
class Reading:
    """States that were read, and the first ones of the run.

    Attributes
    ----------
    states : n of them, one a row
    steps : (n,) step counts of the states
    start : the first two states read in the run, or fewer; rows as in `states`
    """

    states: State
    steps: NDArray[np.int64]
    start: State


def turn_faults(reading: Reading, bounds: Bounds) -> Iterator[Fault]:
    """The first state whose attitude does not match ω over a step, and the first after a reset."""
    with np.errstate(all="ignore"):
        yield from _resets(reading)
        pairs = np.flatnonzero(np.diff(reading.steps) == 1)
        is_sound = _is_sound(reading.states)
        pairs = pairs[is_sound[pairs] & is_sound[pairs + 1]]
        if len(pairs):
            yield from _turns(reading, pairs, bounds)


def _turns(reading: Reading, pairs: NDArray[np.int64], bounds: Bounds) -> Iterator[Fault]:
    states, timestep = reading.states, bounds.timestep
    q_world_body = states.q_world_body_wxyz
    rate_body = rotation_vectors(q_world_body[pairs], q_world_body[pairs + 1]) / timestep
    before_body, after_body = states.omega_body[pairs], states.omega_body[pairs + 1]
    mean_omega_body = (before_body + after_body) / 2
    speeds = norms(mean_omega_body)
    fastest = np.maximum(norms(before_body), norms(after_body))
    change = norms(after_body - before_body)
    allowed = _allowed(change, fastest, q_world_body[pairs], bounds)
    off = norms(rate_body - mean_omega_body)
    bad = (off > allowed) & (fastest * timestep < FURTHEST)
    if bad.any() and bounds.arm is not None and bounds.arm.any():
        allowed += _put_back(states, pairs, bounds.arm) / timestep
        bad &= off > allowed
    if not bad.any():
        return
    k = int(np.argmax(bad))
    along = float(rate_body[k] @ mean_omega_body[k]) / speeds[k] if speeds[k] else 0.0
    aside = float(np.sqrt(max(0.0, float(rate_body[k] @ rate_body[k]) - along**2)))
    # The turn is about ω's axis if the part across it is smaller than the part missing along it.
    is_aside = along < 0 or aside > min(float(allowed[k]), abs(along - float(speeds[k])))
    cause = _cause(reading, int(pairs[k]), is_aside, is_short=along < speeds[k])
    angle = float(np.degrees(np.linalg.norm(rate_body[k]) * timestep))
    makes = float(np.degrees(speeds[k] * timestep))
    digits = _digits(angle, makes) if cause == "clock" else DIGITS
    reason = (
        f"in a step the attitude turns by {angle:.{digits}g}°, and ω makes "
        f"{makes:.{digits}g}°{_WAYS[cause]}"
    )
    if cause == "frames" and _were_of_one_frame(
        mean_omega_body[:k], q_world_body[pairs[:k]], (off + allowed)[:k]
    ):
        cause = "parted"
        reason = (
            f"from {reading.steps[pairs[k]] * timestep:.4g} s on attitude and ω part: in a step "
            f"the attitude turns by {angle:.3g}° and ω makes {makes:.3g}°, "
            f"{np.degrees(off[k] * timestep):.3g}° apart; up to then they agreed"
        )
    yield Fault(int(pairs[k]) + 1, cause, reason)


def _allowed(
    own_change: FloatArray, fastest: FloatArray, q_world_body: FloatArray, bounds: Bounds
) -> FloatArray:
    """The most by which the rate of each turn may differ from the mean ω, rad/s, (n,).

    Parameters
    ----------
    own_change, fastest : the change of ω over each step, and the larger ω at its ends, rad/s, (n,)
    q_world_body : at the start of each step, (n, 4)
    """
    timestep = bounds.timestep
    # ω may return within a step, so its changes in the neighbouring steps are used too.
    change = own_change.copy()
    np.maximum(change[1:], own_change[:-1], out=change[1:])
    np.maximum(change[:-1], own_change[1:], out=change[:-1])
    change += bounds.decay * timestep * fastest
    allowed = change + ATAN * timestep**2 * fastest**3 + bounds.round_off / timestep
    if bounds.by_angles:
        w, x, y, z = q_world_body.T
        cos_pitch_squared = 1 - (2 * (w * y - x * z)) ** 2
        allowed += timestep / 2 * fastest**2 / cos_pitch_squared
    return np.asarray(allowed)


def _were_of_one_frame(omega_body: FloatArray, q_world_body: FloatArray, apart: FloatArray) -> bool:
    """Whether a step that passed would have failed with ω in any other axes, or their order.

    Parameters
    ----------
    omega_body, q_world_body : (n, 3) and (n, 4), of the steps that passed
    apart : rad/s, by which another ω that passes as well may differ, (n,)
    """
    R_world_body = matrices(q_world_body)
    others = [turned(R_world_body, omega_body), turned_back(R_world_body, omega_body)]
    others += [omega_body @ axes for axes in _OTHER_AXES]
    least = np.min([norms(other - omega_body) for other in others], axis=0)
    return bool((least > apart).any())


def _digits(angle: float, makes: float) -> int:
    """The number of digits that shows a step that is a little too long."""
    apart = abs(angle - makes) / max(angle, makes)
    return min(MOST_DIGITS, DIGITS + max(0, math.ceil(-math.log10(apart or 1.0)) - 1))


def _put_back(states: State, pairs: NDArray[np.int64], arm_body: FloatArray) -> FloatArray:
    """The turn, rad, that a constraint may make in each step as it puts back the com; (n,)."""
    arm_world = matrices(states.q_world_body_wxyz) @ arm_body
    drift = norms(states.com_world - arm_world) / float(np.linalg.norm(arm_body))
    return np.asarray(drift[pairs] + drift[pairs + 1])


#: Every other order and sign of three components, as matrices.
_OTHER_AXES = [
    np.diag(signs)[list(order)]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
][1:]

_WAYS: dict[Cause, str] = {
    "frozen": ": the state stands still",
    "late": "; later it turns more: what is read is a step old",
    "lag": "",
    "clock": ": the step is of another length",
    "frames": ", about another axis: the attitude's frame or order of components is not that of ω",
}


def _cause(reading: Reading, k: int, is_aside: bool, is_short: bool) -> Cause:
    """The cause of a turn from state k to the next that does not match ω."""
    states = reading.states
    if _same(states, k, k + 1):
        moves_on = k + 2 < len(reading.steps) and not _same(states, k, k + 2)
        return "late" if reading.steps[k] == 0 and moves_on else "frozen"
    if is_aside:
        return "frames"
    return "lag" if is_short else "clock"


def _resets(reading: Reading) -> Iterator[Fault]:
    """A state that is one of the first two to the last bit, after another one.

    After a reset an engine shows its start, or the step after it, once more.
    """
    scalars = reading.states.q_world_body_wxyz[:, 0]
    for first in range(len(reading.start.omega_body)):
        likely = scalars == reading.start.q_world_body_wxyz[first, 0]
        # Cheap test first: most blocks have no such state.
        if not (likely & (reading.steps > first)).any():
            continue
        is_first = _is_same(reading.states, reading.start, first)
        again = np.flatnonzero(is_first[1:] & ~is_first[:-1] & (reading.steps[1:] > first)) + 1
        if len(again):
            reason = "the state is that of the start again: it was reset"
            yield Fault(int(again[0]), "reset", reason)


def _is_same(states: State, others: State, k: int) -> NDArray[np.bool_]:
    """Which states are one of the others to the last bit, row by row."""
    pairs = zip(_motion(states), _motion(others), strict=True)
    return np.asarray(np.all([(a == b[k]).all(axis=1) for a, b in pairs], axis=0))


def _motion(states: State) -> list[FloatArray]:
    return list(vars(states).values())


def _same(states: State, i: int, j: int) -> bool:
    return all(bool((column[i] == column[j]).all()) for column in _motion(states))


def _is_sound(states: State) -> NDArray[np.bool_]:
    """Whether a state is finite and its quaternion of unit norm, row by row."""
    is_finite = np.isfinite(norms(states.omega_body))
    return is_finite & (np.abs(norms(states.q_world_body_wxyz) - 1) < 0.5)
