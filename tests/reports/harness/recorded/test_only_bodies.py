"""Numbers that fit are not named where no body, or no filter, has them; what is left is said."""

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from reported_faults import judged, named
from spincheck.reports.harness.explaining.changes import changes
from spincheck.reports.harness.explaining.fit import Fit
from spincheck.reports.harness.explaining.hypothesis import as_it_is
from spincheck.reports.harness.explaining.other_tensors import is_of_a_body
from spincheck.reports.harness.explaining.search import MOST_OF_ALL, Search
from spincheck.reports.harness.recorded.fits.read_omega import Filter
from spincheck.reports.harness.recorded.samples.sensors import as_it_was

ONE = case(151)


def test_an_omega_that_tells_nothing_of_the_body_is_of_no_state() -> None:
    blind = as_it_is(ONE.scenario).of(read=np.diag([1.0, 1.0, 0.0]))
    assert np.isnan(as_it_was(blind[None], np.ones((2, 7)), np.zeros(2))[..., 4:]).all()


def test_a_body_has_no_moment_beyond_the_sum_of_the_others() -> None:
    assert is_of_a_body(np.diag([1.0, 2.0, 2.9]))
    assert is_of_a_body(np.diag([1.0, 2.0, 3.0]))
    assert not is_of_a_body(np.diag([1.0, 2.0, 3.2]))
    assert not is_of_a_body(np.diag([-0.1, 2.0, 2.0]))


@pytest.mark.parametrize("kind", ["gyroscopic tensor", "box, up to a factor"])
def test_only_a_fitted_tensor_need_be_of_a_body(kind: str) -> None:
    """A mistake may well have made one that no body has."""
    change = next(one for one in changes(ONE.scenario) if one.kind == kind)
    thin = np.diag([1.0, 2.0, 9.0])
    base = as_it_is(ONE.scenario)
    of_it = base.with_inertia(thin) if "box" in kind else base.of(gyroscopic=thin)
    numbers = np.empty(0), np.empty((0, 0)), np.empty(0), 0, np.empty((0, 0))
    assert not Fit((change,), of_it, *numbers).is_physical
    assert Fit((), of_it, *numbers).is_physical


@pytest.mark.parametrize(("rates", "is_damping"), [((0.04, 0.04), True), ((-0.4, 0.08), False)])
def test_both_rates_of_a_damping_have_one_sign(
    rates: tuple[float, float], is_damping: bool
) -> None:
    change = next(one for one in changes(ONE.scenario) if one.kind == "decays")
    numbers = np.zeros((2, 2)), np.empty(0), 2, np.empty((0, 2))
    fit = Fit((change,), as_it_is(ONE.scenario), np.array(rates), *numbers)
    assert fit.is_physical == is_damping


def test_many_numbers_that_leave_nothing_are_no_explanation() -> None:
    class Kept(Search):
        def exceed_noise(self, residuals: np.ndarray) -> bool:
            return bool(residuals.any())

    search = Kept(None, (), most=3)

    def fit(left: float, count: int) -> Fit:
        none = np.empty(0)
        return Fit((), as_it_is(ONE.scenario), none, none, np.full(6, left), count, none)

    assert MOST_OF_ALL == 10
    assert [search._has_few_parameters(fit(0.0, n)) for n in (3, 10, 11)] == [True, True, False]
    assert not search._has_few_parameters(fit(1.0, 4))
    assert Kept(None, ()).most is None


@pytest.mark.parametrize(
    ("outputs", "inputs", "is_one"),
    [
        ([0.75], [0.25], True),
        ([], [0.25, 0.25, 0.25, 0.25], True),
        ([1.6, -0.65], [0.0125, 0.025, 0.0125], True),
        # Ahead; never forgetting; a difference.
        ([], [1.5, -0.5], False),
        ([1.02], [0.9914, -1.011], False),
        ([0.9989], [1.668, -2.334, 0.6671], False),
    ],
)
def test_a_filter_is_a_mean_of_what_was(
    outputs: list[float], inputs: list[float], is_one: bool
) -> None:
    assert Filter(np.array(outputs), np.array(inputs), 0.0).is_causal == is_one


@pytest.mark.slow
def test_what_an_explanation_leaves_is_said() -> None:
    """A torque that no change makes, beside one that is named."""
    arrays = exactly(
        ONE,
        rates_of(
            ONE,
            gyroscopic=0.5 * ONE.inertia,
            torque=lambda omega: 0.02 * np.sin(5 * omega),
        ),
    )
    said = named(judged(ONE.scenario, arrays, 1e-5))
    assert "the gyroscopic torque ω × Iω were 0.5" in said[0]
    assert said[-1].startswith("this is most of it: what is left, ")
    assert said[-1].endswith(" % of the difference, is beyond the method, and not explained")


@pytest.mark.slow
@pytest.mark.parametrize("is_set", [False, True])
def test_a_rotation_that_is_held_is_named(is_set: bool) -> None:
    inverse = np.linalg.inv(ONE.inertia) * [[1.0], [1.0], [0.0]]
    if not is_set:
        inverse = np.zeros((3, 3))
        inverse[:2, :2] = np.linalg.inv(ONE.inertia[:2, :2])
    (said,) = named(judged(ONE.scenario, exactly(ONE, rates_of(ONE, inverse=inverse)), 1e-5))
    assert ("its z axis were locked" if is_set else "its own z axis were held as it is") in said
