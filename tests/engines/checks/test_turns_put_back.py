"""A constraint that puts the com back turns the body beyond ω, by no more than it had drifted."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.engines import State
from spincheck.engines.checks.bounds import Bounds
from spincheck.engines.checks.faults import faults
from spincheck.engines.checks.turn_faults import Reading

TIMESTEP = 1e-2
EPS = float(np.finfo(np.float32).eps)
OMEGA = np.array([1.0, 0.0, 4.0])
ARM = np.array([0.0, 0.0, 0.5])
#: m, of the com from where the pivot has it, before and after the step.
DRIFT = 1e-3
#: Across the body's axis, as what lifts or lowers a com is.
ACROSS = np.array([0.0, 1.0, 0.0])


def one_step(turn_back: float, drift: float) -> Reading:
    """Of a held body with constant ω, turned besides by so many rad."""
    turned = Rotation.from_rotvec([np.zeros(3), TIMESTEP * OMEGA + turn_back * ACROSS])
    com = turned.apply(ARM) + drift * ACROSS
    states = State(
        turned.as_quat(scalar_first=True), np.array([OMEGA, OMEGA]), com, np.zeros((2, 3))
    )
    none = State(np.empty((0, 4)), *(np.empty((0, 3)) for _ in range(3)))
    return Reading(states, np.array([1, 2]), none)


def causes(reading: Reading) -> list[str]:
    bounds = Bounds(TIMESTEP, np.inf, EPS, arm=ARM)
    return [fault.cause for fault in faults(reading, bounds)]


MOST = 2 * DRIFT / float(np.linalg.norm(ARM))


@pytest.mark.parametrize("part", [0.5, 1.0])
def test_a_turn_of_up_to_both_drifts_over_the_arm_is_the_constraints(part: float) -> None:
    assert causes(one_step(part * MOST, DRIFT)) == []


def test_a_turn_beyond_it_is_a_fault() -> None:
    assert causes(one_step(2 * MOST, DRIFT)) != []


def test_where_the_com_has_not_drifted_nothing_is_put_back() -> None:
    """As in joint coordinates."""
    assert causes(one_step(0.5 * MOST, 0.0)) != []
