"""The errors, on motions whose error is known because it was put there."""

import numpy as np
import pytest
from pydantic import TypeAdapter
from scene_texts import scene
from scipy.spatial.transform import Rotation
from spincheck.scenarios import (
    Errors,
    Trajectory,
    error_series,
    errors_between,
    radius_of_gyration,
)

EPS = np.finfo(float).eps
ROUNDED = 32 * EPS
PIVOT = "[effects.pivot]\n"
GRAVITY = "[effects.gravity]\nacceleration = [0.0, 0.0, -10.0]\n"
T = np.linspace(0, 1, 11)
STILL = np.zeros((11, 3))


def always(*vector):
    """The same vector at every sample."""
    return np.tile(np.array(vector, dtype=float), (11, 1))


def spinning(rate=4.0, ahead=0.0, **changes):
    """Rotation about z, the axis of moment 2.5, by an angle `ahead` of where it should be."""
    angles = rate * T + ahead
    columns = {
        "t": T,
        "q_world_body_wxyz": Rotation.from_rotvec(angles[:, None] * [0, 0, 1.0]).as_quat(
            scalar_first=True
        ),
        "omega_body": always(0, 0, rate),
        "com_world": STILL,
        "velocity_world": STILL,
    }
    return Trajectory(**{**columns, **changes})


EXACT = spinning()
MADE = scene()


def test_a_rate_off_by_a_hundredth_is_off_by_a_hundredth():
    """ω and L by 0.01, energy by 2 · 0.01 + 0.01², attitude by 0.04 rad after a second."""
    errors = errors_between(MADE, spinning(4.04), EXACT)
    by_hand = {"omega": 0.01, "attitude": 0.04, "angular_momentum": 0.01, "energy": 0.0201}
    by_hand |= {"com": 0.0, "velocity": 0.0}
    # The rate 4.04 is itself rounded, and 0.01 is a difference of numbers near 4.
    assert dict(errors) == pytest.approx(by_hand, abs=ROUNDED)


@pytest.mark.parametrize(("ahead", "sign"), [(0.0, -1), (1e-9, 1), (1e-9, -1), (np.pi, 1)])
def test_an_attitude_ahead_by_an_angle_is_off_by_that_angle_alone(ahead, sign):
    """Up to half a turn; a quaternion of the other sign is the same attitude."""
    turned = spinning(ahead=ahead)
    moved = spinning(q_world_body_wxyz=sign * turned.q_world_body_wxyz)
    errors = errors_between(MADE, moved, EXACT)
    assert errors.attitude == pytest.approx(ahead, abs=ROUNDED)
    assert errors.omega == errors.energy == 0


def test_attitudes_are_compared_in_the_body_and_angular_momenta_in_the_world():
    """Turned a right angle about x: L points along −y, |ΔL|/|L| = √2, and ω is right."""
    aside = Rotation.from_rotvec([np.pi / 2, 0, 0]) * EXACT.R_world_body
    errors = errors_between(
        MADE, spinning(q_world_body_wxyz=aside.as_quat(scalar_first=True)), EXACT
    )
    assert errors.attitude == pytest.approx(np.pi / 2)
    assert errors.angular_momentum == pytest.approx(np.sqrt(2))
    assert errors.omega == errors.energy == 0


def test_errors_are_relative_to_the_largest_of_the_exact_motion():
    """ω runs from 0 to 4: off by 0.1 at the start, where it is zero, is off by 0.1/4."""
    omega = np.linspace(0, 1, 11)[:, None] * [0, 0, 4.0]
    exact, wrong_omega = spinning(omega_body=omega), omega.copy()
    wrong_omega[0] = [0.1, 0, 0]
    errors = errors_between(MADE, spinning(omega_body=wrong_omega), exact)
    assert errors.omega == pytest.approx(0.1 / 4, abs=ROUNDED)
    assert errors.angular_momentum == pytest.approx(0.1 / 10, abs=ROUNDED)


def test_energy_is_relative_to_motion_and_weight():
    """Off by 1 m in height, 20 J, of T = 20 J and 2 kg · 10 m/s² · 3 m."""
    scenario = scene(more=GRAVITY)
    exact = spinning(com_world=always(0, 0, 3.0))
    errors = errors_between(scenario, spinning(com_world=always(0, 0, 4.0)), exact)
    assert errors.energy == pytest.approx(20 / 80, abs=ROUNDED)
    assert errors.angular_momentum == 0


def test_about_a_pivot_the_coms_path_is_angular_momentum():
    """r × m v = 2 · 3 beside I ω = 10."""
    scenario = scene(more=PIVOT)
    com, velocity = always(1.0, 0, 0), always(0, 3.0, 0)
    exact = spinning(com_world=com, velocity_world=velocity)
    errors = errors_between(scenario, spinning(com_world=com), exact)
    assert errors.angular_momentum == pytest.approx(6 / 16, abs=ROUNDED)


def resting(**changes):
    columns = {"t": T, "q_world_body_wxyz": always(1, 0, 0, 0), "omega_body": STILL}
    return Trajectory(**{**columns, "com_world": STILL, "velocity_world": STILL, **changes})


def test_a_motion_agrees_with_itself_and_what_moves_though_it_should_rest_is_infinitely_far_off():
    for motion in (EXACT, resting()):
        assert set(dict(errors_between(MADE, motion, motion)).values()) == {0.0}
    errors = errors_between(MADE, resting(omega_body=always(0, 0, 1e-9)), resting())
    assert (errors.omega, errors.angular_momentum, errors.energy) == (np.inf, np.inf, np.inf)
    assert errors.attitude == 0


def test_the_series_shows_when():
    omega = EXACT.omega_body.copy()
    omega[7] += [0, 0, 0.4]
    series = error_series(MADE, spinning(omega_body=omega), EXACT)
    assert int(series["omega"].argmax()) == 7
    assert np.count_nonzero(series["omega"]) == 1
    assert series.worst().omega == pytest.approx(0.1, abs=ROUNDED)


def test_other_sample_times_are_refused():
    with pytest.raises(ValueError, match="must be sampled at the same times"):
        errors_between(MADE, spinning(t=T * 1.0000001), EXACT)


def test_spins_are_compared_where_there_are_any_beside_the_fastest_turn():
    assert "spins" not in dict(errors_between(MADE, EXACT, EXACT))
    rotor = """
[[rotors]]
axis = [0.0, 0.0, 1.0]
position = [0.0, 0.0, 0.0]
mass = 0.1
inertia = [2e-5, 4e-5]
spin = 1.0
hinge = "free"
"""
    gyrostat = scene(more=rotor + rotor)
    exact, off = (spinning(spins=always(1.0, spin)) for spin in (6.0, 6.3))
    errors = errors_between(gyrostat, off, exact)
    # Both spins, (1, 6), are one vector.
    assert errors["spins"] == pytest.approx(0.3 / np.hypot(1.0, 6.0), abs=ROUNDED)
    assert errors.omega == errors.attitude == 0.0


@pytest.mark.parametrize("signal", ["com", "velocity"])
def test_a_com_that_should_stay_is_measured_against_the_radius_of_gyration(signal):
    scene_of = MADE
    k = radius_of_gyration(scene_of)
    moved = spinning(**{f"{signal}_world": always(0.0, 0.1, 0.0)})
    base = {"com": k, "velocity": 4.0 * k}[signal]
    assert getattr(errors_between(scene_of, moved, EXACT), signal) == pytest.approx(0.1 / base)


def test_errors_that_were_stored_before_a_signal_was_added_are_read():
    at_first = ["omega", "attitude", "angular_momentum", "energy", "com", "velocity"]
    read = TypeAdapter(Errors).validate_python(dict.fromkeys(at_first, 1e-3))
    assert [name for name, _ in read] == at_first
