"""Faults of public reports are explained in the right words: docs/measured/recorded-motions.md."""

import pytest
from reported_faults import FAULTS, FREE, TENSOR, Fault, euler, judged, named, recorded, turning

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.report)
def test_a_reported_fault_is_named_and_no_other(fault: Fault) -> None:
    found = judged(*fault.motion(), fault.timestep)
    assert fault.is_named(named(found))
    # A known integrator that makes the scene's motion is no fault.
    assert found.is_another == (not found.made_by)


def test_a_verdict_says_of_what_order_and_timestep() -> None:
    damped = recorded(*turning(FREE, lambda R, omega: euler(TENSOR)(R, omega) - 0.1 * omega))
    found = judged(FREE, damped, 1e-4)
    assert found.is_beyond
    assert found.verdict == (
        "beyond what a method of order 1 makes of the exact motion at a timestep of 0.0001 s"
    )


@pytest.mark.parametrize("timestep", [1e-4, None])
def test_an_integrators_noise_is_none_of_a_log(timestep: float | None) -> None:
    """Interpolated states are off by some 1e-12, otherwise from each sample to the next."""
    found = judged(FREE, recorded(*turning(FREE, euler(TENSOR))), timestep)
    assert found.measured is None
    assert not found.is_another
