"""Searches for changes: pairs where they are linear, and stepwise on more and more of the data."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pytest
from planted_motions import case
from spincheck.reports.harness.explaining.fit import Data, Linear, Trial, of_pairs
from spincheck.reports.harness.explaining.hypothesis import Change, Hypothesis, as_it_is
from spincheck.reports.harness.recorded.files.exact_at import exact_at
from spincheck.reports.harness.recorded.fits.log import FEWEST, MOST, log_of
from spincheck.reports.harness.recorded.fits.stepwise import Stepwise

CHANCE = np.random.default_rng(4)


def test_what_pairs_leave_is_what_each_leaves_that_is_fitted() -> None:
    unchanged = CHANCE.normal(size=60)
    each = [
        Linear(unchanged + CHANCE.normal(size=60), CHANCE.normal(size=(60, count)))
        for count in (0, 0, 1, 1, 3, 2)
    ]
    # One that is seen no better than a multiple of another one.
    each.append(
        Linear(unchanged, np.hstack([each[4].jacobian[:, :1], 2 * each[4].jacobian[:, :1]]))
    )
    found = {
        (int(i), int(j)): one
        for left, pairs in of_pairs(each, unchanged)
        for (i, j), one in zip(pairs, left, strict=True)
    }
    assert set(found) == set(combinations(range(len(each)), 2))
    for (i, j), left in found.items():
        jacobian = np.hstack([each[i].jacobian, each[j].jacobian])
        off = each[i].residuals + each[j].residuals - unchanged
        best = np.linalg.lstsq(jacobian, off, rcond=1e-6)[0] if jacobian.size else np.empty(0)
        assert left == pytest.approx(np.mean((off - jacobian @ best) ** 2), rel=1e-9)


@dataclass(frozen=True, eq=False)
class Parabola(Data):
    """Samples of 1, x and x² with the factors `step` - 1, `velocity` - 1 and `braking`."""

    wanted: np.ndarray

    @property
    def beginnings(self) -> Sequence[Data]:
        return (*(replace(self, wanted=self.wanted[:count]) for count in (4, 16)), self)

    def deviations(self, hypotheses: Hypothesis) -> np.ndarray:
        x = np.arange(len(self.wanted))
        h = hypotheses
        factors = np.stack([h.step - 1, h.velocity - 1, h.braking], axis=1)
        return factors @ np.array([x**0, x, x**2]) - self.wanted


CONSTANT = Change("step", lambda h, n: h.of(step=h.step + n[:, 0]), np.ones(1))
SLOPE = Change("velocity", lambda h, n: h.of(velocity=h.velocity + n[:, 0]), np.ones(1))
SQUARE = Change("braking", lambda h, n: h.of(braking=h.braking + n[:, 0]), np.ones(1))
EVERY = Change(
    "all three",
    lambda h, n: h.of(
        step=h.step + n[:, 0], velocity=h.velocity + n[:, 1], braking=h.braking + n[:, 2]
    ),
    np.ones(3),
)
BASE = as_it_is(case(1).scenario)
NOISE = np.random.default_rng(2).normal(size=64)
SQUARES = 0.5 * np.arange(64.0) ** 2


def searched(wanted: np.ndarray) -> Stepwise:
    return Stepwise(Parabola(BASE, wanted), (EVERY, CONSTANT, SLOPE, SQUARE))


def test_the_changes_that_more_and_more_of_the_data_call_for_are_found() -> None:
    assert searched(NOISE).from_first_samples(4).changes == ()
    found = searched(SQUARES + NOISE).from_first_samples(4)
    assert found.changes == (SQUARE,)
    assert found.parameters == pytest.approx(0.5, rel=0.01)
    both = replace(
        searched(SQUARES + 20 + NOISE), changes=(CONSTANT, SLOPE, SQUARE)
    ).from_first_samples(4)
    assert set(both.changes) == {CONSTANT, SQUARE}
    # What it begins with is left out at the end.
    assert searched(SQUARES + NOISE).from_first_samples(4, (SLOPE,)).changes == (SQUARE,)
    # No parameters mean anything where none explains the first samples.
    beyond = searched(
        SQUARES + 1e6 * (-1.0) ** np.arange(64) * (np.arange(64) < 4)
    ).from_first_samples(4)
    assert beyond.explains_nothing
    assert len(beyond.residuals) == 64


def test_a_change_with_fewer_parameters_takes_the_place_of_general_ones() -> None:
    search = searched(SQUARES + NOISE)
    for changes in (EVERY,), (CONSTANT, EVERY):
        general = Trial(search.data, changes).fit()
        assert search.simplified(general, SLOPE).changes == (SQUARE,)
    needed = searched(SQUARES + np.arange(64.0) + 20 + NOISE)
    general = Trial(needed.data, (EVERY,)).fit()
    assert needed.simplified(general, SLOPE) is general
    assert search.simplified(Trial(search.data, (EVERY,)).fit(), EVERY).changes == (EVERY,)


@pytest.mark.parametrize("samples", [40, 1001])
def test_changes_of_a_long_log_are_searched_in_a_part_of_its_samples_first(samples: int) -> None:
    one = case(324, samples=samples)
    motion = exact_at(one.scenario, one.scenario.times).trajectory
    has = {"is_stated": True, "has_omega": True}
    *parts, whole = log_of(one.scenario, motion, motion, np.ones(2), **has).beginnings
    assert len(whole.t) == samples
    assert (parts[-1].t[-1] == motion.t[-1]) == (samples > MOST)
    for part in parts:
        assert part.t[0] == motion.t[0]
        assert FEWEST <= len(part.t) <= MOST
        assert (part.states == whole.states[np.isin(whole.t, part.t)]).all()


def test_a_regression_that_has_every_change_already_adds_none() -> None:
    data = Parabola(BASE, SQUARES)
    fit = Trial(data, (SQUARE,)).fit()
    assert Stepwise(data, (SQUARE,)).stepwise(fit, 4).changes == (SQUARE,)
