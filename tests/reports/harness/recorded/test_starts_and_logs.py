"""Starts that were read wrongly, springs, torques that end, long timesteps, and faults of logs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from planted_motions import Case, case, exactly, product, rates_of, stepped
from reported_faults import Arrays
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import from_tables

pytestmark = pytest.mark.slow

FREE, TOP = case(81, samples=401), case(82, is_pivoted=True, samples=401)
ANGLES = [25.0, 40.0, 55.0]


def judged(one: Case, arrays: Arrays, order: int = 1, **stated: str) -> JudgedMotion:
    return judged_motion(one.scenario, Recording(Path("motion.csv"), arrays, stated), order)


def with_start(one: Case, **start: object) -> Case:
    tables = one.scenario.document.model_dump(mode="json", exclude_none=True)
    tables["start"] = {"omega_body": tables["start"]["omega_body"]} | start
    return replace(one, scenario=from_tables(tables, "started"))


def started(turned: Rotation, omega: np.ndarray) -> Arrays:
    """The exact motion of the free body from another start."""
    q = turned.as_quat(scalar_first=True).tolist()
    other = with_start(FREE, quaternion_wxyz=q, omega_body=omega.tolist())
    return exactly(other, rates_of(other))


def noisy(arrays: Arrays, of_attitude: float, of_omega: float) -> Arrays:
    chance = np.random.default_rng(7)
    turns = Rotation.from_rotvec(chance.normal(0, of_attitude, (len(arrays["t"]), 3)))
    turned = Rotation.from_quat(arrays["q"], scalar_first=True) * turns
    omega = arrays["omega"] + chance.normal(0, of_omega, arrays["omega"].shape)
    return arrays | {"q": turned.as_quat(scalar_first=True), "omega": omega}


@pytest.mark.parametrize("convention", ["ZYX", "xyz"])
def test_angles_of_a_start_that_are_read_otherwise_are_named(convention: str) -> None:
    scene = with_start(FREE, euler_zyz_deg=ANGLES)
    turned = Rotation.from_euler(convention, ANGLES, degrees=True)
    found = judged(scene, started(turned, scene.scenario.start.omega_body))
    axes = "-".join(convention.lower())
    (words,) = found.explained_by
    assert f"read as {axes}" in words
    assert ("about the world's axes" in words) == convention.islower()


def test_omega_of_a_start_along_other_axes_is_named() -> None:
    start = FREE.scenario.start
    turned = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
    omega = turned.apply(np.array(start.omega_body))
    (words,) = judged(FREE, started(turned, omega)).explained_by
    assert words == ("it started elsewhere: its ω along world axes is taken to be along body axes")
    both = started(turned.inv(), -start.omega_body)
    (words,) = judged(FREE, both).explained_by
    assert "that of the world in the body, and its ω has the other sign" in words


def test_another_start_is_named_beside_other_equations() -> None:
    start = FREE.scenario.start
    turned = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
    omega = turned.apply(np.array(start.omega_body)).tolist()
    other = with_start(FREE, quaternion_wxyz=start.q_world_body_wxyz.tolist(), omega_body=omega)
    damped = exactly(other, rates_of(other, torque=lambda omega: -0.2 * omega))
    physics, began = judged(FREE, damped).explained_by
    assert "slowed" in physics or "drag" in physics
    assert "its ω along world axes" in began


@pytest.mark.parametrize("is_at_start", [False, True])
def test_a_spring_in_proportion_to_the_angle_is_named(is_at_start: bool) -> None:
    k, plain = 0.7, rates_of(TOP)
    q_rest = TOP.scenario.start.q_world_body_wxyz if is_at_start else np.array([1.0, 0, 0, 0])
    rest = Rotation.from_quat(q_rest, scalar_first=True)

    def rates(q, omega):
        turning, accelerated = plain(q, omega)
        away = (rest.inv() * Rotation.from_quat(q, scalar_first=True)).as_rotvec()
        return turning, accelerated - np.linalg.solve(TOP.inertia, k * away)

    (words,) = judged(TOP, exactly(TOP, rates)).explained_by
    assert f"a spring of {k:g} N m a radian, in proportion to the angle" in words
    assert words.endswith("to the attitude [1, 0, 0, 0]") != is_at_start


def test_a_torque_that_ends_is_named_without_a_timestep() -> None:
    tables = FREE.scenario.document.model_dump(mode="json", exclude_none=True)
    push, end = np.array([0.5, -0.9, 0.7]), 1.6
    tables["effects"] = {"torque": {"body": push.tolist()}}
    pushed = replace(FREE, scenario=from_tables(tables, "pushed"))
    with_it = exactly(pushed, rates_of(pushed, torque=lambda _: push))
    kept = with_it["t"] <= end
    last = with_it["q"][kept][-1].tolist(), with_it["omega"][kept][-1].tolist()
    later = with_start(FREE, quaternion_wxyz=last[0], omega_body=last[1])
    after = exactly(later, rates_of(later))
    count = np.count_nonzero(~kept)
    arrays = {
        name: np.concatenate([with_it[name][kept], after[name][1 : count + 1]])
        for name in ("q", "omega")
    }
    (words,) = judged(pushed, arrays | {"t": with_it["t"]}).explained_by
    assert "from then on there were no torque" in words


def test_a_timestep_that_is_longer_than_the_stated_one_is_named() -> None:
    chance, timestep = np.random.default_rng(3), float(FREE.scenario.times[1])
    made = stepped(FREE.scenario, rates_of(FREE), 2, timestep, chance)
    stated = judged(FREE, made, order=2, timestep=repr(timestep / 20))
    (words,) = stated.explained_by
    assert "its timestep is longer than the stated" in words
    assert "errors of order 2" in words
    least = float(words.split("timestep of ")[1].split()[0])
    assert timestep / 20 < least <= timestep
    assert judged(FREE, made, order=2, timestep=repr(timestep)).explained_by == ()


def test_a_stand_that_is_not_level_is_named_beside_a_gyroscopes_scale() -> None:
    tilted = Rotation.from_euler("xy", [1.0, -2.0], degrees=True).apply(TOP.gravity)
    arrays = exactly(TOP, rates_of(replace(TOP, gravity=tilted)))
    arrays = noisy(arrays | {"omega": arrays["omega"] * [1.04, 1, 1]}, 1e-3, 5e-3)
    tilt, scale = judged(TOP, arrays).explained_by
    assert tilt.startswith("gravity is tilted by 2.24° against the scene's")
    assert "the gyroscope's axes read [1.0" in scale


def test_a_gyroscope_that_saturates_in_a_noisy_log_is_named() -> None:
    arrays = noisy(exactly(FREE, rates_of(FREE)), 1e-3, 5e-3)
    bound = 0.8 * float(np.abs(arrays["omega"]).max())
    cut = arrays | {"omega": np.clip(arrays["omega"], -bound, bound)}
    (words,) = judged(FREE, cut).explained_by
    assert f"the gyroscope saturates: each component of ω is clamped to {bound:.6g}" in words
    assert judged(FREE, arrays).explained_by == ()


def test_a_body_that_is_itself_limited_is_no_gyroscope_that_saturates() -> None:
    plain, bound = rates_of(FREE), 1.6

    def rates(q, omega):
        limited = np.clip(omega, -bound, bound)
        return product(q, np.array([0, *limited])) / 2, plain(q, limited)[1]

    arrays = exactly(FREE, rates)
    cut = noisy(arrays | {"omega": np.clip(arrays["omega"], -bound, bound)}, 1e-3, 0.0)
    assert not any("saturates" in words for words in judged(FREE, cut).explained_by)


def test_samples_of_a_noisy_log_that_are_off_are_counted() -> None:
    one = case(81, samples=101)
    arrays = noisy(exactly(one, rates_of(one)), 1e-3, 5e-3)
    swapped = [*range(25, 33), *range(75, 86)]
    half = Rotation.from_rotvec([0, 0, np.pi])
    turned = Rotation.from_quat(arrays["q"][swapped], scalar_first=True) * half
    arrays["q"][swapped] = turned.as_quat(scalar_first=True)
    (words,) = judged(one, arrays).explained_by
    assert "ω is that of the scene, but the attitudes are not at 19 samples" in words
    assert f"the first at t = {arrays['t'][25]:g} s" in words


def test_an_attitude_that_jumps_by_itself_is_not_struck() -> None:
    arrays = exactly(FREE, rates_of(FREE))
    half = Rotation.from_rotvec([0, 0, np.pi])
    turned = half * Rotation.from_quat(arrays["q"][250:], scalar_first=True)
    arrays["q"][250:] = turned.as_quat(scalar_first=True)
    (words,) = judged(FREE, arrays).explained_by
    assert "by 180° and 0 rad/s, as where the attitude alone is set" in words
