"""Free bodies: which axis is stable, how fast they wobble and tumble."""

import math

import numpy as np
import pytest
from library_scenes import library_scene
from scipy.special import ellipk
from spincheck.reference.cross_check import cross_check
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.stability import (
    perturbation_rate_squared,
    separatrix_distance,
    tumbling_period,
)
from top_scenes import ASYMMETRIC, scene

EPS = np.finfo(float).eps
#: Worked out in extended precision and rounded once; the comparison rounds too.
ROUNDED = 4 * EPS
#: 3, 4, 6 kg m², the body of the scene ASYMMETRIC.
MOMENTS = (3.0, 4.0, 6.0)


@pytest.mark.parametrize(
    ("moments", "axis", "by_hand"),
    [
        (MOMENTS, 0, -4 * 1 * 3 / (4 * 6)),
        (MOMENTS, 1, 4 * 1 * 2 / (3 * 6)),
        (MOMENTS, 2, -4 * 3 * 2 / (3 * 4)),
        ((2.0, 2.0, 3.0), 0, 0),
    ],
    ids=["smallest", "middle", "largest", "one of two equal"],
)
def test_perturbations_grow_about_the_middle_axis_only(moments, axis, by_hand):
    """ω² (I_k − I_i)(I_j − I_k)/(I_i I_j) at ω = 2 rad/s."""
    found = perturbation_rate_squared(moments, axis, 2.0)
    assert found == pytest.approx(by_hand, rel=ROUNDED, abs=0)


def start_near(axis, offset):
    omega = [offset, offset, offset]
    omega[axis] = 1.0
    return f"euler_zyz_deg = [0, 0, 0]\nomega_body = {omega}"


def test_near_the_middle_axis_small_deviations_grow_at_that_rate():
    """cosh λt and sinh λt from the linear equations, against an integrator of the full ones."""
    offset, duration = 1e-6, 5.0
    scenario = scene(ASYMMETRIC, start_near(1, offset), "", f"duration = {duration}\nsamples = 2")
    end = cross_check(scenario, scenario.times).trajectory.omega_body[-1]
    rate = math.sqrt(perturbation_rate_squared(MOMENTS, 1, 1.0))
    # ω1' = (I2 − I3)/I1 ω2 ω3 with ω2 = 1, so ω1 = δ (cosh λt + (I2 − I3)/(I1 λ) sinh λt).
    grown = math.cosh(rate * duration) + (4 - 6) / (3 * rate) * math.sinh(rate * duration)
    # What the linear equations leave out is of relative order δ² e^{2λt} λt.
    left_out = (offset * math.exp(rate * duration)) ** 2 * rate * duration
    bound = left_out + 1e-13 * duration / offset  # and the integrator's own error, over δ
    assert end[0] == pytest.approx(offset * grown, rel=bound)
    assert end[0] != pytest.approx(offset * math.cos(rate * duration), rel=1e3 * bound)


@pytest.mark.parametrize("axis", [0, 2], ids=["smallest", "largest"])
def test_near_an_extreme_axis_the_period_is_that_of_small_wobbles(axis):
    offset = 1e-6
    omega = [offset] * 3
    omega[axis] = 1.0
    wobble = math.tau / math.sqrt(-perturbation_rate_squared(MOMENTS, axis, 1.0))
    # Amplitude enters squared, with a factor of order (I_max/I_min)².
    assert tumbling_period(MOMENTS, omega) == pytest.approx(wobble, rel=4 * offset**2 + ROUNDED)


def test_the_period_is_that_of_the_jacobi_functions():
    """DETEST problem B5 (Hull et al., 1972): y = (sn, cn, dn)(t | 0.51)."""
    problem = rotational_problem(library_scene("detest-b5"))
    period = tumbling_period(problem.moments, problem.omega_axes)
    assert period == pytest.approx(4 * ellipk(0.51), rel=ROUNDED)
    assert period != pytest.approx(4 * ellipk(0.51**2), rel=1e6 * ROUNDED)


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 1, 0)])
def test_the_order_of_the_axes_does_not_matter(order):
    omega = (0.3, 1.0, 0.2)
    turned = [MOMENTS[k] for k in order], [omega[k] for k in order]
    period = tumbling_period(MOMENTS, omega)
    assert tumbling_period(*turned) == pytest.approx(period, rel=ROUNDED)


#: I1 (I2 − I1) ω1² = 3 ω1² and I3 (I3 − I2) ω3² = 12 ω3² are equal: L² = 2 E I2.
ON_THE_SEPARATRIX = (2.0, 0.7, 1.0)


@pytest.mark.parametrize(
    ("omega", "by_hand"),
    [
        ((0.0, 0.0, 1.0), (36 - 24) / 36),
        ((1.0, 0.0, 0.0), (9 - 12) / 9),
        (ON_THE_SEPARATRIX, 0),
        ((0.0, 1.0, 0.0), 0),
        ((0.0, 0.0, 0.0), 0),
    ],
    ids=["largest", "smallest", "separatrix", "middle", "rest"],
)
def test_the_side_of_the_separatrix_tells_the_axis_circled(omega, by_hand):
    assert separatrix_distance(MOMENTS, omega) == pytest.approx(by_hand, rel=ROUNDED, abs=0)


@pytest.mark.parametrize("above", [1 + EPS, 1 - EPS], ids=["above", "below"])
def test_one_ulp_off_the_separatrix_is_seen(above):
    """Formed from E and L² in double precision the difference would be rounding alone."""
    omega = (2.0, 0.7, above)
    # dD = 2 I3 (I3 − I2) ω3 dω3 over L².
    by_hand = 24 * (above - 1) / (6**2 + 2.8**2 + 6**2)
    assert separatrix_distance(MOMENTS, omega) == pytest.approx(by_hand, rel=1e-14)
    assert 20 < tumbling_period(MOMENTS, omega) < math.inf


@pytest.mark.parametrize(
    ("moments", "omega", "period"),
    [
        (MOMENTS, ON_THE_SEPARATRIX, math.inf),
        (MOMENTS, (0.0, 1.0, 0.0), math.inf),
        (MOMENTS, (0.0, 0.0, 0.0), None),
        ((2.0, 2.0, 3.0), (0.1, 0.2, 0.3), None),
        ((3.0, 2.0, 2.0), (0.1, 0.2, 0.3), None),
        ((1.0, 1.0, 1.0), (0.1, 0.2, 0.3), None),
    ],
)
def test_what_never_flips_and_what_does_not_tumble_has_no_period(moments, omega, period):
    assert tumbling_period(moments, omega) == period
