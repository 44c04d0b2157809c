"""The heavy symmetric top by its constants: against hand-solved cases and an ODE."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import quad
from scipy.special import ellipk
from spincheck.reference import heavy_symmetric_top as lagrangian
from spincheck.reference.cross_check import RELATIVE_TOLERANCE, cross_check
from spincheck.reference.heavy_symmetric_top import HeavySymmetricTop, heavy_symmetric_top
from spincheck.reference.rotational_problem import rotational_problem
from top_scenes import ASYMMETRIC, GRAVITY, HEAVY, PIVOT, TOP, TOP_ALONG_X, TOP_ALONG_Y, scene

EPS = np.finfo(float).eps
#: Values worked out in 60 digits or more are rounded once; the comparison itself rounds too.
ROUNDED = 4 * EPS

LOOPS = "euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [-1.0, 0.0, 20.0]"
CUSPS = "euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [0.0, 0.0, 20.0]"
WAVES = "euler_zyz_deg = [10, 60, 20]\neuler_zyz_rates = [1.0, 0.5, 20.0]"
STARTS = {"loops": LOOPS, "cusps": CUSPS, "waves": WAVES}


def top_of(start=WAVES, body=TOP, effects=HEAVY) -> HeavySymmetricTop:
    top = heavy_symmetric_top(rotational_problem(scene(body=body, start=start, effects=effects)))
    assert top is not None
    return top


def upright(spin: mpf) -> HeavySymmetricTop:
    """TOP standing upright with I3 ω3 = spin: I1 = 2, M g l = 10, threshold √80."""
    energy = spin**2 / 2 + 10
    return HeavySymmetricTop(mpf(2), mpf(1), mpf(10), spin, spin, energy, mpf(1))


# --- what the top of a scene is


def same(one: HeavySymmetricTop, other: HeavySymmetricTop) -> bool:
    names = ("I1", "I3", "kappa", "p_alpha", "p_gamma", "energy", "cos_beta")
    return all(abs(getattr(one, name) - getattr(other, name)) < mpf(10) ** -40 for name in names)


@pytest.mark.parametrize(
    ("body", "omega"),
    [(TOP_ALONG_X, "[20.0, 0.3, -0.2]"), (TOP_ALONG_Y, "[-0.2, 20.0, 0.3]")],
    ids=["along x", "along y"],
)
def test_the_axis_may_be_any_principal_axis(body, omega):
    """Turned cyclically with all that acts on it, the top is the same top."""
    start = "rotation_vector_deg = [0.0, 0.0, 0.0]\nomega_body = {}"
    gravity = "[effects.gravity]\nacceleration = {}"
    along_z = f"{PIVOT}\n{gravity.format('[6.0, 0.0, -8.0]')}"
    along = {TOP_ALONG_X: "[-8.0, 6.0, 0.0]", TOP_ALONG_Y: "[0.0, -8.0, 6.0]"}[body]
    turned = top_of(start.format(omega), body, f"{PIVOT}\n{gravity.format(along)}")
    assert same(turned, top_of(start.format("[0.3, -0.2, 20.0]"), TOP, along_z))
    assert not same(turned, top_of(start.format("[0.3, -0.2, 20.0]"), TOP))


def test_gravity_may_point_anywhere():
    """A top that lies along x in a gravity along −x is upright."""
    effects = f"{PIVOT}\n[effects.gravity]\nacceleration = [-10.0, 0.0, 0.0]"
    start = "rotation_vector_deg = [0.0, 90.0, 0.0]\nomega_body = [0.0, 0.0, 3.0]"
    assert same(top_of(start, TOP, effects), upright(mpf(3)))


def test_the_axis_points_from_the_pivot_to_the_com():
    """With the com on the negative body axis, the upright body is a hanging top."""
    hanging = TOP.replace("0.5]", "-0.5]")
    top = top_of("euler_zyz_deg = [0, 0, 0]\nomega_body = [0.0, 0.0, 3.0]", hanging)
    assert (top.cos_beta, top.p_gamma, top.p_alpha) == (-1, -3, 3)


def test_a_sphere_is_symmetric_about_the_line_to_its_com():
    """A body held at a point off every axis: I = 2 about all axes through the pivot."""
    ball = """
mass = 1.0
inertia = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
inertia_about = "origin"
com = [0.3, 0.0, 0.4]
"""
    top = top_of("euler_zyz_deg = [0, 0, 0]\nomega_body = [3.0, 0.0, 4.0]", ball)
    assert float(top.p_gamma) == pytest.approx(2 * 5, rel=ROUNDED)
    assert float(top.cos_beta) == pytest.approx(0.8, rel=ROUNDED)


@pytest.mark.parametrize(
    ("body", "effects"),
    [
        (ASYMMETRIC + "com = [0.0, 0.0, 0.5]", HEAVY),
        (TOP.replace("[0.0, 0.0, 0.5]", "[1e-20, 0.0, 0.5]"), HEAVY),
        (TOP, PIVOT),
        (TOP, GRAVITY),
        (TOP, f"{PIVOT}\n[effects.gravity]\nacceleration = [0.0, 0.0, 0.0]"),
        (TOP.replace("0.5]", "0.0]"), HEAVY),
    ],
    ids=["asymmetric", "com off the axis", "no gravity", "no pivot", "no weight", "balanced"],
)
def test_other_bodies_are_no_heavy_symmetric_tops(body, effects):
    assert (
        heavy_symmetric_top(rotational_problem(scene(body=body, start=WAVES, effects=effects)))
        is None
    )


# --- V_eff and turning points


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_nutation_energy_and_v_eff_make_up_e_prime_along_the_motion(start):
    """½ I1 β̇² + V_eff(β) = E', on the path found by an integrator that knows nothing of either."""
    scenario = scene(start=start)
    opinion = cross_check(scenario, scenario.times)
    top = top_of(start)
    bound = opinion.steps * RELATIVE_TOLERANCE
    assert defect_of(top, opinion.trajectory) < bound
    for wrong in (replace(top, I1=top.I3), replace(top, p_gamma=-top.p_gamma)):
        assert defect_of(wrong, opinion.trajectory) > 1e6 * bound


def defect_of(top, path):
    """Largest |½ I1 β̇² + V_eff − E'| along a path, over the energy."""
    axis = path.R_world_body.apply([0.0, 0.0, 1.0])
    omega = path.R_world_body.apply(np.array(path.omega_body))
    beta = np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    beta_rate = np.cross(omega, axis)[:, 2] / -np.sin(beta)
    total = float(top.I1) * beta_rate**2 / 2 + lagrangian.effective_potential(top, beta)
    return np.abs(total - float(top.E_prime)).max() / float(top.energy)


@pytest.mark.parametrize(
    ("top", "values"),
    [(upright(mpf(3)), [10.0, np.inf]), (top_of(), [np.inf, np.inf])],
    ids=["that the momenta allow", "otherwise"],
)
def test_v_eff_is_finite_at_no_pole_but_one(top, values):
    assert list(lagrangian.effective_potential(top, np.array([0.0, np.pi]))) == values


def test_v_eff_does_not_cancel_near_a_pole():
    """V_eff = ½ (p tan β/2)²/I1 + κ cos β where p_α = p_γ; the textbook's quotient is all noise."""
    beta = 1e-7
    by_hand = (3 * math.tan(beta / 2)) ** 2 / 4
    bent = lagrangian.effective_potential(replace(upright(mpf(3)), kappa=mpf(0)), np.array([beta]))
    assert bent[0] == pytest.approx(by_hand, rel=ROUNDED, abs=0)
    textbook = (3 - 3 * math.cos(beta)) ** 2 / (4 * math.sin(beta) ** 2)
    assert textbook != pytest.approx(by_hand, rel=1e6 * ROUNDED, abs=0)


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_at_the_turning_points_v_eff_is_e_prime(start):
    top = top_of(start)
    bounds = np.array(lagrangian.nutation_bounds(top))
    scale = abs(float(top.p_alpha)) ** 2
    error = lagrangian.effective_potential(top, bounds) - float(top.E_prime)
    assert np.abs(error).max() < ROUNDED * scale
    error = lagrangian.effective_potential(top, bounds + 1e-3) - float(top.E_prime)
    assert np.abs(error).min() > 1e6 * ROUNDED * scale


def test_a_top_let_go_turns_back_where_it_was_let_go():
    """Cusps: the root is double precision's bane, np.roots finds it to 1e-8 only."""
    low, high = lagrangian.nutation_bounds(top_of(CUSPS))
    assert low == pytest.approx(math.pi / 3, rel=ROUNDED)
    # cos β2 = λ − √(1 − 2 λ cos β1 + λ²) with λ = p_γ²/4 κ I1.
    lam = float(top_of(CUSPS).p_gamma) ** 2 / 80
    by_hand = lam - math.sqrt(1 - 2 * lam * 0.5 + lam**2)
    assert math.cos(high) == pytest.approx(by_hand, rel=100 * ROUNDED)


def test_a_pendulum_swings_through_the_bottom():
    low, high = lagrangian.nutation_bounds(
        top_of("euler_zyz_deg = [0, 50, 0]\nomega_body = [0.0, 0.0, 0.0]")
    )
    assert (low, high) == (pytest.approx(math.radians(50), rel=ROUNDED), math.pi)


# --- periods and mean rates


def test_a_pendulum_passes_the_bottom_twice_in_its_period():
    """2 K(sin θ/2)/√(κ/I1), θ the amplitude from the bottom, 130 deg: half the swing's 4 K/ω0."""
    top = top_of("euler_zyz_deg = [0, 50, 0]\nomega_body = [0.0, 0.0, 0.0]")
    by_hand = 2 * ellipk(math.sin(math.radians(130) / 2) ** 2) / math.sqrt(10 / 2)
    assert lagrangian.nutation_period(top) == pytest.approx(by_hand, rel=ROUNDED)


def quadrature(top, of):
    """∮ of(u) dt over a nutation: u = mean + half-width sin s takes the square roots away."""
    u1, u2, u3 = (float(u) for u in top.roots)
    speed = math.sqrt(2 * float(top.kappa) / float(top.I1))

    def integrand(s):
        u = (u1 + u2) / 2 + (u2 - u1) / 2 * math.sin(s)
        return of(u) / (speed * math.sqrt(u3 - u))

    return 2 * quad(integrand, -math.pi / 2, math.pi / 2, epsrel=1e-13, epsabs=0)[0]


#: quad is asked for 1e-13; the three roots it is given are rounded.
QUADRATURE = 2e-13


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_the_nutation_period_is_the_time_between_turning_points(start):
    top = top_of(start)
    period = lagrangian.nutation_period(top)
    assert period == pytest.approx(quadrature(top, lambda _: 1.0), rel=QUADRATURE)


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_the_mean_precession_rate_is_the_average_of_alpha_dot(start):
    top = top_of(start)

    def alpha_rate(u):
        return float(top.p_alpha - top.p_gamma * u) / (float(top.I1) * (1 - u * u))

    mean = quadrature(top, alpha_rate) / quadrature(top, lambda _: 1.0)
    # Where loops turn back the two halves cancel in part.
    assert lagrangian.mean_precession_rate(top) == pytest.approx(mean, rel=10 * QUADRATURE)


def test_a_top_that_passes_the_vertical_has_no_mean_precession_rate():
    through_the_top = replace(upright(mpf(3)), energy=upright(mpf(3)).energy + 1)
    assert lagrangian.mean_precession_rate(through_the_top) is None


# --- steady precession


@pytest.mark.parametrize(
    ("p_gamma", "cos_beta", "rates"),
    [(-7, "0.5", (-2, -5)), (10**9, "0.5", (1e-8, 1e9)), (5, "0", (2,)), (0, "-0.2", (5, -5))],
    ids=["the other way", "fast: no digits are lost of the slow rate", "level", "no spin"],
)
def test_steady_rates_are_those_worked_out_by_hand(p_gamma, cos_beta, rates):
    """I1 Ω² cos β − p_γ Ω + κ = 0 with I1 = 2, κ = 10; of 7 and ½: `test_facts`."""
    found = lagrangian.steady_precession_rates(upright(mpf(p_gamma)), mpf(cos_beta))
    assert found == pytest.approx(rates, rel=ROUNDED, abs=0)


@pytest.mark.parametrize(
    ("square", "rates"), [("39.999", 0), ("40", 1), ("40.001", 2)], ids=["less", "equal", "more"]
)
def test_steady_precession_needs_the_discriminant(square, rates):
    """At cos β = ½: p_γ² ≥ 4 κ I1 cos β = 40."""
    with mp.workdps(60):
        top = upright(mp.sqrt(mpf(square)))
    assert len(lagrangian.steady_precession_rates(top, mpf("0.5"))) == rates


@pytest.mark.parametrize("which", [0, 1], ids=["slow", "fast"])
def test_started_at_a_steady_rate_it_does_not_nutate(which):
    """β = 60 deg, γ̇ = p_γ/I3 − Ω cos β: the double root of the cubic is found to all digits."""
    rate = (2.0, 5.0)[which]
    spin = 7.0 - rate / 2
    top = top_of(f"euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [{rate}, 0.0, {spin}]")
    low, high = lagrangian.nutation_bounds(top)
    assert (low, high) == pytest.approx((math.pi / 3, math.pi / 3), rel=ROUNDED)
    assert lagrangian.mean_precession_rate(top) == pytest.approx(rate, rel=ROUNDED)
    assert lagrangian.steady_angle(top) == pytest.approx(math.pi / 3, rel=ROUNDED)


def test_small_nutations_have_the_period_of_small_nutations():
    """About steady precession at Ω = 2: ω² = (p_γ² − 4 κ I1 cos β)/I1² + Ω² sin² β = 9/4 + 3."""
    top = top_of("euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [2.0, 0.0, 6.0]")
    assert lagrangian.nutation_period(top) == pytest.approx(math.tau / math.sqrt(5.25), rel=ROUNDED)


def test_the_bottom_of_v_eff_is_its_lowest_point():
    top = top_of(WAVES)
    bottom = lagrangian.steady_angle(top)
    around = lagrangian.effective_potential(top, bottom + np.array([-1e-3, 0.0, 1e-3]))
    assert around[1] < min(around[0], around[2])
    # A parabola there: both sides rise alike, to the third order of the offset.
    curvature = float(top.I1) * lagrangian.small_nutation_frequency(top) ** 2
    rise = (around[0] + around[2] - 2 * around[1]) / 1e-6
    assert rise == pytest.approx(curvature, rel=1e-5)


# --- sleeping


@pytest.mark.parametrize("spin", [9, 20], ids=["just above the threshold", "far above"])
def test_a_sleeping_top_stays_upright(spin):
    assert lagrangian.nutation_bounds(upright(mpf(spin))) == (0.0, 0.0)


def test_a_slow_upright_top_falls_to_where_its_energy_lets_it():
    """u1 = p²/2 κ I1 − 1, and never comes back: the period is infinite."""
    top = upright(mpf(6))
    assert lagrangian.nutation_bounds(top) == (0.0, pytest.approx(math.acos(-0.1), rel=ROUNDED))
    assert lagrangian.nutation_period(top) == math.inf


def test_a_sleeping_top_trembles_at_the_frequency_of_its_linear_equations():
    """cos β oscillates at √(p² − 4 κ I1)/I1, twice the rate at which the axis does (Arnold §31)."""
    top = upright(mpf(12))
    assert lagrangian.small_nutation_frequency(top) == pytest.approx(4.0, rel=ROUNDED)
