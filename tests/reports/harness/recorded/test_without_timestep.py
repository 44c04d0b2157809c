"""Without a timestep a difference may be a method's error: what is certain is named."""

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from reported_faults import judged

pytestmark = pytest.mark.slow

#: So few samples that a method of order 1 may be far off from one to the next.
ONE = case(151, samples=41)
OTHER = ONE.inertia * (2 * np.eye(3) - 1)


def test_a_change_that_explains_all_is_named_within_a_methods_error() -> None:
    arrays = exactly(ONE, rates_of(ONE, inertia=OTHER))
    found = judged(ONE.scenario, arrays, None)
    assert not found.is_beyond
    assert found.explained_by == ("it moves as if the products of inertia had the other sign",)


def test_a_methods_error_is_explained_by_no_change() -> None:
    """Of explicit Euler, whose steps are those between the samples."""
    rates, arrays = rates_of(ONE), exactly(ONE, rates_of(ONE))
    q, omega = arrays["q"].copy(), arrays["omega"].copy()
    for k, span in enumerate(np.diff(arrays["t"])):
        turning, faster = rates(q[k], omega[k])
        q[k + 1], omega[k + 1] = q[k] + span * turning, omega[k] + span * faster
        q[k + 1] /= np.linalg.norm(q[k + 1])
    found = judged(ONE.scenario, arrays | {"q": q, "omega": omega}, None)
    assert not found.explained_by
    assert found.made_by == "what explicit Euler at 0.1 s makes"
    assert found.verdict.endswith("; state the timestep to see smaller differences")


def test_a_gyroscope_that_saturates_throughout_is_no_other_start() -> None:
    spinning = case(18, samples=41)
    arrays = exactly(spinning, rates_of(spinning))
    bound = 0.9 * np.abs(arrays["omega"]).min(axis=0).max()
    clipped = np.clip(arrays["omega"], -bound, bound)
    found = judged(spinning.scenario, arrays | {"omega": clipped}, None)
    assert found.explained_by == (
        f"each component of ω in body axes is clamped to {bound:.4g} rad/s",
    )
