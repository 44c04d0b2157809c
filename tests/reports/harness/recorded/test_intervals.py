"""How many numbers of intervals count as one, and when a motion is beyond its method's error."""

from dataclasses import replace

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from scipy.stats import chi2
from spincheck.reports.harness.explaining.hypothesis import Hypothesis
from spincheck.reports.harness.explaining.search import SIGNIFICANCE
from spincheck.reports.harness.recorded.fits.log import log_of
from spincheck.reports.harness.recorded.fits.other_physics import Physics
from spincheck.reports.harness.recorded.samples.intervals import Intervals
from spincheck.scenarios import Trajectory

pytestmark = pytest.mark.slow

ONE = case(161)
ARRAYS = exactly(ONE, rates_of(ONE))
NOTHING = np.zeros((len(ARRAYS["t"]), 3))
MOTION = Trajectory(ARRAYS["t"], ARRAYS["q"], ARRAYS["omega"], NOTHING, NOTHING, NOTHING[:, :0])
#: Parts of variance that are a method's, and a size of errors, rad and rad/s.
PARTS, SIZE = (0.0, 0.3, 1.0), 1e-3
#: A sum of squares this little below, or above, a bound.
BELOW, ABOVE = 0.999, 1.001


def physics() -> Physics:
    return Physics(ONE.scenario, MOTION, MOTION, None, 1, np.array([SIZE, SIZE]))


def of_parts(part: float, off: float = 0.0) -> Intervals:
    """Intervals whose errors have a size of `SIZE`, each number off by so many of it."""
    data = physics().intervals
    assert data is not None
    noise, method = np.sqrt(1 - part) * SIZE, np.sqrt(part) * SIZE
    made = data.ends.copy()
    # The attitude keeps its error, as ω has a number for each of its own, times √2.
    made[:, 4:] += np.sqrt(2) * off * SIZE
    return replace(
        data, ends=made, noise=np.full(2, noise), method=np.full_like(data.method, method)
    )


@pytest.mark.parametrize("part", PARTS)
def test_numbers_count_as_one_as_far_as_they_are_a_methods_error(part: float) -> None:
    data = of_parts(part)
    count = data.scale.size
    assert data.correlated == pytest.approx((1 - part) * 1 + part * count)
    before = np.ones(data.scale.shape)
    assert data.chi2_decrease(before, 0 * before) == pytest.approx(count / data.correlated)


@pytest.mark.parametrize("part", PARTS)
def test_as_many_numbers_are_independent_as_do_not_count_as_one(part: float) -> None:
    """Of noise all numbers are, and of a method's error one is."""
    one = physics()
    assert one.search is not None
    level = SIGNIFICANCE / len(one.search.changes)
    count = of_parts(part).scale.size
    independent = count / ((1 - part) + part * count)
    bound = chi2.isf(level, independent) / independent
    for factor, is_beyond in ((BELOW, False), (ABOVE, True)):
        other = physics()
        vars(other)["intervals"] = of_parts(part, off=np.sqrt(factor * bound))
        assert other.is_beyond == is_beyond


def test_residuals_of_far_too_high_and_low_gains_are_finite_and_warn_of_nothing() -> None:
    has = {"is_stated": True, "has_omega": True}
    log = log_of(ONE.scenario, MOTION, MOTION, np.full(2, SIZE), **has)
    mixed = np.array([[1.0, -1, 0], [1, 1, 1], [0, 1, -1]])
    for data in log, of_parts(0.0):
        gains = [gain * mixed for gain in (1e306, 1e-306)]
        pushed = data.base.of(torque=np.ones(3)).repeated(2).of(read=gains)
        as_it_is, *off = data.residuals(Hypothesis.joined([data.base[None], pushed]))
        assert np.abs(as_it_is).max() < 1
        assert np.isfinite(off).all()
        assert np.abs(off).max() > 1
