"""Closed forms of motions with a period, a million periods on; on separatrices, which have none."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from case_loops import each_case
from closed_form_checks import (
    GOAL,
    LATE,
    RESIDUAL,
    apart,
    apart_at,
    one_ulp_heavier,
    repeated_free,
    repeated_heavy,
)
from extended_motion import ExtendedMotion, RepeatedMotion
from heavy_tops import DOWN, UP, tilted, top
from mpmath import mp, mpf
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.free_asymmetric import free_asymmetric
from spincheck.reference.free_symmetric import free_symmetric
from spincheck.reference.heavy_symmetric_top import heavy_symmetric_top, nutation_period
from spincheck.reference.lagrange import lagrange
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import integrate
from spincheck.reference.theta_quotients import ClosedForm
from taylor_problems import problem
from textbook_periods import DIGITS, Textbook, free_body, heavy_top

pytestmark = pytest.mark.slow


class Kind(NamedTuple):
    """A kind of motion: its closed form, its periods in textbooks, and its motion in sixty digits.

    Attributes
    ----------
    turns : so many times the sixty-digit motion repeats in a period of the closed form
    growth : whether errors of the sixty-digit ODE near the saddle grow by 1/(1 − m)
    """

    closed: Callable[[Problem], ClosedForm]
    book: Callable[[Problem], Textbook]
    repeated: Callable[[Problem], RepeatedMotion]
    turns: int
    growth: bool


FREE = Kind(free_asymmetric, free_body, repeated_free, turns=2, growth=False)
HEAVY = Kind(lagrange, heavy_top, repeated_heavy, turns=1, growth=True)
TILTED = (1.0, 0.2, -0.3, 0.4)
GENERIC = problem((1.0, 2.0, 3.0), (0.3, 0.5, 1.0), TILTED)
#: ω circulates about the third axis; 1 − m down to 2e-14, moments equal to 1e-14.
BODIES = {
    "about the largest moment": GENERIC,
    "about the smallest moment": problem((3.0, 2.0, 1.0), (-0.3, 0.5, 1.0), TILTED),
    "backwards": problem((1.0, 2.0, 3.0), (0.3, -0.5, -1.0), TILTED),
    "1 − m = 1e-6": problem((1.0, 2.0, 3.0), (1e-3, 1.0, 8e-4), TILTED),
    "1 − m = 2e-14": problem((2.0, 3.0, 6.0), (3.0, 1.0, 1.0 + 1e-14), TILTED),
    "below the separatrix": problem((6.0, 3.0, 2.0), (1.0 - 1e-14, 1.0, 3.0), TILTED),
    "tennis racket": problem((1.0, 2.0, 3.0), (1e-8, 1.0, 2e-8), TILTED),
    "nearly oblate": problem((1.0, 1.0 + 1e-14, 2.0), (0.3, 0.4, 0.5), TILTED),
    "nearly prolate": problem((1.0, 1.0 - 1e-14, 0.5), (0.3, 0.4, 0.5), TILTED),
    "nearly steady": problem((1.0, 2.0, 3.0), (1e-9, 1e-9, 1.0), TILTED),
    "starting flat": problem((1.0, 2.0, 3.0), (0.5, 0.0, 1.0), TILTED),
}
LOOP = top((0.0, 0.4, 3.0), tilted(0.5))
TOPS = {
    "loops": LOOP,
    "waves": top((-0.5, 0.1, 3.0), tilted(0.5)),
    "cusps": top((0.0, 0.0, 3.0), tilted(0.5)),
    "cusps, almost steady": top((0.0, 0.0, 300.0), tilted(1.0)),
    "hanging low": top((0.1, 0.2, 3.0), tilted(2.5)),
    "fast": top((0.1, 0.2, 1000.0), tilted(1.0)),
    "thin disc": top((0.1, 0.2, 3.0), tilted(1.0), I3=2.0),
    "nearly a sphere": top((0.1, 0.2, 3.0), tilted(1.0), I3=1.0 + 1e-14),
    "nearly weightless": top((0.1, 0.2, 3.0), tilted(1.0), kappa=1e-6),
    "spherical pendulum": top((0.3, 0.4, 0.0), tilted(2.0)),
    "swing": top((0.0, 0.4, 0.0), tilted(2.0)),
    "over the top": top((0.0, 5.0, 0.0), tilted(0.5)),
    "through the top": top((0.0, 0.5, 2.0), UP),
    "through the bottom": top((0.0, 0.5, 2.0), DOWN),
    "a microradian past the top": top((1e-6, 2.0, 0.5), tilted(0.001)),
    "falling from sleep": top((1e-5, 0.0, 0.2), UP),
    "1 − m = 3e-15": top((0.0, 0.0, 0.2), tilted(1e-7)),
    "asleep but for 1e-6": top((1e-6, 0.0, 5.0), UP),
    "steady to rounding": top((-np.sqrt(0.75), 0.0, 3.0), tilted(np.pi / 3)),
    "a nanoradian from rest": top((1e-9, 0.0, 0.0), (0.0, 1.0, 0.0, 1e-9)),
}
MOTIONS = {name: (FREE, p) for name, p in BODIES.items()}
MOTIONS |= {name: (HEAVY, p) for name, p in TOPS.items()}


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request):
    kind, p = MOTIONS[request.param]
    return kind, p, kind.closed(p), kind.repeated(p)


@each_case("periods", LATE)
def test_the_motion_is_exact_after_any_number_of_periods(motion, periods):
    _, p, closed, exact = motion
    assert apart_at(closed, p, exact, periods) < GOAL


def test_the_constants_solve_the_equations(motion):
    _, _, closed, _ = motion
    assert closed.residual < RESIDUAL


def test_the_period_is_the_textbooks(motion):
    kind, _, closed, exact = motion
    assert closed.period == pytest.approx(float(kind.turns * exact.period), rel=GOAL)


def test_the_period_brings_the_motion_back(motion):
    """But for a turn about the vertical and one about the axis: |A| and |B|."""
    kind, p, _, exact = motion
    assert exact.mismatch < RESIDUAL * (1 / kind.book(p).m1 if kind.growth else 1)


def test_the_period_is_that_of_the_facts():
    top_of_loop = heavy_symmetric_top(LOOP)
    assert top_of_loop is not None
    assert lagrange(LOOP).period == pytest.approx(nutation_period(top_of_loop), rel=GOAL)


@each_case(("kind", "p"), [(FREE, GENERIC), (HEAVY, LOOP)])
def test_one_ulp_in_a_moment_would_show(kind, p):
    neighbour = kind.closed(one_ulp_heavier(p))
    assert apart_at(neighbour, p, kind.repeated(p), LATE[-1]) > GOAL


#: 2 (3 − 2) 3² = 6 (6 − 3) 1²: L² = 2 E I2, in doubles. All four branches, and both orders.
FREE_SEPARATRICES = {
    "++": problem((2.0, 3.0, 6.0), (3.0, 1.0, 1.0), TILTED),
    "+-": problem((2.0, 3.0, 6.0), (3.0, 1.0, -1.0), TILTED),
    "-+": problem((2.0, 3.0, 6.0), (-3.0, -1.0, 1.0), TILTED),
    "--": problem((2.0, 3.0, 6.0), (-3.0, 0.0, -1.0), TILTED),
    "reversed": problem((6.0, 3.0, 2.0), (1.0, -1.0, 3.0), TILTED),
}


def falling(cos_beta: mpf, spin: mpf) -> Problem:
    """Energy and L of a top asleep at this spin, below the threshold, met on its way down."""
    p = top((0.0, 0.0, 0.0), UP)
    with mp.workdps(DIGITS):
        d, delta = spin / 2, 1 - cos_beta  # I3 = 1/2, I1 = κ = 1
        sine = mp.sqrt(1 - cos_beta**2)
        # (L − L3 e3)·(−ĝ) = d δ and |ω⊥|² = 2 δ; −γ = (sin β, 0, −cos β) at this attitude.
        w1 = -d * delta / sine
        w2 = mp.sqrt(2 * delta - w1**2)
        half = mp.acos(cos_beta) / 2
        q = (mp.cos(half), mpf(0), mp.sin(half), mpf(0))
        return Problem(**{**vars(p), "q_world_axes": q, "omega_axes": (w1, w2, spin)})


HEAVY_SEPARATRICES = {
    "pendulum, from below": top((0.0, 2.0, 0.0), DOWN),
    "pendulum, the other way": top((-2.0, 0.0, 0.0), DOWN),
    "pendulum, on its way": falling(mpf(1) / 2, mpf(0)),
    "top, falling": falling(mpf(1) / 2, mpf(1)),
    "top, falling fast": falling(mpf(9) / 10, mpf(3)),
}


def at_poles_of(p: Problem) -> tuple[mpf, mpf]:
    """s to the nearest singularity of a separatrix, π/2p of sech(p t), and a rate that it keeps."""
    if any(p.lever_axes):
        return mpf(1), mpf(3)
    with mp.workdps(DIGITS):
        return mp.pi / 2 / free_body(p).p, mp.sqrt(mp.fdot(p.omega_axes, p.omega_axes))


SEPARATRICES = [(free_asymmetric, p, 20.0) for p in FREE_SEPARATRICES.values()]
SEPARATRICES += [(lagrange, p, 25.0) for p in HEAVY_SEPARATRICES.values()]


@each_case(("closed", "p", "end"), SEPARATRICES)
def test_the_separatrix_is_exact(closed, p, end):
    """Against sixty digits, until it rests on the saddle, or their errors are a double's."""
    times = np.linspace(0.0, end, 11)
    exact = ExtendedMotion(p, *at_poles_of(p), mpf(end) * mpf("1.04"))
    states = [exact.state(mpf(t)) for t in times]
    expected = tuple(np.array([s[k] for s in states], dtype=float) for k in range(2))
    assert apart(closed(p).states(times), expected) < GOAL


@each_case(("closed", "p", "end"), SEPARATRICES)
def test_the_separatrix_never_leaves_the_saddle(closed, p, end):
    q, omega = closed(p).states(np.array([1e3, 1e9]))
    off = np.hypot(q[:, 1], q[:, 2]) if any(p.lever_axes) else np.abs(omega[:, [0, 2]])
    assert off.max() < GOAL
    assert closed(p).period == np.inf


def test_a_motion_next_to_the_separatrix_leaves():
    neighbour = free_asymmetric(one_ulp_heavier(FREE_SEPARATRICES["++"]))
    _, omega = neighbour.states(np.linspace(0.0, 1e3, 1001))
    assert np.abs(omega[500:, 0]).max() > 1


def heavier(p: Problem) -> Problem:
    """The same, pulled at by a lever along its third axis."""
    return replace(p, lever_axes=(0, 0, mpf(1)), gravity_world=(0, 0, mpf(-9)))


NOT_ASYMMETRIC = "must be a free body with three distinct moments"
NOT_SYMMETRIC = "must be a free body with two equal moments"
NOT_LAGRANGES = "symmetric about the lever that gravity alone pulls at"
OBLATE = problem((1.0, 1.0, 1.7), (0.4, -0.9, 2.0), TILTED)


@each_case(
    ("closed", "p", "words"),
    [
        (free_asymmetric, problem((1.0, 2.0, 2.0), (1.0, 1.0, 1.0)), NOT_ASYMMETRIC),
        (free_asymmetric, replace(GENERIC, drag=mpf(1)), NOT_ASYMMETRIC),
        (free_asymmetric, heavier(GENERIC), NOT_ASYMMETRIC),
        (free_symmetric, problem((1.0, 2.0, 2.5), (1.0, 1.0, 1.0)), NOT_SYMMETRIC),
        (free_symmetric, replace(OBLATE, drag=mpf(1)), NOT_SYMMETRIC),
        (free_symmetric, heavier(OBLATE), NOT_SYMMETRIC),
        (lagrange, heavier(problem((1.0, 2.0, 2.5), (1.0, 1.0, 1.0))), NOT_LAGRANGES),
        (lagrange, replace(LOOP, lever_axes=(mpf("1e-9"), mpf(0), mpf(1))), NOT_LAGRANGES),
        (lagrange, replace(LOOP, lever_axes=(mpf(0), mpf(0), mpf(0))), NOT_LAGRANGES),
        (lagrange, replace(LOOP, drag=mpf(1)), NOT_LAGRANGES),
    ],
)
def test_what_is_of_another_kind_is_refused(closed, p, words):
    with pytest.raises(ValueError, match=words):
        closed(p)


@each_case(
    "change",
    [
        {"drag": mpf(1)},
        {"torque_axes": (mpf(0), mpf(0), mpf(1))},
        {"torque_world": (mpf(0), mpf(0), mpf(1))},
        {"moments": (mpf(1), mpf(1) + mpf(10) ** -14, mpf(1) / 2)},
    ],
)
def test_no_closed_form_is_claimed_for_what_has_none(change):
    assert closed_form(LOOP) is not None
    assert closed_form(replace(LOOP, **change)) is None


def test_a_lever_without_gravity_is_a_free_top():
    weightless = replace(LOOP, gravity_world=(mpf(0), mpf(0), mpf(0)))
    times = np.linspace(0.0, 5.0, 11)
    assert apart(closed_form(weightless).states(times), integrate(weightless, times)) < GOAL


def test_precision_is_not_the_callers():
    with mp.workdps(15):
        few = lagrange(LOOP).states(np.array([1e6]))
    with mp.workdps(50):
        many = lagrange(LOOP).states(np.array([1e6]))
    assert apart(few, many) == 0.0
