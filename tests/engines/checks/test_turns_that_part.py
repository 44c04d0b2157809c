"""An engine that breaks down is told from one whose ω is in other axes than its attitude's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.engines import State
from spincheck.engines.checks.bounds import Bounds
from spincheck.engines.checks.faults import faults
from spincheck.engines.checks.turn_faults import Reading
from spincheck.engines.fault import Fault

TIMESTEP = 1e-2
STEPS = 64
#: The step that an engine breaks down in.
BROKEN = 40
ASKEW = np.array([4.0, 2.0, 5.0])
ALONG_Z = np.array([0.0, 0.0, 5.0])
START = Rotation.from_rotvec([0.3, -0.2, 0.7])


def attitudes(rates_body: np.ndarray, start: Rotation) -> Rotation:
    """After no step, after one, and so on."""
    turned = [start]
    for rate in rates_body:
        turned.append(turned[-1] * Rotation.from_rotvec(TIMESTEP * rate))
    return Rotation.concatenate(turned)


def only_fault(turned: Rotation, omega: np.ndarray) -> Fault:
    zeros = np.zeros((STEPS + 1, 3))
    states = State(turned.as_quat(scalar_first=True), omega, zeros, zeros)
    reading = Reading(states, np.arange(STEPS + 1), states.rows(slice(2)))
    (fault,) = faults(reading, Bounds(TIMESTEP, np.inf, float(np.finfo(float).eps)))
    return fault


def test_a_turn_that_leaps_once_is_no_other_frame() -> None:
    rates = np.tile(ASKEW, (STEPS, 1))
    leap = np.array([-13.0, 6.0, 2.0])
    rates[BROKEN] += leap
    fault = only_fault(attitudes(rates, START), np.tile(ASKEW, (STEPS + 1, 1)))
    assert (fault.index, fault.cause) == (BROKEN + 1, "parted")
    assert fault.reason.startswith(f"from {BROKEN * TIMESTEP:.4g} s on attitude and ω part")
    apart = TIMESTEP * np.linalg.norm(leap)
    assert f"{np.degrees(apart):.3g}° apart; up to then they agreed" in fault.reason


@pytest.mark.parametrize("axes", [[1, 0, 2], [2, 1, 0], [1, 2, 0]])
def test_another_order_of_components_fails_at_once(axes: list[int]) -> None:
    rates = np.tile(ASKEW, (STEPS, 1))
    fault = only_fault(attitudes(rates, START), np.tile(ASKEW[axes], (STEPS + 1, 1)))
    assert (fault.index, fault.cause) == (1, "frames")


def test_another_frame_that_shows_late_because_the_axis_was_its_own_is_still_a_frame() -> None:
    """A body that first spins about an axis that both frames share."""
    rates = np.tile(ALONG_Z, (STEPS, 1))
    rates[BROKEN:] = ASKEW
    turned = attitudes(rates, Rotation.identity())
    omega_world = turned.apply(np.vstack([rates, rates[-1:]]))
    fault = only_fault(turned, omega_world)
    assert fault.index > BROKEN
    assert fault.cause == "frames"
