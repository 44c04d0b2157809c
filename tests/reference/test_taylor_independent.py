"""Every term of the equations, against a second derivation of them integrated in mpmath.

The other way round in all: L and the rotation matrix instead of ω and a quaternion, plain 40-digit
vectors, fixed steps.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import TRUTH_ORDERS, integrate_double_double
from spincheck.scenarios.exact import rotate
from taylor_problems import distance, problem, q_and_omega, truncation

pytestmark = pytest.mark.slow

DIGITS = 40
ORDER = 36
STEPS = 8
DURATION = 0.5
EPS = float(np.finfo(float).eps)
BOUND = truncation(TRUTH_ORDERS)

Series = list[mpf]

FREE = problem((1.0, 1.3, 0.7), (0.5, -1.0, 2.0))
TERMS: dict[str, dict[str, object]] = {
    "free": {},
    "gravity": {
        "lever_axes": (mpf(1) / 5, -mpf(1) / 8, mpf(1) / 2),
        "gravity_world": (mpf(2), -mpf(4), mpf(9)),
    },
    "torque in the body": {"torque_axes": (mpf(1) / 3, -mpf(1) / 2, mpf(2) / 3)},
    "torque in the world": {"torque_world": (-mpf(1) / 7, mpf(2), mpf(1) / 2)},
    "drag": {"drag": mpf(1) / 9},
    "rotors": {
        "kept": (mpf(1) / 3, -mpf(2)),
        "kept_axes": ((mpf(3) / 5, mpf(0), mpf(4) / 5), (mpf(0), mpf(1), mpf(0))),
    },
}
TERMS["everything"] = {name: value for terms in TERMS.values() for name, value in terms.items()}


def times(a: Series, b: Series, n: int) -> mpf:
    """Order n of a product of series."""
    return mp.fdot(a[: n + 1], b[n::-1])


def crossed(a: Sequence[Series], b: Sequence[Series], n: int) -> list[mpf]:
    """Order n of a × b."""
    cyclic = ((1, 2), (2, 0), (0, 1))
    return [times(a[j], b[k], n) - times(a[k], b[j], n) for j, k in cyclic]


def torque(p: Problem, rows: Sequence[Series], omega: Sequence[Series], n: int) -> list[mpf]:
    """Order n of the torque along the axes; rows are the world's axes seen from the body's."""
    gravity, pushed = (
        [sum(v[row] * rows[row][i][n] for row in range(3)) for i in range(3)]
        for v in (p.gravity_world, p.torque_world)
    )
    (l1, l2, l3), (g1, g2, g3) = p.lever_axes, gravity
    weight = (l2 * g3 - l3 * g2, l3 * g1 - l1 * g3, l1 * g2 - l2 * g1)
    constant = p.torque_axes if n == 0 else (0, 0, 0)
    return [weight[i] + pushed[i] + constant[i] - p.drag * omega[i][n] for i in range(3)]


def step(p: Problem, L: list[mpf], rows: list[list[mpf]], h: mpf) -> None:
    """Advance L and the rows of R in place: L' = L × ω + torque, each row' = row × ω."""
    L_series = [[x] for x in L]
    row_series = [[[x] for x in row] for row in rows]
    for n in range(ORDER):
        omega = [
            [(x - h * (order == 0)) / i for order, x in enumerate(series)]
            for series, i, h in zip(L_series, p.moments, p.kept_momentum, strict=True)
        ]
        gained = torque(p, row_series, omega, n)
        turning = [crossed(row, omega, n) for row in row_series]
        rate = crossed(L_series, omega, n)
        for i in range(3):
            L_series[i].append((rate[i] + gained[i]) / (n + 1))
            for row, turned in zip(row_series, turning, strict=True):
                row[i].append(turned[i] / (n + 1))
    powers = [h**n for n in range(ORDER + 1)]
    for i in range(3):
        L[i] = mp.fdot(L_series[i], powers)
        for row, series in zip(rows, row_series, strict=True):
            row[i] = mp.fdot(series[i], powers)


def second_solution(p: Problem) -> tuple[list[list[mpf]], list[mpf]]:
    """R, row by row, and ω after `DURATION`."""
    numbers = zip(p.moments, p.omega_axes, p.kept_momentum, strict=True)
    L = [i * w + h for i, w, h in numbers]
    rows = rotation(p.q_world_axes)
    for _ in range(STEPS):
        step(p, L, rows, mpf(DURATION) / STEPS)
    numbers = zip(L, p.kept_momentum, p.moments, strict=True)
    return rows, [(x - h) / i for x, h, i in numbers]


def flat(rows: list[list[mpf]]) -> list[mpf]:
    return [x for row in rows for x in row]


def rotation(q: Sequence[mpf]) -> list[list[mpf]]:
    """R of a quaternion, row by row."""
    columns = [rotate(tuple(q), axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return [list(row) for row in zip(*columns, strict=True)]


@pytest.mark.parametrize("terms", TERMS.values(), ids=TERMS)
def test_the_motion_is_that_of_a_second_derivation(terms: dict[str, object]) -> None:
    p = replace(FREE, **terms)
    q, omega = q_and_omega(integrate_double_double(p, np.array([DURATION])), 0)
    with mp.workdps(DIGITS):
        rows, omega_second = second_solution(p)
        assert distance(omega, omega_second) < BOUND
        assert distance(flat(rotation(q)), flat(rows)) < BOUND


def times_ulp(value: object, ulp: mpf) -> object:
    """A number, or all numbers of a tuple, times a factor."""
    return tuple(times_ulp(x, ulp) for x in value) if isinstance(value, tuple) else value * ulp


@pytest.mark.parametrize("name", sorted(TERMS["everything"]))
def test_every_term_shows_when_it_is_off_by_one_ulp(name: str) -> None:
    p = replace(FREE, **TERMS["everything"])
    value = getattr(p, name)
    nudged = times_ulp(value, 1 + mpf(EPS))
    states = integrate_double_double(replace(p, **{name: nudged}), np.array([DURATION]))
    with mp.workdps(DIGITS):
        assert distance(q_and_omega(states, 0)[1], second_solution(p)[1]) > BOUND
