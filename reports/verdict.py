"""Judges a method on its ladder: does it go to the truth as its timestep goes to zero."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray, Trajectory

VerdictWord = Literal["converges", "disagrees", "unresolved", "diverges", "unsupported", "failed"]
Signal = Literal["omega", "attitude"]

#: The order found must reach the order declared to within this.
ORDER_SLACK = 0.25
#: An order is read off errors at least this many times the reference's own uncertainty.
ABOVE_UNCERTAINTY = 100.0
#: Larger errors are not in the asymptotic range: on the unit sphere of directions they saturate.
ASYMPTOTIC = 0.1
#: Rungs an order is fitted to: the finest usable ones.
FITTED_RUNGS = 3
#: A limit known no better than this says nothing, relative (ω) or in rad (attitude).
SHARP = 1e-2
#: A limit is another one if it is this many times further from the truth than it is known to be;
#: up to there a finer rung has to tell: it halves what the limit is known to, at the least.
DISTINCT = 4.0
#: Differences between rungs must at least shrink like dt to this power for a ladder to settle.
SETTLING_ORDER = 0.5


@dataclass(frozen=True, eq=False)
class Step:
    """A finished rung: its timestep (s), steps taken, motion, and the round-off to expect of it.

    `round_off` maps a signal to the error that rounding alone may have caused.
    """

    timestep: float
    steps: int
    motion: Trajectory
    round_off: dict[Signal, float]


@dataclass(frozen=True)
class Judgement:
    """What a ladder shows of one signal.

    Attributes
    ----------
    word, reason : the verdict and why, in words
    order : signed order of accuracy found, None where errors are at round-off
    limit_error : distance of the motion extrapolated to dt → 0 from the truth
    limit_estimate : how well that limit is known, from the ladder alone
    needed_timestep : s, what would resolve the ladder, where it is unresolved
    """

    word: VerdictWord
    reason: str
    order: float | None = None
    limit_error: float | None = None
    limit_estimate: float | None = None
    needed_timestep: float | None = None


def judge(
    signal: Signal,
    ladder: Sequence[Step],
    truth: Trajectory,
    declared_order: int,
    uncertainty: float,
) -> Judgement:
    """Judge one signal of a ladder of at least three halved timesteps, coarse to fine.

    Parameters
    ----------
    uncertainty : of `truth` in this signal
    """

    def error(motion: Trajectory, other: Trajectory) -> float:
        return float(_SERIES[signal](motion, other).max())

    errors = np.array([error(step.motion, truth) for step in ladder])
    floors = np.array([step.round_off[signal] for step in ladder])
    if (errors <= floors + uncertainty).all():
        return Judgement("converges", "errors are at round-off throughout")
    limits = [
        _extrapolate(coarse.motion, fine.motion, declared_order)
        for coarse, fine in pairwise(ladder)
    ]
    moves = np.array([error(a, b) for a, b in pairwise(limits)])
    best = _finest_above_round_off(moves, floors[2:])
    estimate = _estimate(moves, best, declared_order)
    off = _SERIES[signal](limits[best + 1], truth)
    limit_error = float(off.max())
    timesteps = np.array([step.timestep for step in ladder])
    order = fitted_order(timesteps, errors, floors, uncertainty)
    allowance = estimate + uncertainty + float(floors[best + 2])
    return _weigh(
        _Found(
            ladder,
            errors,
            order,
            declared_order,
            estimate,
            limit_error,
            allowance,
            moves=moves[: best + 1],
            uncertainty=uncertainty,
            since=float(truth.t[np.argmax(off > allowance)]),
        )
    )


@dataclass(frozen=True, eq=False)
class _Found:
    ladder: Sequence[Step]
    errors: FloatArray
    order: float | None
    declared: int
    estimate: float
    limit_error: float
    allowance: float
    moves: FloatArray
    uncertainty: float
    since: float


def _weigh(found: _Found) -> Judgement:
    """Turn what was found into a verdict."""
    at_limit = found.limit_error <= found.allowance
    in_order = found.order is None or found.order >= found.declared - ORDER_SLACK
    sharp = found.estimate <= SHARP
    numbers = (found.order, found.limit_error, found.estimate)
    limit = (
        f"the limit dt → 0 is {max(found.limit_error, found.uncertainty):.1e} off, "
        f"which may be {found.allowance:.1e}"
    )
    if sharp and at_limit and in_order:
        return Judgement("converges", f"{_order_words(found)}; {limit}", *numbers)
    elsewhere = found.limit_error > DISTINCT * found.allowance
    if sharp and elsewhere and _settles(found.moves):
        return Judgement(
            "disagrees", f"settles elsewhere, from t = {found.since:.3g} s on: {limit}", *numbers
        )
    needed = _needed_timestep(found)
    reason = (
        f"not in its asymptotic range: {_order_words(found)}, {limit}; "
        f"a timestep of {needed:.1e} s would tell"
    )
    return Judgement("unresolved", reason, *numbers, needed)


def _order_words(found: _Found) -> str:
    if found.order is None:
        return "too few errors above round-off to read an order"
    above = " or better" if found.order > found.declared + ORDER_SLACK else ""
    return f"order {found.order:.2f}, declared {found.declared}{above}"


def _settles(moves: FloatArray) -> bool:
    """Whether the extrapolated limits move less and less, down to the finest."""
    return len(moves) > 1 and bool(moves[-1] <= moves[-2] * 2**-SETTLING_ORDER)


def _finest_above_round_off(moves: FloatArray, floors: FloatArray) -> int:
    """Index of the last limit that moved by more than rounding; beyond it there is only noise."""
    above = np.flatnonzero(moves > floors)
    return int(above[-1]) if len(above) else int(np.argmin(moves))


def _estimate(moves: FloatArray, best: int, order: int) -> float:
    """How well the limit is known: by how much it moved last.

    The move overestimates the error in the asymptotic range, where it shrinks by 2^(p+1) a rung;
    the move before, shrunk so, keeps one that is small by accident from being believed.
    """
    before = moves[best - 1] / 2 ** (order + 1) if best else 0.0
    return float(max(moves[best], before))


def fitted_order(
    timesteps: FloatArray, errors: FloatArray, floors: FloatArray, uncertainty: float
) -> float | None:
    """Signed least-squares slope of log error against log dt over the finest usable rungs.

    Usable are errors in the asymptotic range and above round-off and the reference's uncertainty;
    of fewer than two there is no slope. All arrays are (n,), coarse to fine.
    """
    usable = (errors > ABOVE_UNCERTAINTY * uncertainty) & (errors > floors) & (errors < ASYMPTOTIC)
    finest = np.flatnonzero(usable)[-FITTED_RUNGS:]
    if len(finest) < 2:
        return None
    return float(np.polyfit(np.log(timesteps[finest]), np.log(errors[finest]), 1)[0])


def _needed_timestep(found: _Found) -> float:
    """The timestep at which errors are asymptotic and the limit is sharp, by the declared order."""
    finest = found.ladder[-1].timestep
    by_error = (ASYMPTOTIC / max(found.errors[-1], ASYMPTOTIC)) ** (1 / found.declared)
    by_limit = (SHARP / max(found.estimate, SHARP)) ** (1 / (found.declared + 1))
    # Three rungs are read, so the finest must lie below the point where the range begins.
    return float(finest * min(by_error, by_limit) / 2 ** (FITTED_RUNGS - 1))


def _extrapolate(coarse: Trajectory, fine: Trajectory, order: int) -> Trajectory:
    """Richardson's limit of two runs at dt and dt / 2 (Hairer, Nørsett & Wanner I, §II.4).

    Vectors linearly; attitudes along the rotation from the coarse to the fine one.
    """
    weight = 1.0 / (2**order - 1)
    turn = (coarse.R_world_body.inv() * fine.R_world_body).as_rotvec()
    attitude = fine.R_world_body * Rotation.from_rotvec(weight * turn)

    def limit(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray(b + weight * (b - a), dtype=float)

    return Trajectory(
        t=fine.t,
        q_world_body_wxyz=attitude.as_quat(scalar_first=True),
        omega_body=limit(coarse.omega_body, fine.omega_body),
        com_world=limit(coarse.com_world, fine.com_world),
        velocity_world=limit(coarse.velocity_world, fine.velocity_world),
    )


def _omega_series(motion: Trajectory, truth: Trajectory) -> FloatArray:
    base = np.linalg.norm(truth.omega_body, axis=1).max()
    off = np.asarray(np.linalg.norm(motion.omega_body - truth.omega_body, axis=1))
    return off / base if base else (off > 0).astype(float)


def _attitude_series(motion: Trajectory, truth: Trajectory) -> FloatArray:
    return np.asarray((motion.R_world_body.inv() * truth.R_world_body).magnitude())


_SERIES: dict[Signal, Callable[[Trajectory, Trajectory], FloatArray]] = {
    "omega": _omega_series,
    "attitude": _attitude_series,
}
