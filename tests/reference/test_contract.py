"""Requirements on the exact motion, for every scene of the library.

It is finite, within its stated uncertainty, conserves what is conserved, and depends continuously
on the scene. Each check is also made with a planted fault, and must fail. The equations of motion
are checked in `test_contract_equations`.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from case_loops import each_case
from contract_references import (
    SCENES,
    SIXTY_DIGITS,
    at,
    by_series,
    every_scene,
    in_sixty_digits,
    solved,
    states,
)
from mpmath import mp, mpf
from spincheck.reference.conditioning import (
    SIGNS_OF_LEVER,
    SIGNS_OF_MOMENTS,
    conditioning,
    nudged,
)
from spincheck.reference.motion import motion
from spincheck.reference.problem import Problem
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.solution import MAX_UNCERTAINTY
from spincheck.reference.solve import CHECKED_TURN
from spincheck.reference.symmetry import norm
from spincheck.reference.taylor import CHECK_ORDERS, integrate
from spincheck.reports.harness.scene_checks.reference_checks import drifting
from spincheck.scenarios import Errors, Trajectory, errors_between
from spincheck.scenarios.exact import DIGITS, normalised, product
from spincheck.scenarios.fastest_rate import fastest_rate

pytestmark = pytest.mark.slow

EPS = float(np.finfo(float).eps)
#: Relative, and in rad: a fault that nobody would see and every check must.
SLIP = 1e-11
#: Ulp, by which start and body are changed.
ULPS = 4
#: Conditioning is measured with a dozen changes at once, which may cancel in part.
CANCELLED = 2


@cache
def slipped(name: str) -> Trajectory:
    """The motion of a start turned by `SLIP`, and faster by it."""
    scenario, solution = solved(name)
    problem, times = rotational_problem(scenario), solution.trajectory.t
    with mp.workdps(DIGITS):
        slip = mpf(SLIP)
        turned = product(problem.q_world_axes, normalised((1, slip / 2, slip / 2, slip / 2)))
        w1, w2, w3 = (w * (1 + slip) for w in problem.omega_axes)
    moved = replace(problem, q_world_axes=turned, omega_axes=(w1, w2, w3))
    return motion(scenario, moved, times, states(moved, times))


def within_reach(name: str) -> Trajectory:
    """A motion as far as the ODE follows it in good time."""
    scenario, solution = solved(name)
    exact_motion = solution.trajectory
    rate = fastest_rate(scenario, exact_motion.omega_body)
    return exact_motion.until(int(np.count_nonzero(exact_motion.t * rate <= CHECKED_TURN)))


def agree_within_uncertainty(name: str, other: Trajectory) -> bool:
    """Whether another way finds the same within the stated uncertainty; and no faulty motion."""
    scenario, solution = solved(name)
    mine, faulty = at(solution.trajectory, other.t), at(slipped(name), other.t)
    assert beyond(errors_between(scenario, other, faulty), solution.uncertainty)
    return beyond(errors_between(scenario, other, mine), solution.uncertainty) == []


def beyond(errors: Errors, bounds: Errors) -> list[str]:
    """Signals whose error exceeds its bound."""
    return [name for name, error in errors if not error <= getattr(bounds, name)]


@every_scene
def test_it_is_finite_up_to_its_end_or_a_stated_horizon(name):
    scenario, solution = solved(name)
    exact_motion = solution.trajectory
    assert (exact_motion.t == scenario.times[: len(exact_motion.t)]).all()
    assert all(np.isfinite(getattr(exact_motion, field)).all() for field in vars(exact_motion))
    if solution.horizon is None:
        assert len(exact_motion.t) == len(scenario.times)
    else:
        assert solution.horizon == scenario.times[len(exact_motion.t)]
    assert max(solution.uncertainty.omega, solution.uncertainty.attitude) <= MAX_UNCERTAINTY


@each_case("name", [name for name in SCENES if name not in SIXTY_DIGITS])
def test_a_dearer_series_finds_the_same_within_the_stated_uncertainty(name):
    assert agree_within_uncertainty(name, by_series(*solved(name)))


@each_case("name", SIXTY_DIGITS)
def test_sixty_digits_find_the_same(name):
    assert agree_within_uncertainty(name, in_sixty_digits(*solved(name)))


@every_scene
def test_a_drift_of_a_billionth_in_the_spin_is_noticed(name):
    """Where anything that depends on ω is conserved, and the body turns.

    That nothing drifts without a fault is verified by each scene's own item.
    """
    scenario, solution = solved(name)
    exact_motion = solution.trajectory
    if not exact_motion.omega_body.any():
        pytest.skip("a body that does not turn has no spin to lose")
    growing = 1 + 1e-9 * exact_motion.t / exact_motion.t[-1]
    faulty = replace(exact_motion, omega_body=exact_motion.omega_body * growing[:, None])
    if not list(drifting(scenario, replace(solution, trajectory=faulty))):
        pytest.skip("nothing that depends on the spin is conserved")


def neighbours(problem: Problem, ulps: float = ULPS) -> Iterator[tuple[str, Problem]]:
    """A few ulp more in a number: what was at a pole or symmetric, exactly, no longer is."""
    with mp.workdps(DIGITS):
        nudge = mpf(ulps * EPS)
        tilted = product(problem.q_world_axes, normalised((1, nudge / 2, nudge / 2, 0)))
        yield "attitude", replace(problem, q_world_axes=tilted)
        first, second, third = problem.moments
        yield "moment", replace(problem, moments=(first * (1 + nudge), second, third))
        w1, w2, w3 = problem.omega_axes
        aside = nudge * norm(problem.omega_axes)
        yield "omega", replace(problem, omega_axes=(w1 + aside, w2, w3 + aside))
        x, y, z = problem.lever_axes
        if length := norm(problem.lever_axes):
            yield "lever", replace(problem, lever_axes=(x + nudge * length, y, z))


def nudged_out_of_symmetry(problem: Problem, k: int, size: mpf) -> Problem:
    """As `nudged`, but every moment and every component of the lever is changed on its own."""
    with mp.workdps(DIGITS):
        first, second, third = (
            moment * (1 + size * signs[k])
            for moment, signs in zip(problem.moments, SIGNS_OF_MOMENTS, strict=True)
        )
        length = norm(problem.lever_axes)
        x, y, z = (
            component + size * length * signs[k]
            for component, signs in zip(problem.lever_axes, SIGNS_OF_LEVER, strict=True)
        )
        return replace(
            nudged(problem, k, size), moments=(first, second, third), lever_axes=(x, y, z)
        )


@cache
def bounds_of_a_change(name: str) -> Errors:
    """What a few ulp in any numbers do, symmetries among them: of both motions, errors included."""
    scenario, solution = solved(name)
    exact_motion, problem = within_reach(name), rotational_problem(scenario)

    def neighbour_of(nudged_problem: Problem) -> Trajectory:
        by_ode = integrate(nudged_problem, exact_motion.t, CHECK_ORDERS)
        return motion(scenario, nudged_problem, exact_motion.t, by_ode)

    whole = conditioning(scenario, problem, exact_motion, neighbour_of, nudged_out_of_symmetry)
    return Errors(
        **{
            signal: CANCELLED * ULPS * value + 2 * getattr(solution.uncertainty, signal)
            for signal, value in whole
        }
    )


def moved_too_far(name: str, ulps: float) -> list[str]:
    """Numbers whose change moves the motion further than a few ulp should."""
    scenario, exact_motion, bounds = solved(name)[0], within_reach(name), bounds_of_a_change(name)
    problem = rotational_problem(scenario)
    return [
        changed
        for changed, neighbour in neighbours(problem, ulps)
        if beyond(
            errors_between(
                scenario,
                motion(scenario, neighbour, exact_motion.t, states(neighbour, exact_motion.t)),
                exact_motion,
            ),
            bounds,
        )
    ]


@every_scene
def test_a_few_ulp_move_it_no_further_than_its_conditioning_says(name):
    assert moved_too_far(name, ULPS) == []


@each_case("name", ["through-the-upright", "t-handle", "sphere", "tiring-top"])
def test_a_few_thousand_do(name):
    assert moved_too_far(name, 1e3 * ULPS)
