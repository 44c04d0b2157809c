"""Real bodies turn as observed: their printed periods come out of the printed moments and rates."""

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.reference import facts, solve
from spincheck.scenarios import Scenario

DAY = 86400.0
#: d, of Toutatis: rotation about its long axis and precession of that, and their uncertainty
#: (Zhao et al., arXiv:1504.02024; by radar 5.41 and 7.35: Hudson & Ostro, Science 270 (1995) 84).
ROTATION, PRECESSION, OBSERVED = 5.38, 7.40, 0.03
#: d, of a rigid Earth: Euler's period A/(C − A) (Goldstein, Poole & Safko, §5.6: about 306).
EULER, EULER_KNOWN = 304.0, 2.0
#: Relative, of a moment: what a digit misread would do.
MISREAD = 0.1


def tumbling_period(scenario: Scenario) -> float:
    (period,) = (fact.value for fact in facts(scenario) if fact.name == "tumbling period")
    return period


def mean_precession_period(scenario: Scenario, first_moment: float = 1.0) -> float:
    """2π over the mean rate at which e3 goes round L (Landau & Lifshitz, Mechanics, eq. 37.15–17).

    φ' = |L| (I1 ω1² + I2 ω2²)/(I1² ω1² + I2² ω2²), averaged over a period of ω, which is smooth
    and periodic: the mean of equidistant samples is exact.
    """
    times = np.linspace(0.0, tumbling_period(scenario), 257)[:-1]
    omega = solve(scenario, times).trajectory.omega_body
    inertia = scenario.body.inertia_com.diagonal() * [first_moment, 1.0, 1.0]
    L = inertia * omega
    rates = (L * omega)[:, :2].sum(axis=1) / (L[:, :2] ** 2).sum(axis=1)
    return float(2 * np.pi / np.mean(np.linalg.norm(L, axis=1) * rates))


def test_toutatis_turns_about_its_long_axis_as_observed() -> None:
    assert abs(tumbling_period(library_scene("toutatis")) / DAY - ROTATION) <= OBSERVED


def test_the_long_axis_of_toutatis_precesses_as_observed() -> None:
    toutatis = library_scene("toutatis")
    assert abs(mean_precession_period(toutatis) / DAY - PRECESSION) <= OBSERVED
    misread = mean_precession_period(toutatis, first_moment=1 + MISREAD)
    assert abs(misread / DAY - PRECESSION) > OBSERVED


def test_the_pole_of_a_rigid_earth_goes_round_in_eulers_period() -> None:
    assert abs(tumbling_period(library_scene("earth-polar-motion")) / DAY - EULER) <= EULER_KNOWN


def test_the_wobble_of_the_earth_is_all_but_a_circle() -> None:
    """A and B differ in the fifth digit, which makes the path of the pole an ellipse by 0.4 %."""
    scenario = library_scene("earth-polar-motion")
    low, middle, high = scenario.body.principal_moments
    omega = solve(scenario, scenario.times).trajectory.omega_body
    ratio = np.abs(omega[:, 1]).max() / np.abs(omega[:, 0]).max()
    wanted = np.sqrt(low * (high - low) / (middle * (high - middle)))
    assert ratio == pytest.approx(wanted, rel=1e-3)  # 400 samples miss the extremes by less
    assert ratio != pytest.approx(1 / wanted, rel=1e-3)
