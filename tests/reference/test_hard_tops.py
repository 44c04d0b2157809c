"""Tops of the library stand exactly where they say: at poles, thresholds and separatrices.

From each file's doubles, in sixty digits; a neighbour by a billionth in the spin stands elsewhere.
"""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from mpmath import mp, mpf
from spincheck.reference import solve
from spincheck.reference.heavy_symmetric_top import (
    HeavySymmetricTop,
    heavy_symmetric_top,
    nutation_bounds,
    steady_precession_rates,
)
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.symmetry import equal
from spincheck.scenarios.exact import DIGITS

EPS = float(np.finfo(float).eps)
#: Of the spin: what a scene that is exact must notice.
NUDGE = mpf(10) ** -9


def start(name: str, spun_by: mpf = 0) -> HeavySymmetricTop:
    """The top of a scene at t = 0, its body turning faster by so much of its rate."""
    problem = rotational_problem(library_scene(name))
    with mp.workdps(DIGITS):
        omega = tuple(w * (1 + spun_by) for w in problem.omega_axes)
        top = heavy_symmetric_top(replace(problem, omega_axes=omega))
    assert top is not None
    return top


def to_threshold(top: HeavySymmetricTop) -> float:
    """p_γ² over 4 M g l I1, less one; exactly zero at the threshold of sleep."""
    with mp.workdps(DIGITS):
        threshold = 4 * top.kappa * top.I1
        return 0.0 if equal(top.p_gamma**2, threshold) else float(top.p_gamma**2 / threshold - 1)


def over_the_top(top: HeavySymmetricTop) -> float:
    """Energy to spare on a pendulum's head, over M g l; exactly zero on the separatrix."""
    with mp.workdps(DIGITS):
        return 0.0 if equal(top.E_prime, top.kappa) else float(top.E_prime / top.kappa - 1)


@pytest.mark.parametrize(
    ("name", "pole", "bound"),
    [("through-the-upright", 1, 0), ("struck-upright", 1, 0), ("through-the-hanging", -1, 1)],
)
def test_a_top_goes_exactly_through_a_pole(name, pole, bound):
    top = start(name)
    assert top.p_alpha == pole * top.p_gamma
    assert nutation_bounds(top)[bound] == (0.0, np.pi)[bound]


@pytest.mark.parametrize("name", ["through-the-upright", "through-the-hanging"])
def test_with_another_spin_it_would_pass_beside(name):
    problem = rotational_problem(library_scene(name))
    w1, w2, w3 = problem.omega_axes
    with mp.workdps(DIGITS):
        top = heavy_symmetric_top(replace(problem, omega_axes=(w1, w2, w3 * (1 + NUDGE))))
    assert abs(top.p_alpha) != abs(top.p_gamma)


@pytest.mark.parametrize("exponent", [2, 4, 6])
def test_a_top_passes_the_upright_at_the_distance_of_its_name(exponent):
    nearest, _ = nutation_bounds(start(f"passes-the-upright-1e-{exponent}"))
    # γ̇, typed to an ulp of 20 rad/s, moves the axis by as many rad at 7 rad/s.
    assert abs(nearest - 10.0**-exponent) <= 20 * EPS
    assert abs(nearest - 10.0**-exponent * (1 + 1e-8)) > 20 * EPS


def test_a_top_is_asleep_exactly_at_the_threshold():
    assert to_threshold(start("asleep-at-the-threshold")) == 0
    assert to_threshold(start("nudged-at-the-threshold")) == 0
    assert to_threshold(start("asleep-at-the-threshold", NUDGE)) > 0


@pytest.mark.parametrize(("name", "side"), [("below", -1), ("above", 1)])
def test_its_neighbours_spin_a_millionth_slower_and_faster(name, side):
    ratio = to_threshold(start(f"nudged-{name}-the-threshold"))
    assert ratio == pytest.approx(side * 2e-6, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("on-the-separatrix", 0.0),
        ("just-over", 1e-10),
        ("just-under", -1e-10),
        ("over-by-a-millionth", 1e-6),
    ],
)
def test_pendulums_have_as_much_energy_to_spare_as_they_say(name, part):
    """(1 + part)² of 4 M g l kinetic, less what the climb of 2 M g l takes: 4 part."""
    spare = over_the_top(start(f"pendulum-{name}"))
    assert spare == pytest.approx(4 * part, rel=1e-5, abs=0)
    assert over_the_top(start(f"pendulum-{name}", NUDGE)) > spare


def test_slow_and_fast_precession_are_one_root():
    top = start("steady-at-the-double-root")
    assert top.roots[0] == pytest.approx(top.roots[1], rel=1e-30)
    assert steady_precession_rates(top, top.cos_beta) == (8.0,)
    assert len(steady_precession_rates(start("steady-at-the-double-root", NUDGE), mpf(0.5))) == 2


def test_a_creeping_precession_is_one_of_its_two_roots():
    top = start("steady-and-creeping")
    assert 0.25 in steady_precession_rates(top, top.cos_beta)
    nudged = start("steady-and-creeping", NUDGE)
    assert 0.25 not in steady_precession_rates(nudged, nudged.cos_beta)


@pytest.mark.parametrize(
    "name", ["let-go-with-little-spin", "cusps-too-small-to-see", "gyroscope-at-24000-rpm"]
)
def test_an_axis_let_go_at_rest_rises_no_higher(name):
    top = start(name)
    with mp.workdps(DIGITS):
        assert equal(top.roots[1], top.cos_beta, 1)
        assert equal(top.p_alpha, top.p_gamma * top.cos_beta, top.p_gamma)


def test_a_chaotic_top_outlives_its_reference():
    scenario = library_scene("chaos-beyond-the-horizon")
    solution = solve(scenario, scenario.times)
    assert solution.horizon is not None
    # By then one ulp in the start decides everything: no double says more.
    assert solution.conditioning.attitude > 1


STEADY = {"steady-precession-slow": 0, "steady-precession-fast": 1, "conical-pendulum": 0}


@pytest.mark.parametrize(("name", "which"), STEADY.items())
def test_steady_scenes_start_on_a_root_of_the_quadratic(name, which):
    _, precession, nutation, _ = zyz_start(name)
    assert nutation == 0
    for spun_by, is_steady in ((0, True), (NUDGE, False)):
        top = start(name, spun_by)
        rate = steady_precession_rates(top, top.cos_beta)[which]
        off = rate / (precession * (1 + float(spun_by))) - 1
        assert (abs(off) <= 8 * EPS) == is_steady


def test_slow_and_fast_precession_are_one_top_with_one_spin():
    slow, fast = (start(name) for name in ("steady-precession-slow", "steady-precession-fast"))
    assert (slow.I1, slow.I3, slow.kappa) == (fast.I1, fast.I3, fast.kappa)
    assert float(slow.p_gamma) == pytest.approx(float(fast.p_gamma), rel=8 * EPS)


@pytest.mark.parametrize(("name", "side"), [("sleeping-top", 1), ("waking-top", -1)])
def test_sleeping_and_waking_top_are_on_their_side_of_the_threshold(name, side):
    assert side * to_threshold(start(name)) > 0


@pytest.mark.parametrize(("name", "sign"), [("waves", 1), ("cusps", 0), ("loops", -1)])
def test_the_axis_draws_what_the_title_says(name, sign):
    """Of α̇ at the start, a turning point above, and below (Goldstein, eq. 5.57 to 5.62)."""
    _, precession, nutation, _ = zyz_start(f"nutation-{name}")
    assert (np.sign(precession), nutation) == (sign, 0)
    top = start(f"nutation-{name}")
    with mp.workdps(DIGITS):
        assert equal(top.roots[1], top.cos_beta, 1)
        assert top.p_alpha - top.p_gamma * top.roots[0] > 0


def zyz_start(name: str) -> tuple[float, float, float, float]:
    """The tilt, deg, and α̇, β̇ and γ̇, rad/s, as typed."""
    typed = library_scene(name).document.start
    return (typed.euler_zyz_deg[1], *typed.euler_zyz_rates)
