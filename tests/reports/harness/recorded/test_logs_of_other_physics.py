"""Logs with noise are explained by the same changes of the equations as computed motions."""

import re
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from hidden import NOISY, Hidden, changed, check, noisy, right
from planted_motions import Rates, case, cross, exactly, rates_of
from reported_faults import Arrays
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.scenarios import Scenario

pytestmark = pytest.mark.slow

FREE, HEAVY = case(303, samples=101), case(402, is_pivoted=True, samples=101)
#: A body, and a torque along each axis, N m, which an eighth of its log does not tell from others.
LONG, SMALL = case(324, samples=1001), 2e-4
MOMENT = float(np.trace(FREE.inertia)) / 3
SPEED = float(np.linalg.norm(FREE.scenario.start.omega_body))
#: A tensor whose products of inertia have the other sign, and drag, N m s.
OTHER = FREE.inertia * (2 * np.eye(3) - 1)
DRAGGED = changed(FREE, effects={"drag": {"rotational": 0.1 * MOMENT}})
#: What half as many samples do not tell from other changes.
FINE = case(303, samples=201)
FINE_DRAGGED = changed(FINE, effects={"drag": {"rotational": 0.1 * MOMENT}})
RATE = 0.15
CROSSED = np.eye(3) + np.outer([0, 0, 1], [0.08, 0, 0])


def with_omega(arrays: Arrays, matrix: np.ndarray) -> Arrays:
    return arrays | {"omega": arrays["omega"] @ matrix.T}


def with_a_world_torque_for_gravity() -> Arrays:
    """The arm of gravity is not turned with the body, so that its torque is constant in space."""
    return exactly(HEAVY, rates_of_a_world_torque())


def rates_of_a_world_torque() -> Rates:
    torque = np.cross(HEAVY.com, HEAVY.scenario.body.mass * HEAVY.gravity)

    def rates(q: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turning, accelerated = rates_of(HEAVY, scale=0.0)(q, omega)
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        return turning, accelerated + np.linalg.solve(HEAVY.inertia, R.T @ torque)

    return rates


def by_semi_implicit_euler(rates: Rates, steps: int) -> Arrays:
    """Attitudes alone of so many steps from sample to sample, ω first."""
    times, start = HEAVY.scenario.times, HEAVY.scenario.start
    y, rows, h = np.array([*start.q_world_body_wxyz, *start.omega_body]), [], times[1] / steps
    for _ in times:
        rows.append(y[:4])
        for _ in range(steps):
            omega = y[4:] + h * rates(y[:4], y[4:])[1]
            q = y[:4] + h * rates(y[:4], omega)[0]
            y = np.concatenate([q / np.linalg.norm(q), omega])
    return {"t": times.copy(), "q": np.array(rows)}


def with_torques_unturned() -> Arrays:
    """The torque of gravity is right along world axes, and taken for one along the body's."""

    def rates(q: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turning, accelerated = rates_of(HEAVY, scale=0.0)(q, omega)
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        torque = cross(R @ HEAVY.com, HEAVY.scenario.body.mass * HEAVY.gravity)
        return turning, accelerated + np.linalg.solve(HEAVY.inertia, torque)

    return exactly(HEAVY, rates)


def slowed_by_a_rate() -> Arrays:
    """L is slowed at a rate, in place of ω by a torque."""
    return exactly(DRAGGED, rates_of(DRAGGED, torque=lambda omega: -RATE * DRAGGED.inertia @ omega))


def dragged_by_a_power() -> Arrays:
    """A drag in proportion to ‖ω‖^1.5."""

    def torque(omega: np.ndarray) -> np.ndarray:
        return -0.05 * MOMENT * np.sqrt(np.linalg.norm(omega)) * omega

    return exactly(FINE_DRAGGED, rates_of(FINE_DRAGGED, torque=torque))


def attitudes_of(arrays: Arrays) -> Arrays:
    return {"t": arrays["t"], "q": arrays["q"]}


def rows_of_uneven_times() -> Arrays:
    """Attitudes of times that jitter about those that are recorded."""
    times = np.linspace(0, 4, 4001)
    fine = right(changed(FREE, window={"duration": 4.0, "samples": 4001}))
    off = np.random.default_rng(3).integers(-4, 5, 200)
    taken = np.array([0, *(20 * np.arange(1, 201) + np.where(np.arange(200) < 199, off, 0))])
    return {"t": times[::20], "q": fine["q"][taken]}


def a_little_late(arrays: Arrays, seconds: float) -> Arrays:
    """Attitudes of the exact motion some time after the recorded times."""
    t = arrays["t"] - seconds
    return {"t": t[t >= 0], "q": arrays["q"][t >= 0]}


START = changed(
    FREE,
    start={
        "quaternion_wxyz": FREE.scenario.start.q_world_body_wxyz.tolist(),
        "omega_body": (FREE.scenario.start.omega_body * [0.94, 1.03, 1]).tolist(),
    },
)
LOGS: dict[str, Hidden] = {
    "products of the other sign": Hidden(
        FREE.scenario,
        lambda: noisy(exactly(FREE, rates_of(FREE, inertia=OTHER))),
        ("it moves as if the products of inertia had the other sign",),
        NOISY,
    ),
    "half of the gyroscopic torque, without stated noise": Hidden(
        FREE.scenario,
        lambda: noisy(exactly(FREE, rates_of(FREE, gyroscopic=FREE.inertia / 2))),
        ("it moves as if the gyroscopic torque ω × Iω were ",),
        numbers=(0.5,),
    ),
    "torques along other axes": Hidden(
        HEAVY.scenario,
        lambda: noisy(with_torques_unturned()),
        ("it moves as if gravity's torque along world axes were along the body's",),
        NOISY,
    ),
    "an arm that is not turned, and a gyroscope's scale": Hidden(
        HEAVY.scenario,
        lambda: noisy(with_omega(with_a_world_torque_for_gravity(), np.diag([0.95, 1, 1.04]))),
        (
            "it moves as if there were no gravity",
            "it moves as if a torque of ",
            "the gyroscope's axes read ",
        ),
        NOISY,
    ),
    "a rate for drag, and a cross-axis sensitivity": Hidden(
        DRAGGED.scenario,
        lambda: noisy(with_omega(slowed_by_a_rate(), CROSSED)),
        (
            "it moves as if L were slowed by ",
            "the gyroscope has a cross-axis sensitivity: ",
        ),
        NOISY,
        numbers=(RATE,),
    ),
    "drag of another power": Hidden(
        FINE_DRAGGED.scenario,
        lambda: noisy(dragged_by_a_power()),
        ("it moves as if drag were ",),
        NOISY,
        numbers=(0.05 * MOMENT, 1.5),
        to=0.03,
    ),
    "a torque that only all samples of a long log show": Hidden(
        LONG.scenario,
        lambda: noisy(exactly(LONG, rates_of(LONG, torque=lambda _: SMALL * np.array([1, -1, 1])))),
        ("it moves as if a torque of ",),
        NOISY,
        numbers=(SMALL, -SMALL, SMALL),
        to=SMALL / 2,
    ),
    "another start, of attitudes alone": Hidden(
        FREE.scenario,
        lambda: attitudes_of(noisy(right(START))),
        ("it started elsewhere: at t = 0 s ",),
    ),
    # From −4 to 4 ms, of which the standard deviation is √(80/12) ms.
    "times that jitter, of attitudes alone": Hidden(
        FREE.scenario, rows_of_uneven_times, ("the times are off by 0.0026 s",)
    ),
    "attitudes that are early": Hidden(
        FINE.scenario,
        lambda: noisy_attitudes(a_little_late(right(FINE), 0.05)),
        ("each state is that of ",),
        numbers=(0.05,),
    ),
}


def noisy_attitudes(arrays: Arrays) -> Arrays:
    return attitudes_of(noisy(arrays | {"omega": np.zeros((len(arrays["t"]), 3))}))


@each_case("one", LOGS)
def test_a_log_is_explained_by_other_equations(one: Hidden) -> None:
    check(one)


def test_a_tensor_is_given_only_beside_what_explains_the_log() -> None:
    for name, is_given in {
        "products of the other sign": True,
        "half of the gyroscopic torque, without stated noise": False,
    }.items():
        one = LOGS[name]
        recording = Recording(Path("motion.csv"), one.arrays(), one.stated)
        measured = judged_motion(one.scene, recording).measured
        assert measured is not None
        assert measured.tensor_in_words().startswith("No tensor is given") != is_given


def test_a_tensor_that_is_no_special_one_stays_a_tensor() -> None:
    tensor = FREE.inertia + MOMENT * np.array([[0.05, 0.03, 0], [0.03, -0.04, 0.02], [0, 0.02, 0]])
    arrays = noisy(exactly(FREE, rates_of(FREE, inertia=tensor)))
    check(Hidden(FREE.scenario, lambda: arrays, ("it moves as if the tensor were ",), NOISY))


def assert_right(scene: Scenario, arrays: Arrays, stated: dict[str, str]) -> None:
    found = judged_motion(scene, Recording(Path("motion.csv"), arrays, stated))
    assert found.explained_by == ()
    assert not found.is_beyond


def test_right_logs_stay_right() -> None:
    for one in (FREE, HEAVY, DRAGGED):
        for stated in (NOISY, {}):
            assert_right(one.scenario, noisy(right_of(one)), stated)
    assert_right(START.scenario, attitudes_of(noisy(right(START))), {})


def right_of(one: object) -> Arrays:
    if one is DRAGGED:
        drag = 0.1 * MOMENT
        return exactly(one, rates_of(one, torque=lambda omega: -drag * omega))
    return right(one)


def test_a_lower_order_than_the_stated_one_is_named_beside_a_change() -> None:
    arrays = by_semi_implicit_euler(rates_of_a_world_torque(), 20)
    recording = Recording(Path("motion.csv"), arrays, {"timestep": "0.001"})
    gravity, torque, order = judged_motion(HEAVY.scenario, recording, 4).explained_by
    assert gravity == "it moves as if there were no gravity"
    x, y, z = np.cross(HEAVY.com, HEAVY.scenario.body.mass * HEAVY.gravity)
    wanted = [float(number) for number in re.findall(r"-?\d+\.\d+(?:e-\d+)?", torque)]
    assert wanted == pytest.approx([x, y, z], abs=5e-3 * max(abs(x), abs(y)))
    assert order.startswith("its method is of order 1, not 4")
