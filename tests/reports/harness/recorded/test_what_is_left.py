"""What is found in a recording is undone, and what is left without it is explained in turn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from hidden import Hidden, changed, check, right
from planted_motions import case, exactly, rates_of, stepped
from reported_faults import Arrays
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.case import Case
from spincheck.reports.harness.recorded.files.exact_at import exact_at
from spincheck.reports.harness.recorded.files.motion import reading_of, recorded_motion
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.findings import finding
from spincheck.reports.harness.recorded.fits.read_omega import _differences
from spincheck.reports.harness.recorded.judged import judged_motion

pytestmark = pytest.mark.slow

FREE, HEAVY = case(303, samples=201), case(402, is_pivoted=True, samples=201)
T = FREE.scenario.times
OTHER = FREE.inertia * (2 * np.eye(3) - 1)
DIAGONAL = np.diag(np.diag(FREE.inertia))
#: A mean moment of inertia and rate, of which small torques are parts.
MOMENT = float(np.trace(FREE.inertia)) / 3
SPEED = float(np.linalg.norm(FREE.scenario.start.omega_body))
#: A torque that scenes have, body axes, N m, and drag, N m s.
PUSH, DRAG = 0.2 * MOMENT * SPEED * np.array([0.5, -0.3, 0.8]), 0.1 * MOMENT
PUSHED = changed(FREE, effects={"torque": {"body": PUSH.tolist()}})
DRAGGED = changed(FREE, effects={"drag": {"rotational": DRAG}})


def printed(arrays: Arrays) -> Arrays:
    """With twelve digits, as files have them."""
    return {
        name: np.array([float(f"{x:.12g}") for x in one.ravel()]).reshape(one.shape)
        for name, one in arrays.items()
    }


def of_other_products() -> Arrays:
    return exactly(FREE, rates_of(FREE, inertia=OTHER))


def of_the_diagonal() -> Arrays:
    return exactly(FREE, rates_of(FREE, gyroscopic=DIAGONAL))


def lagging(arrays: Arrays, seconds: float) -> Arrays:
    """ω of an earlier time than the attitude's."""
    t, kept = arrays["t"], arrays["t"] >= seconds
    earlier = CubicSpline(t, arrays["omega"])(t[kept] - seconds)
    return {"t": t[kept], "q": arrays["q"][kept], "omega": earlier}


def without_rows(arrays: Arrays, first: int, count: int) -> Arrays:
    """Rows are lost while the times go on."""
    kept = np.r_[0:first, first + count : len(arrays["t"])]
    return {name: one[kept] for name, one in arrays.items() if name != "t"} | {
        "t": arrays["t"][: len(kept)]
    }


def with_one_off(arrays: Arrays) -> Arrays:
    omega = arrays["omega"].copy()
    omega[120] += [0.5, -0.3, 0.2]
    return arrays | {"omega": omega}


def exchanged_columns_in_eight_bits() -> Arrays:
    arrays = right(FREE)
    return arrays | {"q": np.round(127 * arrays["q"]) / 127, "omega": arrays["omega"][:, [1, 0, 2]]}


def slowed_and_scaled() -> Arrays:
    arrays = exactly(FREE, rates_of(FREE, torque=lambda omega: -DRAG * omega))
    return arrays | {"omega": arrays["omega"] * [1.04, 1.0, 0.97]}


def held_of_a_heavier_axis() -> Arrays:
    """ω that is new at one sample in five, of a body with another moment."""
    tensor = FREE.inertia + np.diag([0.05 * MOMENT, 0, 0])
    arrays = exactly(FREE, rates_of(FREE, inertia=tensor))
    return arrays | {"omega": arrays["omega"][5 * (np.arange(201) // 5)]}


def jittering_without_half_of_a_torque() -> Arrays:
    arrays = exactly(FREE, rates_of(FREE, gyroscopic=FREE.inertia / 2))
    off = np.random.default_rng(5).uniform(-0.002, 0.002, 201)
    off[0] = 0.0
    return arrays | {"t": T + off}


def smoothed_from_another_start() -> Arrays:
    """Means of the last nine samples, of a motion that starts with ω about one axis reversed."""
    start = FREE.scenario.document.start.model_dump(exclude_none=True)
    omega = (FREE.scenario.start.omega_body * [1, -1, 1]).tolist()
    arrays = right(changed(FREE, start=start | {"omega_body": omega}))
    means = [arrays["omega"][max(0, k - 8) : k + 1].mean(axis=0) for k in range(201)]
    return arrays | {"omega": np.array(means)}


def of_differences() -> Arrays:
    """ω from the turn since the sample before, as of a body in skew axes."""
    arrays = right(changed(FREE, window={"duration": 4.0, "samples": 41}))
    turned = Rotation.from_quat(arrays["q"], scalar_first=True)
    rates = (turned[:-1].inv() * turned[1:]).as_rotvec() / np.diff(arrays["t"])[:, None]
    return {name: one[1:] for name, one in arrays.items()} | {"omega": rates}


def attitudes_of(arrays: Arrays) -> Arrays:
    return {"t": arrays["t"], "q": arrays["q"]}


def struck_for_a_while() -> Arrays:
    """No gyroscopic torque of products, and a torque from 2.4 s to 2.6 s."""
    begun = of_the_diagonal()
    arrays = {name: one.copy() for name, one in begun.items()}
    parts = ((120, 131, PUSH), (130, 201, np.zeros(3)))
    for first, end, torque in parts:
        start = {
            "quaternion_wxyz": arrays["q"][first].tolist(),
            "omega_body": arrays["omega"][first].tolist(),
        }
        window = {"duration": float(T[end - 1] - T[first]), "samples": end - first}
        part = changed(FREE, start=start, window=window)
        rates = rates_of(part, gyroscopic=DIAGONAL, torque=lambda _, torque=torque: torque)
        made = exactly(part, rates)
        arrays["q"][first:end], arrays["omega"][first:end] = made["q"], made["omega"]
    return arrays


def then(arrays: Arrays, first: int, second: object, **other: object) -> Arrays:
    """A motion that goes on by other equations from a sample on."""
    start = {
        "quaternion_wxyz": arrays["q"][first].tolist(),
        "omega_body": arrays["omega"][first].tolist(),
    }
    window = {"duration": float(T[-1] - T[first]), "samples": len(T) - first}
    part = changed(second, start=start, window=window)
    made = exactly(part, rates_of(part, **other))
    return {name: np.vstack([arrays[name][:first], made[name]]) for name in ("q", "omega")} | {
        "t": arrays["t"]
    }


def filtered(arrays: Arrays, constant: float) -> Arrays:
    """ω through a low-pass filter of first order, which begins with the first sample."""
    t, omega = arrays["t"], CubicSpline(arrays["t"], arrays["omega"])
    fine = np.linspace(t[0], t[-1], 40 * (len(t) - 1) + 1)
    part, made = np.exp(-(fine[1] - fine[0]) / constant), [omega(t[0])]
    for at in (fine[1:] + fine[:-1]) / 2:
        made.append(part * made[-1] + (1 - part) * omega(at))
    return arrays | {"omega": np.array(made)[::40]}


PRODUCTS = "it moves as if the products of inertia had the other sign"
OF_DIAGONAL = "it moves as if the gyroscopic torque ω × Iω were of the tensor's diagonal alone"
LEFT: dict[str, Hidden] = {
    "other products, and an ω that lags": Hidden(
        FREE.scenario,
        lambda: lagging(of_other_products(), 0.05),
        (PRODUCTS, "ω lags the attitude by 0.05 s"),
    ),
    "other products, and rows that are lost": Hidden(
        FREE.scenario,
        lambda: without_rows(of_other_products(), 90, 4),
        (PRODUCTS, "4 samples are lost before t = 1.8 s"),
    ),
    "part of a torque, and a sample that is off": Hidden(
        FREE.scenario,
        lambda: with_one_off(of_the_diagonal()),
        (OF_DIAGONAL, "the sample at t = 2.4 s is off by 0° and 0.616 rad/s"),
    ),
    "part of a torque, and another one for a while": Hidden(
        FREE.scenario, struck_for_a_while, (OF_DIAGONAL, "from t = 2.4 s to 2.6 s it goes on other")
    ),
    "columns that are exchanged, and quaternions of eight bits": Hidden(
        FREE.scenario,
        exchanged_columns_in_eight_bits,
        ("the quaternions are rounded to 0.007874", "ω is [wy, wx, wz] of its columns"),
    ),
    "drag, and a gyroscope's scale": Hidden(
        FREE.scenario,
        slowed_and_scaled,
        ("the gyroscope's axes read [1.04, 1, 0.97] times ω", "it moves as if it were slowed by "),
    ),
    "an ω that is held, and a heavier axis": Hidden(
        FREE.scenario,
        held_of_a_heavier_axis,
        ("ω is held: it is new at one sample in 5 only", "it moves as if Ixx were "),
    ),
    "times that jitter, and half of a torque": Hidden(
        FREE.scenario,
        jittering_without_half_of_a_torque,
        ("the times jitter, by up to 2", "it moves as if the gyroscopic torque ω × Iω were 0.5 "),
    ),
    "another start, and means": Hidden(
        FREE.scenario,
        smoothed_from_another_start,
        ("it started elsewhere: at t = 0 s ", "ω is the mean over 9 samples, 0.16 s, up to each"),
    ),
    "an ω of differences": Hidden(
        FREE.scenario,
        of_differences,
        ("ω is half a sample older than the attitude",),
    ),
    "a torque that begins": Hidden(
        FREE.scenario,
        lambda: then(right(FREE), 90, FREE, torque=lambda _: PUSH),
        (
            "until t = 1.8 s it is the exact motion, to rounding; there it changes: from then on "
            "it moves as if a torque of ",
        ),
    ),
    "a torque that begins, of attitudes alone": Hidden(
        FREE.scenario,
        lambda: attitudes_of(then(right(FREE), 90, FREE, torque=lambda _: PUSH)),
        (
            "until t = 1.8 s it is the exact motion, to rounding; there it changes: from then on "
            "it moves as if a torque of ",
        ),
    ),
    "half of a torque, and a low-pass filter": Hidden(
        FREE.scenario,
        lambda: filtered(exactly(FREE, rates_of(FREE, gyroscopic=FREE.inertia / 2)), 0.05),
        (
            "it moves as if the gyroscopic torque ω × Iω were 0.5 ",
            "ω is what a low-pass filter of a time constant of 0.05 s leaves of it",
        ),
    ),
    "drag of the other sign, of attitudes alone": Hidden(
        DRAGGED.scenario,
        lambda: attitudes_of(
            exactly(DRAGGED, rates_of(DRAGGED, torque=lambda omega: DRAG * omega))
        ),
        ("it moves as if drag had the other sign",),
    ),
    "a torque that is too strong, of attitudes alone": Hidden(
        PUSHED.scenario,
        lambda: attitudes_of(exactly(PUSHED, rates_of(PUSHED, torque=lambda _: 1.4 * PUSH))),
        ("it moves as if the torque were ",),
        numbers=(1.4,),
    ),
}


@each_case("one", LEFT)
def test_what_is_left_without_a_finding_is_explained_in_turn(one: Hidden) -> None:
    check(replace(one, arrays=lambda: printed(one.arrays())))


def test_samples_that_are_wrong_are_left_out_and_the_others_kept() -> None:
    arrays = right(FREE)
    omega = arrays["omega"].copy()
    omega[[50, 90, 150]] = 0.0
    recording = Recording(Path("motion.csv"), arrays | {"omega": omega}, {})
    exact, reading = exact_at(FREE.scenario, T).trajectory, reading_of(recording)
    recorded = recorded_motion(FREE.scenario, recording, reading, exact)
    found = finding(Case(FREE.scenario, recording, reading, exact, recorded, None, 1))
    assert found is not None
    # Or else what is before the first of them.
    assert [len(left.motion.t) for left in found.left] == [198, 50]


def test_an_honest_method_has_no_beginning_that_explains_it() -> None:
    for order in (1, 2):
        made = stepped(HEAVY.scenario, rates_of(HEAVY), order, 0.01, np.random.default_rng(3))
        found = judged_motion(HEAVY.scenario, Recording(Path("motion.csv"), made, {}), order)
        assert found.explained_by == ()


def test_an_omega_of_differences_is_known_by_them() -> None:
    arrays = of_differences()
    motion = exact_at(FREE.scenario, arrays["t"]).trajectory
    assert not _differences(motion)
    (words,) = _differences(replace(motion, omega_body=arrays["omega"]))
    assert "since the sample before" in words
    later = replace(motion, omega_body=np.vstack([arrays["omega"][1:], arrays["omega"][:1]]))
    (words,) = _differences(later)
    assert "until the next sample" in words
