"""An attitude that does not turn as ω says is a fault; what turns it otherwise by right is none."""

from collections.abc import Iterator

import numpy as np
import pytest
from library_scenes import library_scene
from scipy.spatial.transform import Rotation
from spincheck.engines import State
from spincheck.engines.checks.bounds import Bounds
from spincheck.engines.checks.faults import faults
from spincheck.engines.checks.turn_faults import Reading
from spincheck.engines.fault import Fault
from spincheck.reference import solve
from spincheck.scenarios.fastest_rate import parts_rate

TIMESTEP = 1e-2
EPS = float(np.finfo(float).eps)


def found(
    turned: Rotation,
    omega_body: np.ndarray,
    timestep: float = TIMESTEP,
    com: np.ndarray | None = None,
    start: int = 0,
    **bounds: object,
) -> Iterator[Fault]:
    """The faults of attitudes a step apart, of which so many are the first of the run."""
    zeros = np.zeros((len(turned), 3))
    place = zeros if com is None else com
    states = State(turned.as_quat(scalar_first=True), omega_body, place, zeros)
    reading = Reading(states, np.arange(len(turned)), states.rows(slice(start)))
    return faults(reading, Bounds(timestep, np.inf, **({"round_off": EPS} | bounds)))


def causes(*motion: object, **bounds: object) -> list[str]:
    return [fault.cause for fault in found(*motion, **bounds)]


# A rule of first order that steps roll, pitch and yaw.

OMEGA_WORLD = np.array([30.0, -10.0, 20.0])
ROLL, YAW = 0.4, -1.1


def rates(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Of roll, pitch and yaw, from ω in world axes (Diebel 2006, §5.6.12)."""
    x, y, z = OMEGA_WORLD
    along = x * np.cos(yaw) + y * np.sin(yaw)
    roll_rate = along / np.cos(pitch)
    return np.array([roll_rate, y * np.cos(yaw) - x * np.sin(yaw), z + roll_rate * np.sin(pitch)])


def step_of_angles(
    pitch: float, by_angles: bool, omega_world: np.ndarray = OMEGA_WORLD
) -> list[str]:
    """The causes of a step of a sphere that nothing acts on, ω read as told."""
    angles = np.array([ROLL, pitch, YAW])
    turned = Rotation.from_euler("xyz", [angles, angles + 1e-3 * rates(*angles)])
    return causes(turned, turned.inv().apply(omega_world), 1e-3, by_angles=by_angles)


@pytest.mark.parametrize("pitch", [0.0, 0.6, 1.2, 1.5])
def test_a_step_of_angles_is_within_the_bound_that_follows_from_their_pitch(pitch: float) -> None:
    assert step_of_angles(pitch, by_angles=True) == []


def test_of_a_rule_that_steps_no_angles_the_same_turn_is_a_fault() -> None:
    assert step_of_angles(1.2, by_angles=False) != []


@pytest.mark.parametrize("pitch", [0.0, 0.6])
def test_omega_in_another_order_is_a_fault_of_either(pitch: float) -> None:
    assert step_of_angles(pitch, True, OMEGA_WORLD[[1, 0, 2]]) == ["frames"]


# A constraint that puts the com back, by no more than it had drifted.

ARM = np.array([0.0, 0.0, 0.5])
#: m, of the com from where the pivot has it, before and after the step.
DRIFT = 1e-3
#: Across the body's axis, as what lifts or lowers a com is.
ACROSS = np.array([0.0, 1.0, 0.0])
#: rad
MOST = 2 * DRIFT / float(np.linalg.norm(ARM))


@pytest.mark.parametrize(
    ("part", "drift", "is_fault"),
    [(0.5, DRIFT, False), (1.0, DRIFT, False), (2.0, DRIFT, True), (0.5, 0.0, True)],
    ids=["half", "all", "beyond", "as in joint coordinates"],
)
def test_a_turn_of_up_to_both_drifts_over_the_arm_is_the_constraints(
    part: float, drift: float, is_fault: bool
) -> None:
    """A held body with constant ω is turned back besides by a part of `MOST`."""
    omega = np.array([1.0, 0.0, 4.0])
    turned = Rotation.from_rotvec([np.zeros(3), TIMESTEP * omega + part * MOST * ACROSS])
    com = turned.apply(ARM) + drift * ACROSS
    single = float(np.finfo(np.float32).eps)
    found_causes = causes(turned, np.array([omega, omega]), com=com, arm=ARM, round_off=single)
    assert bool(found_causes) == is_fault


# An engine that breaks down, and one whose ω is in other axes than its attitude's.

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


def test_a_turn_that_leaps_once_is_no_other_frame() -> None:
    turning = np.tile(ASKEW, (STEPS, 1))
    leap = np.array([-13.0, 6.0, 2.0])
    turning[BROKEN] += leap
    (fault,) = found(attitudes(turning, START), np.tile(ASKEW, (STEPS + 1, 1)), start=2)
    assert (fault.index, fault.cause) == (BROKEN + 1, "parted")
    assert fault.reason.startswith(f"from {BROKEN * TIMESTEP:.4g} s on attitude and ω part")
    apart = TIMESTEP * np.linalg.norm(leap)
    assert f"{np.degrees(apart):.3g}° apart; up to then they agreed" in fault.reason


@pytest.mark.parametrize("axes", [[1, 0, 2], [2, 1, 0], [1, 2, 0]])
def test_another_order_of_components_fails_at_once(axes: list[int]) -> None:
    turned = attitudes(np.tile(ASKEW, (STEPS, 1)), START)
    (fault,) = found(turned, np.tile(ASKEW[axes], (STEPS + 1, 1)), start=2)
    assert (fault.index, fault.cause) == (1, "frames")


def test_another_frame_that_shows_late_because_the_axis_was_its_own_is_still_a_frame() -> None:
    """A body that first spins about an axis that both frames share."""
    turning = np.tile(ALONG_Z, (STEPS, 1))
    turning[BROKEN:] = ASKEW
    turned = attitudes(turning, Rotation.identity())
    (fault,) = found(turned, turned.apply(np.vstack([turning, turning[-1:]])), start=2)
    assert fault.index > BROKEN
    assert fault.cause == "frames"


# ω that a rotor turns within a step may be far from that at its ends.

SCENE = library_scene("gyroscope-in-its-frame")
#: rad that ω is turned in a step: nearly once around, and a small part.
COARSE, FINE = 5.9, 0.05


@pytest.mark.parametrize(
    ("turn", "in_world", "rate", "expected"),
    [
        (COARSE, False, parts_rate(SCENE), set()),
        (FINE, False, parts_rate(SCENE), set()),
        (FINE, True, parts_rate(SCENE), {"frames"}),
        (COARSE, False, 0.0, {"frames", "parted"}),
    ],
    ids=["nearly once around", "a little", "in axes of space", "without the rotor's rate"],
)
def test_omega_may_go_round_within_a_step_that_rotors_turn(turn, in_world, rate, expected) -> None:
    timestep = turn / parts_rate(SCENE)
    motion = solve(SCENE, timestep * np.arange(8)).trajectory
    turned, omega = motion.R_world_body, motion.omega_body
    read = turned.apply(np.array(omega)) if in_world else omega
    got = causes(turned, read, timestep, com=motion.com_world, decay=rate)
    assert set(got) <= expected
    assert bool(got) == bool(expected)
