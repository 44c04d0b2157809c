"""How much a motion changes when its start and its body change by one ulp.

The numbers that are changed, in extended precision, are ω and attitude at t = 0, the principal
moments, the length of the lever, and the constant angular momenta of the rotors. Each is changed by
the same amount relative to itself, a component of ω relative to |ω|. Equal moments stay equal and
the lever keeps its direction, because rounding during a run does not change a body's symmetry.

To first order the change of the motion is J x, where x holds the dozen or so changes. A set of
changes x is called a nudge. J x is computed for only four nudges, which differ in their signs: the
root mean square of |J x| over random signs is the Frobenius norm of J (M. F. Hutchinson, Commun.
Stat. Simul. Comput. 19 (1990) 433), which bounds |J x| for every x of length one.
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
#: Relative sizes of the nudges, tried in turn. The first is large against rounding; the second is
#: an ulp, for motions that grow so much that the first leaves the linear range.
NUDGES = (2.0**-30, EPS)
#: A motion that changes by more than this, relative or in rad, has left the linear range.
LINEAR = 2.0**-10

#: Signs of each number's change in the four nudges. The signs of numbers of one kind are
#: orthogonal, so that the effects of two numbers do not cancel in all nudges.
_A, _B, _C, _D = (1, 1, 1, 1), (1, -1, 1, -1), (1, 1, -1, -1), (1, -1, -1, 1)
SIGNS_OF_OMEGA, SIGNS_OF_TURN = (_B, _C, _D), (_A, _B, _C)
SIGNS_OF_MOMENTS, SIGNS_OF_LEVER = (_D, _A, _B), (_C, _D, _A)
COUNT = len(_A)

Nudge = Callable[[Problem, int, mpf], Problem]
Solved = Callable[[Problem], Trajectory]


def nudged(problem: Problem, k: int, size: mpf) -> Problem:
    """Return the problem with each number of its start, body and rotors changed up or down.

    Moments, the distance from pivot or tip to com, and rotors' momenta are changed by `size` times
    their value; ω by `size` times |ω|, or √(m g l/I), the rate of the body's swing, if larger.
    The attitude is turned by `size` rad about each axis. On a table, the changed motion does not
    end at lift-off: its table can also pull.

    Parameters
    ----------
    k : which of the `COUNT` choices of signs to use, from 0
    size : relative size of the changes
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
            # A changed body may leave its table a little earlier than the original.
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
    """Return how much each signal of a motion changes if its start and body change by one ulp.

    It is the root mean square over `COUNT` choices of the signs of these changes, and at least one
    ulp, in the unit of errors: relative, or rad.

    Parameters
    ----------
    exact_motion : the motion of `problem`
    solved : returns the motion of a changed problem, at the same times
    nudge : returns a changed problem, given the problem, the index of the choice of signs, and the
        relative size of the changes
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
    """Return how much each signal changes if the problem's numbers change by one ulp.

    It is scaled down from the effect of a larger change.

    Parameters
    ----------
    exact_motion : the motion of `problem`
    solved : returns the motion of a changed problem, at the same times
    nudge : returns the changed problem, given the problem, k, and the relative size of the changes
    k : which choice of the signs of the changes is used
    """
    for size in NUDGES:
        apart = errors_between(scenario, solved(nudge(problem, k, mpf(size))), exact_motion)
        if max(apart.omega, apart.attitude) <= LINEAR:
            break
    return Errors(**{name: value * EPS / size for name, value in apart})
