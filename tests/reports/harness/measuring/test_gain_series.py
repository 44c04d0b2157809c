"""The model of gains: of honest ones every tail is as probable as it says, and faults have none.

Honest gains are drawn from the model itself, with noise of known scale. Verified is that tails are
uniform, so that a level means what it says, and what is detected at which size. That engines' gains
are of this model is verified on engines, in `test_examine.py` and `test_false_passes.py`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import kstest
from spincheck.reports.harness.measuring import regression
from spincheck.reports.harness.measuring.gain_series import GainSeries, fitted
from spincheck.reports.harness.measuring.regression import LEAST, PREDICTED_FROM, TERMS
from spincheck.reports.results.evidence import LEVEL

EPS, EPS_SINGLE = (float(np.finfo(kind).eps) for kind in (np.float64, np.float32))
SEED = 7
#: s; each timestep is half of the one before, so many in double and single precision.
LONGEST, DOUBLE, SINGLE = 0.1, 11, 7
#: States of a method, methods of a sample, and decades by which amplitudes of states differ.
STATES, METHODS, DECADES = 16, 30, 1.0
#: Methods that a fault is planted in.
FAULTY = 5
#: Largest distance of two distributions by chance, times the root of the number: with a probability
#: of 2 exp(−2 · 2.5²) = 8e-6 (Smirnov, Ann. Math. Stat. 19 (1948) 279).
BY_CHANCE = 2.5
#: What the model may add to it, which estimates order, radius and amplitudes.
ESTIMATED = 0.02
#: The direction of a fault, askew to all axes.
ASKEW = np.array([0.6, -0.48, 0.64])


@dataclass(frozen=True, eq=False)
class Drawn:
    """Gains drawn from the model: timesteps, (J,), gains, (J, K, 3), and their noise, (J, K)."""

    timesteps: np.ndarray
    gains: np.ndarray
    noise: np.ndarray

    def fitted(self, level: float = LEVEL, noise: float = 1.0) -> GainSeries:
        """With the noise taken for so many times what it is."""
        return fitted(self.timesteps, self.gains, noise * self.noise, level)

    def with_fault(self, sizes: np.ndarray | float) -> "Drawn":
        """Each state gains as much besides, one size a timestep."""
        fault = np.broadcast_to(sizes, self.timesteps.shape)[:, None, None] * ASKEW
        return Drawn(self.timesteps, self.gains + fault, self.noise)


def drawn(chance: np.random.Generator, order: int, eps: float = EPS, radius: float = 0.7) -> Drawn:
    """Gains of amplitude 0.01 or so at the longest timestep, with noise of a few ulp a step.

    Beyond the radius, which is the inverse of the one given, gains are any.
    """
    timesteps = LONGEST / 2.0 ** np.arange(DOUBLE if eps == EPS else SINGLE)
    x, powers = timesteps / LONGEST, np.arange(2 * TERMS)
    amplitudes = 10 ** chance.normal(-2.0, DECADES, STATES)
    of_terms = amplitudes[:, None] * radius ** powers[:, None, None]
    coefficients = of_terms * chance.standard_normal((len(powers), STATES, 3))
    basis = x[:, None] ** (order + powers)
    noise = np.broadcast_to((4 * eps / timesteps)[:, None], (len(x), STATES))
    gains = np.einsum("ji,ikc->jkc", basis, coefficients)
    is_beyond = radius * x >= 1
    largest = np.abs(gains[~is_beyond]).max()
    gains[is_beyond] = largest * chance.standard_normal(gains[is_beyond].shape)
    return Drawn(timesteps, gains + noise[..., None] * chance.standard_normal(gains.shape), noise)


def sample(order: int, eps: float = EPS, radius: float = 0.7) -> list[Drawn]:
    chance = np.random.default_rng(SEED)
    return [drawn(chance, order, eps, radius) for _ in range(METHODS)]


@cache
def honest(order: int, eps: float, noise: float) -> list[GainSeries]:
    """What is fitted to such a sample, by one series each."""
    return [one.fitted(0.0, noise) for one in sample(order, eps)]


def tails_of(fits: list[GainSeries]) -> np.ndarray:
    """Of every gain that is predicted."""
    return np.ravel([one.tails[PREDICTED_FROM:] for one in fits])


def distance(values: np.ndarray) -> float:
    """From a uniform distribution, beyond what chance makes."""
    return float(kstest(values, "uniform").statistic - BY_CHANCE / np.sqrt(len(values)))


def is_told(found: GainSeries) -> bool:
    """As a fault, or as long steps that are beyond a radius or are computed otherwise."""
    return is_accused(found) or bool(found.beyond.any() or found.changes.any())


def is_accused(found: GainSeries) -> bool:
    return found.tail < LEVEL


EVERY = pytest.mark.parametrize("order", [1, 2, 4])
PRECISIONS = pytest.mark.parametrize("eps", [EPS, EPS_SINGLE], ids=["double", "single"])


@PRECISIONS
@EVERY
def test_tails_of_honest_gains_are_uniform(order: int, eps: float) -> None:
    tails = tails_of(honest(order, eps, 1.0))
    assert distance(tails) <= ESTIMATED
    # Nor is the least likely of n less likely than one of n².
    assert tails.min() * len(tails) ** 2 >= 1
    # With noise that is taken for less or more than it is they are not.
    for mistaken in (0.1, 10.0):
        assert distance(tails_of(honest(order, eps, mistaken))) > ESTIMATED


@pytest.mark.parametrize("radius", [0.5, 0.6, 1.2, 1.5, 2.9, 3.3])
def test_so_are_those_of_series_that_converge_faster_or_slower(radius: float) -> None:
    fits = [one.fitted(0.0) for one in sample(1, radius=radius)]
    assert distance(tails_of(fits)) <= ESTIMATED


def test_a_state_whose_series_converges_late_has_a_radius_of_its_own(monkeypatch) -> None:
    """As one near a pole of an engine's angles: by the radius of the others it is less likely."""

    def least_tail() -> float:
        chance, least = np.random.default_rng(SEED), []
        for _ in range(METHODS):
            usual, late = (drawn(chance, 3, radius=radius) for radius in (0.5, 8.0))
            gains = np.concatenate([usual.gains[:, 1:], late.gains[:, :1]], axis=1)
            least.append(Drawn(usual.timesteps, gains, usual.noise).fitted(0.0).least_tails[-1])
        return float(np.median(least))

    by_its_own = least_tail()
    monkeypatch.setattr(regression, "_inverse_radii", lambda x: np.array([0.5]))
    assert by_its_own > 10 * least_tail()


def test_more_terms_change_no_tail_to_twice_as_much(monkeypatch) -> None:
    methods = sample(1, radius=2.9)[:FAULTY]

    def tails(terms: int) -> np.ndarray:
        monkeypatch.setattr(regression, "TERMS", terms)
        return tails_of([one.fitted(0.0) for one in methods])

    usual = tails(TERMS)

    def changed(terms: int) -> float:
        return float(np.abs(np.log10(tails(terms) / usual)).max())

    # To a level of 1e-9 a tail that is twice as large is the same.
    assert changed(2 * TERMS) < np.log10(2) < changed(TERMS // 2)


@PRECISIONS
@EVERY
def test_a_level_is_the_most_of_honest_methods_that_it_accuses(order: int, eps: float) -> None:
    tails = np.array([one.tail for one in honest(order, eps, 1.0)])
    for level in (0.05, 0.2):
        by_chance = np.sqrt(level * (1 - level) / len(tails))
        assert (tails < level).mean() <= level + 3 * by_chance


@PRECISIONS
@EVERY
def test_a_limit_is_as_far_from_zero_as_its_standard_error_says(order: int, eps: float) -> None:

    def scores(noise: float) -> np.ndarray:
        found = honest(order, eps, noise)
        return np.ravel([one.limit / one.limit_error[:, None] for one in found])

    by_chance = 5 / np.sqrt(2 * len(scores(1.0)))
    assert scores(1.0).std() == pytest.approx(1.0, abs=by_chance + 2 * ESTIMATED)
    assert scores(0.1).std() > 2
    assert distance(np.ravel([one.limit_tails for one in honest(order, eps, 1.0)])) <= ESTIMATED


@PRECISIONS
@EVERY
def test_the_order_is_that_of_the_gains_and_no_honest_method_is_accused(
    order: int, eps: float
) -> None:
    """One series is enough for each, so that no change of a formula is looked for."""
    for found in honest(order, eps, 1.0):
        assert found.order == order
        assert not is_accused(found)


@pytest.mark.parametrize(
    ("order", "eps", "size"),
    [(1, EPS, 1e-9), (2, EPS, 1e-10), (4, EPS, 1e-10), (1, EPS_SINGLE, 1e-2)],
)
def test_a_constant_is_detected_and_known(order: int, eps: float, size: float) -> None:
    for one in sample(order, eps)[:FAULTY]:
        found = one.with_fault(size).fitted()
        assert is_accused(found)
        surest = int(found.limit_error.argmin())
        limit = float(np.linalg.norm(found.limit[surest]))
        assert limit == pytest.approx(size, abs=6 * found.limit_error[surest])


def test_a_constant_that_no_state_shows_by_itself_is_detected_of_all_together() -> None:
    for one in sample(1)[:FAULTY]:
        error = one.fitted(0.0).limit_error
        each = Drawn(one.timesteps, one.gains + 4 * error[:, None] * ASKEW, one.noise).fitted(0.0)
        assert each.least_tails.min() * each.tests > LEVEL
        assert each.tail < LEVEL
        assert replace(each, is_pooled=False).tail > LEVEL


def at_one(h: np.ndarray) -> np.ndarray:
    return (np.arange(len(h)) == len(h) - 4).astype(float)


Shape = Callable[[np.ndarray], np.ndarray]
#: What faults are at timesteps h, and sizes that are detected.
SHAPES: dict[str, tuple[Shape, float]] = {
    "the root of the timestep": (lambda h: np.sqrt(h / LONGEST), 1e-6),
    "one timestep": (at_one, 1e-7),
    "shorter steps": (lambda h: (h < LONGEST / 20).astype(float), 1e-5),
    "longer steps": (lambda h: (h > LONGEST / 20).astype(float), 1e-2),
    "the inverse of the timestep": (lambda h: h[-1] / h, 1e-6),
}


@pytest.mark.parametrize("name", SHAPES)
@EVERY
def test_what_is_no_series_of_the_timestep_is_detected(order: int, name: str) -> None:
    shape, size = SHAPES[name]
    for one in sample(order)[:FAULTY]:
        found = one.with_fault(size * shape(one.timesteps)).fitted()
        # Of steps that vanish once they are short a method converges.
        assert is_told(found) if name == "longer steps" else is_accused(found)


@pytest.mark.parametrize("constant", [0.0, 1e-5])
def test_steps_that_are_computed_otherwise_below_some_timestep_must_vanish_too(
    constant: float,
) -> None:
    """Of one method the longer steps, of another the shorter ones, which gain a constant or not."""
    first = 6
    methods = sample(1)
    for long, short in zip(methods[:FAULTY], methods[FAULTY : 2 * FAULTY], strict=True):
        sizes = constant * (np.arange(DOUBLE) >= first)
        gains = np.concatenate([long.gains[:first], short.gains[first:]])
        both = Drawn(long.timesteps, gains, long.noise).with_fault(sizes)
        found = both.fitted()
        assert is_accused(both.fitted(0.0)), "one series explains both"
        assert is_accused(found) == bool(constant)
        assert constant or set(found.changes) <= {0, first}
        assert found.changes.any() == (not constant)


@pytest.mark.parametrize("constant", [0.0, 1e-5])
def test_a_change_that_another_quantity_shows_need_not_show_in_this_one(constant: float) -> None:
    """So little of it that many states show none: what is left must vanish all the same."""
    first, few, alone = 6, slice(3), []
    for one in sample(1)[:FAULTY]:
        h, gains = one.timesteps, one.gains.copy()
        little = 40 * one.noise[first, 0] * (h[first:] / h[first]) ** 2
        gains[first:, few] += little[:, None, None] * ASKEW
        sizes = constant * (np.arange(DOUBLE) >= first)
        changed = Drawn(h, gains, one.noise).with_fault(sizes)
        alone.append(is_accused(changed.fitted()))
        seen = [np.full(STATES, first)]
        found = fitted(h, changed.gains, changed.noise, LEVEL, changes_elsewhere=seen)
        assert is_accused(found) == bool(constant)
    assert any(alone), "no need of what another quantity shows"


def test_a_change_that_another_quantity_shows_excuses_no_single_timestep() -> None:
    """The second series would begin with the one that is off, which nothing predicts."""
    first = 6
    for one in sample(1)[:FAULTY]:
        faulty = one.with_fault(1e3 * one.noise[first, 0] * (np.arange(DOUBLE) == first))
        seen = [np.full(STATES, first)]
        assert is_accused(
            fitted(one.timesteps, faulty.gains, one.noise, LEVEL, changes_elsewhere=seen)
        )


def test_fewer_timesteps_than_a_change_needs_are_one_series() -> None:
    one = sample(1)[0].with_fault(1.0)
    few = Drawn(one.timesteps[:LEAST], one.gains[:LEAST], one.noise[:LEAST])
    assert not few.fitted().changes.any()


def test_a_state_that_gains_nothing_says_nothing_of_the_others() -> None:
    """Such as one at rest."""
    one = sample(1)[0]
    one.gains[:, 0] = 0.0
    assert not is_accused(one.fitted())
    assert is_accused(one.with_fault(1e-9).fitted())


def test_units_make_no_difference() -> None:
    one, size = sample(2)[0], 2.0**-100
    other = fitted(2.0**30 * one.timesteps, size * one.gains, size * one.noise, LEVEL)
    np.testing.assert_allclose(other.tails, one.fitted().tails, rtol=1e-6)
    np.testing.assert_allclose(other.limit / size, one.fitted().limit, rtol=1e-6)


def below_a_turn(timesteps: int, seed: int) -> tuple[np.ndarray, ...]:
    """Timesteps, honest gains that are less by 1e-4 of themselves below a turn, noise and rates.

    The turn is where the slowest state has four steps below it, and the fastest three fewer.
    """
    chance = np.random.default_rng([SEED, seed])
    whole = drawn(chance, 1)
    h, gains, noise = (one[:timesteps] for one in (whole.timesteps, whole.gains, whole.noise))
    rates = 2.0 ** chance.uniform(0, 3, STATES)
    turns = h[:, None] * rates
    is_short = turns < h[-LEAST] * rates.min() * 1.01
    return h, gains * (1 - 1e-4 * is_short[..., None]), noise, rates


@pytest.mark.parametrize("timesteps", [5, 6, 7, 8, DOUBLE])
def test_a_method_may_compute_steps_below_a_turn_otherwise(timesteps: int) -> None:
    for seed in range(FAULTY):
        h, gains, noise, rates = below_a_turn(timesteps, seed)
        assert np.isfinite(fitted(h, gains, noise, LEVEL, turns=h[:, None] * rates).tail)
        if timesteps == DOUBLE:
            assert fitted(h, gains, noise, LEVEL).tail < LEVEL
            assert fitted(h, gains, noise, LEVEL, turns=h[:, None] * rates).tail >= LEVEL
