"""What a filter makes of ω is named where the attitudes obey the scene's equations."""

from collections.abc import Callable

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from reported_faults import judged, named
from spincheck.reports.harness.recorded.fits.read_omega import _filtered

pytestmark = pytest.mark.slow

ONE = case(151)
ARRAYS = exactly(ONE, rates_of(ONE))
DISTANCE = float(ARRAYS["t"][1])
KEPT = 0.75


def low_passed(omega: np.ndarray) -> np.ndarray:
    out = omega.copy()
    for k in range(1, len(omega)):
        out[k] = KEPT * out[k - 1] + (1 - KEPT) * omega[k]
    return out


def mean_of_four(omega: np.ndarray) -> np.ndarray:
    out = omega.copy()
    for k in range(3, len(omega)):
        out[k] = omega[k - 3 : k + 1].mean(axis=0)
    return out


#: How ω is read, and what is said: the delay of a mean is that of its middle.
READ: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "low pass": (
        low_passed,
        f"delays it by {KEPT / (1 - KEPT) * DISTANCE:.4g} s: it is 0.75 of itself a sample before, "
        "0.25 of the body's",
    ),
    "mean of four": (mean_of_four, "ω is the mean over 4 samples, 0.06 s, up to each"),
}


@pytest.mark.parametrize("name", READ)
def test_what_was_made_of_omega_is_named(name: str) -> None:
    read, words = READ[name]
    found = judged(ONE.scenario, ARRAYS | {"omega": read(ARRAYS["omega"])}, 1e-5)
    (said,) = named(found)
    assert words in said


def smoothed(omega: np.ndarray) -> np.ndarray:
    """The mean over eleven samples around each; fewer at either end."""
    return np.array([omega[max(0, k - 5) : k + 6].mean(axis=0) for k in range(len(omega))])


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (smoothed, "ω is the mean over 11 samples, 0.2 s, around each"),
        (
            lambda omega: omega * [1, 1, 180 / np.pi],
            "the gyroscope's axes read [1, 1, 57.29578] times ω, as in degrees",
        ),
        (lambda omega: omega * [1.2, 1, 1], "the gyroscope's axes read [1.2, 1, 1] times ω"),
    ],
)
def test_beside_right_attitudes_an_omega_that_is_not_is_named(read, words) -> None:
    found = judged(ONE.scenario, ARRAYS | {"omega": read(ARRAYS["omega"])}, None)
    assert found.explained_by == (words,)


def test_what_is_smooth_is_no_filter() -> None:
    """By its own samples before anything smooth is nearly found, whatever the body does."""
    one = case(151, samples=801)
    right = exactly(one, rates_of(one))
    other = right["omega"] * [1, 1, 180 / np.pi]
    assert _filtered(right["t"], right["omega"], other, 1e-3) is None


def test_an_omega_of_other_equations_is_not_read_through_a_filter() -> None:
    """Where attitudes are off the scene's equations, too, ω is not what is wrong."""
    other = exactly(ONE, rates_of(ONE, gyroscopic=0.5 * ONE.inertia))
    found = judged(ONE.scenario, other, 1e-5)
    assert "gyroscopic" in found.explained_by[0]
    assert not any("filtered" in words for words in found.explained_by)
