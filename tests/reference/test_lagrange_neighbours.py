"""A heavy top's special motions are the limits of their neighbours: nothing jumps between forms."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form_checks import GOAL, apart
from heavy_tops import DOWN, UP, tilted, top
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem

#: A disturbance ε has grown to at most this times ε, in three seconds at a radian or so a second;
GROWTH = 30.0
TIMES = np.linspace(0.0, 3.0, 31)
#: and by this many e-folds a second more where the top may fall: at most √(M g l/I1).
UNSTABLE = {"balanced": 1.0, "asleep, unstably": 1.0, "separatrix": 1.0, "through the top": 1.0}

#: ω, attitude, I3 and M g l by the disturbance.
SPECIAL = {
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


def disturbed(kind: str, epsilon: float) -> Problem:
    with mp.workdps(60):
        omega, q, I3, kappa = SPECIAL[kind](mpf(epsilon))
        length = mp.sqrt(mp.fsum(mpf(c) ** 2 for c in q))
        return replace(
            top((0.0, 0.0, 0.0), UP),
            moments=(mpf(1), mpf(1), mpf(I3)),
            omega_axes=tuple(map(mpf, omega)),
            q_world_axes=tuple(mpf(c) / length for c in q),
            lever_axes=(mpf(0), mpf(0), mpf(kappa)),
        )


def reach(kind: str, epsilon: float) -> float:
    """How far a neighbour may have gone."""
    return GROWTH * np.exp(UNSTABLE.get(kind, 0.0) * TIMES[-1]) * epsilon + GOAL


@pytest.mark.parametrize("epsilon", [1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-30])
@pytest.mark.parametrize("kind", SPECIAL)
def test_a_special_motion_is_the_limit_of_its_neighbours(kind, epsilon):
    special, near = (closed_form(disturbed(kind, e)).states(TIMES) for e in (0.0, epsilon))
    assert apart(near, special) < reach(kind, epsilon)


@pytest.mark.parametrize("kind", SPECIAL)
def test_a_neighbour_further_away_is_not_that_close(kind):
    special, far = (closed_form(disturbed(kind, e)).states(TIMES) for e in (0.0, 1e-2))
    assert apart(far, special) > reach(kind, 1e-6)
