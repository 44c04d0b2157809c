"""A free body's special motions are the limits of their neighbours: nothing jumps between forms."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form_checks import GOAL, apart
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from taylor_problems import problem

#: A disturbance ε has grown to at most this times ε, in three seconds at a radian or so a second;
GROWTH = 30.0
TIMES = np.linspace(0.0, 3.0, 31)
#: and by so many e-folds a second more about the middle axis and on the separatrix:
#: √(1·1/(1·3)) for moments 1, 2, 3; p = 3/2 for the separatrix below.
UNSTABLE = {"middle axis": 1 / np.sqrt(3.0), "separatrix": 1.5, "other side": 1.5}

START = problem((1.0, 1.0, 1.0), (0.5, 0.4, 0.3), (1.0, 0.2, -0.3, 0.4))
#: Moments and ω by the disturbance.
SPECIAL = {
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


def disturbed(kind: str, epsilon: float) -> Problem:
    with mp.workdps(60):
        moments, omega = (tuple(map(mpf, v)) for v in SPECIAL[kind](mpf(epsilon)))
    return replace(START, moments=moments, omega_axes=omega)


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
