"""Many changes are weighed at once: pairs where they are linear, trials on more and more data."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pytest
from planted_motions import case
from spincheck.reports.harness.explaining.fit import Data, Linear, Trial, of_pairs, race
from spincheck.reports.harness.explaining.hypothesis import Change, Hypothesis, as_it_is

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
class Line(Data):
    """Samples of a line in `step`, of which ever more count."""

    wanted: np.ndarray

    @property
    def parts(self) -> Sequence[int | None]:
        return (4, 16, None)

    def deviations(
        self, hypotheses: Sequence[Hypothesis], samples: int | None = None
    ) -> np.ndarray:
        x = np.arange(len(self.wanted))
        made = np.stack([one.step - 1 + one.braking * x**2 for one in hypotheses])
        return (made - self.wanted)[:, :samples]


def trials(data: Data) -> list[Trial]:
    constant = Change("step", lambda h, n: h._replace(step=1 + n[0]), np.ones(1))
    growing = Change("braking", lambda h, n: h._replace(braking=n[0]), np.ones(1))
    return [Trial(data, (one,)) for one in (constant, growing)]


def test_a_trial_that_explains_less_of_more_data_is_left_out() -> None:
    base = as_it_is(case(1).scenario)
    noise = np.random.default_rng(2).normal(size=64)
    data = Line(base, 0.05 * np.arange(64.0) ** 2 + noise)
    (found,) = race(trials(data), 50.0)
    assert found.changes[0].kind == "braking"
    assert found.parameters == pytest.approx(0.05, rel=0.01)
    # What keeps near the best goes on, and all end where none explains a part.
    assert len(race(trials(Line(base, noise)), 50.0)) == 2
    assert race(trials(Line(base, 1e3 * (-1.0) ** np.arange(64))), 50.0) == []
    assert race([], 50.0) == []
