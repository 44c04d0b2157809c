"""Special motions are the limits of neighbouring ones: closed forms join continuously."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from case_loops import each_case
from closed_form_checks import GOAL, apart
from heavy_tops import DOWN, UP, tilted, top
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from taylor_problems import problem

pytestmark = pytest.mark.slow

#: A disturbance ε has grown to at most this times ε, in three seconds at a radian or so a second;
GROWTH = 30.0
TIMES = np.linspace(0.0, 3.0, 31)
#: and by so many e-folds a second more about the middle axis and on the separatrix:
#: √(1·1/(1·3)) for moments 1, 2, 3; p = 3/2 for the separatrix below.
UNSTABLE_FREE = {"middle axis": 1 / np.sqrt(3.0), "separatrix": 1.5, "other side": 1.5}
#: And where a heavy top may fall: at most √(M g l/I1).
UNSTABLE_TOPS = {
    "balanced": 1.0,
    "asleep, unstably": 1.0,
    "separatrix": 1.0,
    "through the top": 1.0,
}

START = problem((1.0, 1.0, 1.0), (0.5, 0.4, 0.3), (1.0, 0.2, -0.3, 0.4))
#: Of free bodies: moments and ω by the disturbance.
FREE = {
    "oblate": lambda e: ((1, 1 + e, 2), (0.5, 0.4, 0.3)),
    "prolate": lambda e: ((1, 2, 2 - e), (0.5, 0.4, 0.3)),
    "sphere": lambda e: ((1, 1 + e, 1 + 3 * e), (0.5, 0.4, 0.3)),
    "smallest axis": lambda e: ((1, 2, 3), (1, e, e)),
    "middle axis": lambda e: ((1, 2, 3), (e, 1, 2 * e)),
    "largest axis": lambda e: ((1, 2, 3), (e, e, 1)),
    "symmetry axis": lambda e: ((1, 1, 2), (e, e, 1)),
    "separatrix": lambda e: ((2, 3, 6), (3, 1, 1 + e)),
    "other side": lambda e: ((2, 3, 6), (3, 1, 1 - e)),
}
#: Of heavy tops: ω, attitude, I3 and M g l by the disturbance.
TOPS = {
    "asleep": lambda e: ((e, -e, 5), UP, 0.5, 1),
    "asleep, barely": lambda e: ((e, e, 4), UP, 0.5, 1),
    "asleep, unstably": lambda e: ((e, e, 1), UP, 0.5, 1),
    "asleep, tilted": lambda e: ((0, 0, 5), (1, e, 0, 0), 0.5, 1),
    "balanced": lambda e: ((e, e, 0), UP, 0.5, 1),
    "hanging": lambda e: ((e, e, 2), DOWN, 0.5, 1),
    "steady": lambda e: ((-1, e, 2), (1, 0, 1, 0), 0.5, 1),
    "cusp": lambda e: ((0, e, 3), tilted(0.5), 0.5, 1),
    "pendulum": lambda e: ((0, 1, e), tilted(2.0), 0.5, 1),
    "over the top": lambda e: ((e, 5, e), tilted(0.5), 0.5, 1),
    "through the top": lambda e: ((1, 1, 2), (1, e, e, 0), 0.5, 1),
    "through the bottom": lambda e: ((1, 1, 2), (e, 1, e, 0), 0.5, 1),
    "separatrix": lambda e: ((0, 2 + e, 0), DOWN, 0.5, 1),
    "separatrix, beside": lambda e: ((e, 2, e), DOWN, 0.5, 1),
    "sphere": lambda e: ((0.3, 1, 2), tilted(1.0), 1 + e, 1),
    "weightless": lambda e: ((0.3, 1, 2), tilted(1.0), 0.5, e),
    "weightless, not spinning": lambda e: ((0.3, 1, 0), tilted(1.0), 0.5, e),
    "weightless rigid turn": lambda e: ((0, 0, 2), tilted(1.0), 0.5, e),
}


def disturbed_free_body(kind: str, epsilon: float) -> Problem:
    with mp.workdps(60):
        moments, omega = (tuple(map(mpf, v)) for v in FREE[kind](mpf(epsilon)))
    return replace(START, moments=moments, omega_axes=omega)


def disturbed_top(kind: str, epsilon: float) -> Problem:
    with mp.workdps(60):
        omega, q, I3, kappa = TOPS[kind](mpf(epsilon))
        length = mp.sqrt(mp.fsum(mpf(c) ** 2 for c in q))
        return replace(
            top((0.0, 0.0, 0.0), UP),
            moments=(mpf(1), mpf(1), mpf(I3)),
            omega_axes=tuple(map(mpf, omega)),
            q_world_axes=tuple(mpf(c) / length for c in q),
            lever_axes=(mpf(0), mpf(0), mpf(kappa)),
        )


SPECIAL = {
    **{f"free, {kind}": (disturbed_free_body, kind, UNSTABLE_FREE) for kind in FREE},
    **{f"heavy, {kind}": (disturbed_top, kind, UNSTABLE_TOPS) for kind in TOPS},
}


@cache
def states(
    disturbed: Callable[[str, float], Problem], kind: str, epsilon: float
) -> tuple[np.ndarray, np.ndarray]:
    """The closed form's, at `TIMES`."""
    return closed_form(disturbed(kind, epsilon)).states(TIMES)


def reach(kind: str, unstable: dict[str, float], epsilon: float) -> float:
    """How far a neighbour may have gone."""
    return GROWTH * np.exp(unstable.get(kind, 0.0) * TIMES[-1]) * epsilon + GOAL


@each_case("epsilon", [1e-6, 1e-12, 1e-30])
@each_case(("disturbed", "kind", "unstable"), SPECIAL)
def test_a_special_motion_is_the_limit_of_its_neighbours(disturbed, kind, unstable, epsilon):
    special, near = (states(disturbed, kind, e) for e in (0.0, epsilon))
    assert apart(near, special) < reach(kind, unstable, epsilon)


@each_case(("disturbed", "kind", "unstable"), SPECIAL)
def test_a_neighbour_further_away_is_not_that_close(disturbed, kind, unstable):
    special, far = (states(disturbed, kind, e) for e in (0.0, 1e-2))
    assert apart(far, special) > reach(kind, unstable, 1e-6)
