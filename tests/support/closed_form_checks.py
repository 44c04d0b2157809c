"""Compares closed forms with sixty-digit motions at late times."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from extended_motion import DIGITS, ExtendedMotion, RepeatedMotion
from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.reference.theta_quotients import ClosedForm
from spincheck.scenarios.exact import rotate
from textbook_periods import Textbook, free_body, heavy_top

EPS = float(np.finfo(float).eps)
#: What the closed forms promise at any time: in q, and in ω relative to its greatest component.
GOAL = 1e-15
#: Of sixty digits, what a misfit of the constants may take: the cancellations near a saddle.
RESIDUAL = 1e-40
PHASES = np.random.default_rng(7).uniform(0.0, 1.0, 8)
#: Periods after which the motion is compared.
LATE = (0, 1_000, 1_000_000)

States = tuple[np.ndarray, np.ndarray]


def apart(one: States, other: States) -> float:
    """Largest difference, signs of q included: it is continuous and starts as the problem's."""
    speed = np.abs(other[1]).max() or 1.0
    return max(np.abs(one[0] - other[0]).max(), np.abs(one[1] - other[1]).max() / speed)


def apart_at(
    closed: ClosedForm, problem: Problem, exact_motion: RepeatedMotion, periods: int
) -> float:
    """The same, of a closed form and a sixty-digit motion, in the period after so many."""
    times = (PHASES + periods) * float(exact_motion.period)
    q, omega = closed.states(times)
    true = [exact_motion.state(t) for t in times]
    speed = max(abs(w) for _, omega_true in true for w in omega_true)
    return float(
        max(
            max(*_differences(q[i], true[i][0]), max(_differences(omega[i], true[i][1])) / speed)
            for i in range(len(times))
        )
    )


def repeated_free(problem: Problem) -> RepeatedMotion:
    """A free body's motion; ω must circulate about its third axis, and the second be the middle."""
    with mp.workdps(DIGITS):
        L = tuple(i * w for i, w in zip(problem.moments, problem.omega_axes, strict=True))
        L_world = rotate(problem.q_world_axes, L)
    return _repeated(problem, free_body(problem), L_world)


def repeated_heavy(problem: Problem) -> RepeatedMotion:
    """A symmetric top's motion, with its lever along the third axis and gravity along −z."""
    return _repeated(problem, heavy_top(problem), (mpf(0), mpf(0), mpf(1)))


def _repeated(problem: Problem, book: Textbook, vertical: Sequence[mpf]) -> RepeatedMotion:
    """Half a period of ω turns the third axis by π, or brings the tilt back."""
    with mp.workdps(DIGITS):
        period = 2 * book.K / book.p
        pull = abs(mp.fdot(problem.lever_axes, problem.gravity_world)) / problem.moments[0]
        rate = mp.sqrt(mp.fdot(problem.omega_axes, problem.omega_axes)) + mp.sqrt(pull)
        motion = ExtendedMotion(problem, book.pole, rate, period * mpf("1.2"))
    return RepeatedMotion(motion, period, vertical)


def one_ulp_heavier(problem: Problem) -> Problem:
    """The third moment's next double."""
    first, second, third = problem.moments
    return replace(problem, moments=(first, second, mpf(np.nextafter(float(third), np.inf))))


def _differences(one: Sequence[float], other: Sequence[mpf]) -> list[mpf]:
    return [abs(mpf(float(a)) - b) for a, b in zip(one, other, strict=True)]
