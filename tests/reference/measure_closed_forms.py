"""Prints the figures of docs/explanation/closed-forms.md: error, CPU time, effect of an ulp.

    PYTHONPATH=tests/support python tests/reference/measure_closed_forms.py

It takes about three minutes, nearly all of it for the sixty-digit motions that the closed forms are
compared with.
"""

import math
import random
from collections.abc import Callable, Iterator
from time import process_time

import numpy as np
from closed_form_checks import apart_at, one_ulp_heavier, repeated_free, repeated_heavy
from extended_motion import RepeatedMotion
from heavy_tops import UP, tilted, top
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from taylor_problems import problem

PERIODS = (0, 1_000, 1_000_000, 1_000_000_000)
CASES = 80
SEED = 20
#: Beyond, an exact motion in sixty digits takes too long or has lost its own digits to a saddle.
MOST_TURNS = 400.0
LEAST_DIGITS_OF_EXACT = 1e-28

Case = tuple[Problem, Callable[[Problem], RepeatedMotion]]


def small(draw: random.Random, least: float = -12.0) -> float:
    return float(draw.choice((-1, 1)) * 10 ** draw.uniform(least, -1))


def free_bodies(draw: random.Random) -> Iterator[Case]:
    """Any shape, flat, nearly symmetric, nearly round; any ω, near an axis, near the separatrix."""
    while True:
        a, b = draw.uniform(0.1, 3), draw.uniform(0.1, 3)
        moments = draw.choice(
            [
                (a, b, draw.uniform(abs(a - b), a + b)),
                (a, a * (1 + abs(small(draw, -14))), draw.uniform(0.1 * a, 2 * a)),
                (a, b, (a + b) * (1 - abs(small(draw)))),
                (a, a * (1 + abs(small(draw)) / 2), a * (1 + abs(small(draw)) / 2)),
            ]
        )
        I1, I2, I3 = sorted(moments)
        w1, w2, w3 = (draw.gauss(0, 1) for _ in range(3))
        level = math.sqrt(I1 * (I2 - I1) / (I3 * (I3 - I2))) if I3 > I2 else 1.0
        omega = draw.choice(
            [
                (w1, w2, w3),
                (small(draw), 1.0, small(draw)),
                (small(draw), small(draw), 1.0),
                (w1, w2, abs(w1) * level * (1 + small(draw, -14))),
            ]
        )
        if I3 * (I3 - I2) * omega[2] ** 2 > I1 * (I2 - I1) * omega[0] ** 2:
            yield problem((I1, I2, I3), omega, attitude(draw)), repeated_free
        else:
            yield problem((I3, I2, I1), omega[::-1], attitude(draw)), repeated_free


def heavy_tops(draw: random.Random) -> Iterator[Case]:
    """Any shape and weight; any spin or none; anywhere, at a pole and next to one."""
    while True:
        w1, w2, w3 = (draw.gauss(0, 1) for _ in range(3))
        omega = draw.choice(
            [(w1, w2, 30 * w3), (small(draw), small(draw), w3), (w1, w2, 0.0), (0.0, 0.0, w3)]
        )
        I3 = draw.choice([draw.uniform(0.01, 2.0), 1 + small(draw), 1e-3])
        q = draw.choice([attitude(draw), UP, (1.0, small(draw), small(draw), w1)])
        yield top(omega, q, I3, 10 ** draw.uniform(-2, 2)), repeated_heavy


def attitude(draw: random.Random) -> tuple[float, float, float, float]:
    w, x, y, z = (draw.gauss(0, 1) for _ in range(4))
    return (w, x, y, z)


def print_errors(name: str, cases: Iterator[Case]) -> None:
    """The worst error of `CASES` cases after so many periods, and the worst residual."""
    worst, residual, setups = dict.fromkeys(PERIODS, 0.0), 0.0, []
    while len(setups) < CASES:
        p, exact_motion_of = next(cases)
        begun = process_time()
        closed = closed_form(p)
        took = process_time() - begun
        assert closed is not None
        turns = (closed.period or math.inf) * (1 + max(abs(float(w)) for w in p.omega_axes))
        if turns > MOST_TURNS:
            continue
        exact = exact_motion_of(p)
        if exact.mismatch > LEAST_DIGITS_OF_EXACT:
            continue
        setups.append(took)
        residual = max(residual, closed.residual)
        for periods in PERIODS:
            worst[periods] = max(worst[periods], apart_at(closed, p, exact, periods))
    errors = ", ".join(f"{error:.1e} after {n:g}" for n, error in worst.items())
    print(f"{name}: {CASES} cases, worst error {errors} periods; residual {residual:.0e};")
    print(f"    constants in {1e3 * np.median(setups):.0f} ms, {1e3 * max(setups):.0f} at most")


def print_ulp(name: str, case: Case) -> None:
    p, exact_motion_of = case
    neighbour, exact = closed_form(one_ulp_heavier(p)), exact_motion_of(p)
    assert neighbour is not None
    errors = ", ".join(f"{apart_at(neighbour, p, exact, n):.0e} after {n:g}" for n in PERIODS)
    print(f"{name}, one ulp more in a moment: {errors} periods")


if __name__ == "__main__":
    body = problem((1.0, 2.0, 3.0), (0.3, 0.5, 1.0), (1.0, 0.2, -0.3, 0.4))
    heavy = top((0.0, 0.4, 3.0), tilted(0.5))
    print_ulp("free body", (body, repeated_free))
    print_ulp("heavy top", (heavy, repeated_heavy))
    print_errors("free bodies", free_bodies(random.Random(SEED)))
    print_errors("heavy tops", heavy_tops(random.Random(SEED)))
