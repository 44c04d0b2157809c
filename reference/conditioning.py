"""What one ulp in the start and the body does to a motion.

Changed are, in extended precision, ω and attitude at t = 0, the principal moments, the lever's
length, and what parts keep: every number by as much, relative to the largest of its kind. Equal
moments stay equal and the lever keeps its direction: rounding in a run, step by step, changes no
body's symmetry.

To first order the change of the motion is J x, x being the dozen nudges. It is measured for four x
of signs only; the root mean square of |J x| over random signs is the Frobenius norm of J
(M. F. Hutchinson, Commun. Stat. Simul. Comput. 19 (1990) 433), which bounds |J x| for every x of
length one.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from mpmath import mp, mpf

from ..scenarios import Errors, Scenario, Trajectory, errors_between
from ..scenarios.exact import DIGITS, normalised, product
from .problem import Problem
from .symmetry import gravity_torque_scale, norm

EPS = float(np.finfo(float).eps)
#: Relative nudges. The first is large against rounding; where the motion grows it out of the
#: linear range, the next is what the result is about: an ulp.
NUDGES = (2.0**-30, EPS)
#: A motion moved by more than this, relative or in rad, has left the linear range.
LINEAR = 2.0**-10

#: Signs of a number in the four nudges. Numbers of a kind have orthogonal ones: none cancel.
_A, _B, _C, _D = (1, 1, 1, 1), (1, -1, 1, -1), (1, 1, -1, -1), (1, -1, -1, 1)
SIGNS_OF_OMEGA, SIGNS_OF_TURN = (_B, _C, _D), (_A, _B, _C)
SIGNS_OF_MOMENTS, SIGNS_OF_LEVER = (_D, _A, _B), (_C, _D, _A)
COUNT = len(_A)

Nudge = Callable[[Problem, int, mpf], Problem]
Solved = Callable[[Problem], Trajectory]


def nudged(problem: Problem, k: int, size: mpf) -> Problem:
    """The problem with all numbers changed by `size`, relative, with the k-th choice of signs.

    ω is changed relative to its size or, if larger, the rate of the body's swing, √(m g l / I).
    """
    with mp.workdps(DIGITS):
        by_moment = {
            moment: moment * (1 + size * signs[k])
            for moment, signs in zip(problem.moments, SIGNS_OF_MOMENTS, strict=True)
        }
        first, second, third = (by_moment[moment] for moment in problem.moments)
        swing = mp.sqrt(gravity_torque_scale(problem) / max(problem.moments))
        speed = max(norm(problem.omega_axes), swing)
        w1, w2, w3 = (
            w + size * speed * signs[k]
            for w, signs in zip(problem.omega_axes, SIGNS_OF_OMEGA, strict=True)
        )
        turn = normalised((mpf(1), *(size / 2 * signs[k] for signs in SIGNS_OF_TURN)))
        return replace(
            # A neighbour may come off its table a little earlier.
            problem.lengthened(1 + size * SIGNS_OF_LEVER[0][k]),
            moments=(first, second, third),
            omega_axes=(w1, w2, w3),
            q_world_axes=product(problem.q_world_axes, turn),
            kept=tuple(
                kept * (1 + size * SIGNS_OF_LEVER[part % 2][k])
                for part, kept in enumerate(problem.kept)
            ),
        )


def conditioning(
    scenario: Scenario,
    problem: Problem,
    exact_motion: Trajectory,
    solved: Solved,
    nudge: Nudge = nudged,
) -> Errors:
    """Change of a motion by one ulp, at least one ulp itself.

    Parameters
    ----------
    exact_motion : the motion of `problem`
    solved : what finds that of a neighbour, at the same times
    nudge : the problem with its numbers changed by a relative size, with the k-th choice of signs
    """
    responses = [_response(scenario, problem, exact_motion, solved, nudge, k) for k in range(COUNT)]
    sizes = {
        name: float(np.sqrt(np.mean([response[name] ** 2 for response in responses])))
        for name, _ in responses[0]
    }
    return Errors(**{name: max(size, EPS) for name, size in sizes.items()})


def _response(
    scenario: Scenario,
    problem: Problem,
    exact_motion: Trajectory,
    solved: Solved,
    nudge: Nudge,
    k: int,
) -> Errors:
    """Change of the motion by one ulp of the k-th nudge."""
    for size in NUDGES:
        apart = errors_between(scenario, solved(nudge(problem, k, mpf(size))), exact_motion)
        if max(apart.omega, apart.attitude) <= LINEAR:
            break
    return Errors(**{name: value * EPS / size for name, value in apart})
