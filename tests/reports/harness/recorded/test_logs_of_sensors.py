"""What logs of real sensors have besides noise: counts, few digits, other units, rounded times."""

import re
from pathlib import Path

import numpy as np
import pytest
from box import BOX
from library_scenes import library_scene
from reported_faults import named
from scipy.spatial.transform import Rotation
from spincheck.reference import solve
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.samples.sensors import SENSORS, of_sensor
from spincheck.scenarios import Scenario, loads

pytestmark = pytest.mark.slow

Arrays = dict[str, np.ndarray]
#: Samples, and the angle by which the body turns from one to the next at first, rad.
COUNT, TURN = 300, 0.0473
#: Standard deviations of attitude, rad, and ω, relative to its size at first.
ATTITUDE, OMEGA = 2e-3, 1e-3
SCENES = ("book-with-drag", "t-handle", "quadrotor-body")
LONGER = BOX.replace("samples = 11", "samples = 201")
SLOW = LONGER.replace("[1.0, 2.0, 0.5]", "[1e-6, 2e-6, 3e-5]").replace("= 1.0\n", "= 2e5\n")
DRIVEN = (
    LONGER.replace("[1.0, 2.0, 0.5]", "[0.0, 0.0, 0.5]").replace("= 1.0\n", "= 4.0\n")
    + """
[effects.torque]
body = [0.0, 0.0, 1.0]
"""
)


def noisy(scenario: Scenario, t: np.ndarray, attitude: float, omega: float) -> Arrays:
    """The exact motion with noise of attitude, rad, and ω, rad/s, of these standard deviations."""
    chance, motion = np.random.default_rng(11), solve(scenario, t).trajectory
    turned = Rotation.from_rotvec(chance.normal(0, attitude, (len(t), 3)))
    q = Rotation.from_quat(motion.q_world_body_wxyz, scalar_first=True) * turned
    read = motion.omega_body + chance.normal(0, omega, (len(t), 3))
    return {"t": t, "q": q.as_quat(scalar_first=True), "omega": read}


def log(name: str, attitude: float = ATTITUDE, omega: float = OMEGA) -> Arrays:
    """A log of a scene of the library, with noise."""
    scenario = library_scene(name)
    speed = float(np.linalg.norm(scenario.start.omega_body))
    t = np.arange(COUNT) * min(TURN / speed, scenario.window.duration / COUNT)
    return noisy(scenario, t, attitude, omega * speed)


def judged(name: str, arrays: Arrays, **stated: str) -> JudgedMotion:
    return judged_motion(library_scene(name), Recording(Path("log.csv"), arrays, stated), 1)


@pytest.mark.parametrize("name", SCENES)
def test_an_omega_far_out_of_scale_is_named_with_its_factor(name: str) -> None:
    """No motion is followed at such a rate, which would take minutes."""
    for factor, words in (
        (1e3, ", as in mrad/s"),
        (180e3 / np.pi, ", as in m°/s"),
        (7506.0, ": look at its unit, or at its sensor's scale"),
    ):
        arrays = log(name)
        found = judged(name, arrays | {"omega": factor * arrays["omega"]})
        (said,) = named(found)
        assert said.startswith("ω is ")
        assert said.endswith(f" times as large as the attitudes turn{words}")
        assert float(said.split()[2]) == pytest.approx(factor, rel=OMEGA)
        assert found.is_beyond
        # The tensor is that of the corrected samples.
        assert found.verdict.startswith(
            "as it is recorded, beyond its noise; corrected, it is within"
        )
        assert found.measured is not None


def test_a_bias_that_is_far_larger_than_the_rate_is_no_scale() -> None:
    """Nor is noise: neither varies as the attitudes' rates do."""
    slow = loads(SLOW, "slow")
    arrays = noisy(slow, slow.times, 1e-3, 1e-5)
    arrays["omega"] += [0.004, 0.0, 0.002]
    stated = {"noise_attitude": "1e-3", "noise_omega": "1e-5"}
    (said,) = named(judged_motion(slow, Recording(Path("log.csv"), arrays, stated), 1))
    bias = re.search(r"^the gyroscope has a bias of \[([\d.]+) ", said)
    assert bias is not None
    assert float(bias[1]) == pytest.approx(0.004, rel=1e-3)


@pytest.mark.parametrize("every", [2, 5])
def test_counts_that_are_held_are_said_to_be_new_at_one_sample_in_so_many(every: int) -> None:
    """As of a gyroscope that is asked more often than it measures."""
    arrays = log("t-handle", omega=0.0)
    count = float(np.abs(arrays["omega"]).max()) / 400
    held = np.rint(arrays["omega"] / count)[np.arange(COUNT) // every * every] * count
    said = named(judged("t-handle", arrays | {"omega": held}))
    assert said[0].startswith(f"ω is held: it is new at one sample in {every} only")


def test_an_omega_that_should_grow_by_equal_steps_shows_none_of_a_sensor() -> None:
    driven = loads(DRIVEN, "driven")
    motion = solve(driven, driven.times).trajectory
    omega = np.array(motion.omega_body)
    omega[100:110, 2] = omega[100, 2]
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": omega}
    (said, *_) = named(judged_motion(driven, Recording(Path("log.csv"), arrays), 1))
    assert "its column is stuck" in said


def test_times_that_are_printed_as_finely_as_all_else_are_not_said_to_be_rounded() -> None:
    scenario = library_scene("hammer")
    t = np.arange(COUNT) / 60
    motion = solve(scenario, t).trajectory
    every = {"t": t, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    assert not judged("hammer", {name: one.round(6) for name, one in every.items()}).is_another


@pytest.mark.parametrize("name", SCENES)
def test_a_gyroscope_that_counts_is_neither_stuck_nor_interpolated(name: str) -> None:
    """Equal samples in succession are frequent where noise is less than a count."""
    arrays = log(name, omega=0.0)
    count = float(np.abs(arrays["omega"]).max()) / 400
    noise = np.random.default_rng(13).normal(0, 0.3 * count, (COUNT, 3))
    arrays["omega"] = np.rint((arrays["omega"] + noise) / count) * count
    assert not judged(name, arrays).is_another


def test_a_column_of_counts_that_is_stuck_is_found() -> None:
    arrays = log("t-handle", omega=0.0)
    count = float(np.abs(arrays["omega"]).max()) / 400
    arrays["omega"] = np.rint(arrays["omega"] / count) * count
    axis = int(np.ptp(arrays["omega"], axis=0).argmax())
    arrays["omega"][100:200, axis] = arrays["omega"][100, axis]
    said = " ".join(named(judged("t-handle", arrays)))
    assert f"w{'xyz'[axis]} is " in said
    assert "its column is stuck" in said


@pytest.mark.parametrize("name", SCENES)
def test_noise_that_is_not_stated_beside_one_that_is_is_estimated(name: str) -> None:
    found = judged(name, log(name), noise_attitude=repr(ATTITUDE))
    assert not found.is_another
    assert found.measured is not None


@pytest.mark.parametrize("name", SCENES)
def test_noise_of_attitudes_beside_an_omega_of_few_digits_is_noise(name: str) -> None:
    arrays = log(name, 10 * ATTITUDE, 0.0)
    rounded = [float(f"{value:.6g}") for value in arrays["omega"].ravel()]
    found = judged(name, arrays | {"omega": np.reshape(rounded, (COUNT, 3))})
    assert not found.is_another


@pytest.mark.parametrize("name", ["t-handle", "hammer", "tennis-racket"])
def test_times_that_are_rounded_are_said_to_be_beside_noise(name: str) -> None:
    even = log(name, ATTITUDE / 10, OMEGA / 10)
    assert not judged(name, even).is_another
    # At least three units from one time to the next.
    decimals = int(np.ceil(-np.log10(even["t"][1] / 3)))
    (said, *_) = named(judged(name, even | {"t": even["t"].round(decimals)}))
    assert said.startswith(f"the times are rounded to {10.0**-decimals:g} s: samples are ")


@pytest.mark.parametrize("noise", [(0.0, 0.0), (ATTITUDE, OMEGA)], ids=["computed", "measured"])
@pytest.mark.parametrize(("name", "angle"), [(SCENES[0], 120), (SCENES[1], 165), (SCENES[2], 150)])
def test_a_gyroscope_is_found_to_be_mounted_at_any_angle(
    name: str, angle: float, noise: tuple[float, float]
) -> None:
    turn = np.radians(angle) * np.array([0.48, -0.6, 0.64])
    arrays = log(name, *noise)
    read = Rotation.from_rotvec(-turn).apply(arrays["omega"])
    (said,) = named(judged(name, arrays | {"omega": read}))
    assert said.startswith("the gyroscope's axes are turned against the body's by [")
    shown = re.sub(r" ± [\d.]+", "", said.split("[")[1].split("]")[0])
    assert [float(one) for one in shown.split(",")] == pytest.approx(np.degrees(turn), abs=0.1)


@pytest.mark.parametrize("noise", [(0.0, 0.0), (ATTITUDE, OMEGA)], ids=["computed", "measured"])
def test_the_order_of_columns_is_that_of_the_whole_log(noise: tuple[float, float]) -> None:
    """At first ω is nearly along one axis, so that there others suit as well within the noise."""
    arrays = log("t-handle", *noise)
    read = Rotation.from_rotvec(np.radians([2.0, 3.0, -2.0])).apply(arrays["omega"])
    columns, tilt = named(judged("t-handle", arrays | {"omega": read[:, [2, 1, 0]] * [1, -1, 1]}))
    assert columns == "ω is [wz, -wy, wx] of its columns"
    assert tilt.startswith("the gyroscope's axes are turned against the body's by [")


def test_the_order_of_columns_is_that_of_the_beginning_where_it_changes() -> None:
    arrays = log("book-with-drag", 0.0, 0.0)
    first, later = arrays["omega"][:150], arrays["omega"][150:]
    both = np.vstack([first[:, [1, 0, 2]], later[:, [2, 0, 1]]])
    (columns, *_) = named(judged("book-with-drag", arrays | {"omega": both}))
    assert columns == "ω is [wy, wx, wz] of its columns"


def test_a_short_log_from_another_start_has_no_axes_of_another_frame() -> None:
    slow = loads(BOX, "slow")
    motion = solve(slow, np.arange(50) * 5e-4).trajectory
    q = Rotation.from_rotvec([0.0, 0.035, 0.0]) * motion.R_world_body
    arrays = {"t": motion.t, "q": q.as_quat(scalar_first=True), "omega": motion.omega_body}
    (said,) = named(judged_motion(slow, Recording(Path("log.csv"), arrays), 1))
    assert said.startswith("it started elsewhere: at t = 0 s the attitude is off by 2.01°")


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (0.6, "the gyroscope's axes read [0.6, 0.6, 0.6] times ω"),
        (0.005, "ω is 0.005 times as large as the attitudes turn: look at its unit"),
    ],
)
def test_an_omega_that_is_too_small_is_no_clamp(name: str, factor: float, words: str) -> None:
    arrays = log(name, 0.0, 0.0)
    (said,) = named(judged(name, arrays | {"omega": factor * arrays["omega"]}))
    assert said.startswith(words)


@pytest.mark.parametrize("absurd", [1e15, -1e60, 1e100])
def test_a_sample_that_no_gyroscope_reads_is_left_out(absurd: float) -> None:
    """As where a packet is lost: no motion is followed at that rate, which would not end."""
    arrays = log("t-handle", 0.0, 0.0)
    arrays["omega"] = np.array(arrays["omega"])
    arrays["omega"][57, 1] = absurd
    found = judged("t-handle", arrays)
    words = f"ω is up to {abs(absurd):.4g} rad/s at 1 sample, at t = {arrays['t'][57]:.6g} s"
    assert named(found) == [f"{words}: leave it out"]
    assert found.is_another


@pytest.mark.parametrize("name", ["quadrotor-body", "fast-top"])
def test_axes_of_another_frame_are_named_where_there_is_no_noise(name: str) -> None:
    arrays, turn = log(name, 0.0, 0.0), np.array([72.0, -90.0, 96.0])
    R = Rotation.from_rotvec(turn, degrees=True)
    q = (Rotation.from_quat(arrays["q"], scalar_first=True) * R).as_quat(scalar_first=True)
    in_body = "of axes that are turned in the body by [72, -90, 96]°"
    assert named(judged(name, arrays | {"q": q})) == [
        f"the attitude is that {in_body}, and ω is not"
    ]
    read = R.inv().apply(arrays["omega"])
    assert named(judged(name, arrays | {"q": q, "omega": read})) == [
        f"attitude and ω are those {in_body}"
    ]


def test_axes_that_are_turned_by_more_than_half_a_turn_are_turned_the_other_way_by_less() -> None:
    (axes,) = (one for one in SENSORS if one.kind == "axes")
    turn = np.array([0.0, 0.0, np.radians(240.0)])
    assert "by 120°" in of_sensor(axes, -turn, lambda n, _: f"{n[2]:.5g}")
