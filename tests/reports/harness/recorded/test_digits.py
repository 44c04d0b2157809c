"""What the numbers of a motion show by themselves is named, with counts; of honest ones nothing."""

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from reported_faults import judged
from scipy.spatial.transform import Rotation
from spincheck.reference import solve
from spincheck.scenarios import Scenario, from_tables

pytestmark = pytest.mark.slow

Arrays = dict[str, np.ndarray]
ONE = case(51, samples=101)
RIGHT = exactly(ONE, rates_of(ONE))
T = RIGHT["t"]


def rows(which: np.ndarray) -> Arrays:
    """Rows in another order, at the same times."""
    return {"t": T, "q": RIGHT["q"][which], "omega": RIGHT["omega"][which]}


def of_omega(change) -> Arrays:
    """ω, changed by a function that writes into it."""
    omega = RIGHT["omega"].copy()
    change(omega)
    return RIGHT | {"omega": omega}


def repeated(first: int, times: int) -> np.ndarray:
    """Indices of rows of which one is there that many times more, and the rest is late."""
    at = np.concatenate([np.arange(first + 1), np.full(times, first), np.arange(first + 1, 101)])
    return at[:101]


def coarse() -> np.ndarray:
    """Quaternions of two digits, whose norms are off by up to 2 %."""
    q = 0.02 * np.rint(RIGHT["q"] / 0.02)
    assert np.abs(np.linalg.norm(q, axis=1) - 1).max() > 0.01
    return q


def asleep() -> Arrays:
    q, omega = RIGHT["q"].copy(), RIGHT["omega"].copy()
    q[60:], omega[60:] = q[60], 0.0
    return {"t": T, "q": q, "omega": omega}


def zeroed(omega: np.ndarray) -> None:
    omega[[20, 45, 46, 80]] = 0.0


def frozen(omega: np.ndarray) -> None:
    omega[50:, 2] = omega[50, 2]


def dead(omega: np.ndarray) -> None:
    omega[:, 1] = 0.0


def overflown(omega: np.ndarray) -> None:
    largest = np.abs(omega[:, np.abs(omega).max(axis=0).argmax()])
    bound = (largest.min() + largest.max()) / 2
    omega[:] = (omega + bound) % (2 * bound) - bound


def without_sign() -> Arrays:
    q = RIGHT["q"] * np.sign(RIGHT["q"][:, :1])
    is_lost = RIGHT["q"][:, 0] < 0
    assert is_lost.any()
    assert not is_lost.all()
    # Of a negative qw the vector stays what it is.
    return RIGHT | {"q": np.where(is_lost[:, None], q * [1, -1, -1, -1], q)}


def across_signs() -> Arrays:
    signs = np.where(np.arange(101) // 2 % 4 < 2, 1.0, -1.0)[:, None]
    q = RIGHT["q"] * signs
    q[1:-1:2] = (q[:-2:2] + q[2::2]) / 2
    return RIGHT | {"q": q / np.linalg.norm(q, axis=1)[:, None]}


def jittered() -> Arrays:
    off = np.random.default_rng(5).uniform(-0.004, 0.004, 101)
    off[0] = 0.0
    return RIGHT | {"t": T + off}


EXCHANGED = np.arange(101)
EXCHANGED[[40, 41]] = 41, 40
HELD = RIGHT | {"q": RIGHT["q"][5 * (np.arange(101) // 5)]}
STALE = RIGHT | {
    "q": RIGHT["q"][np.where(np.isin(np.arange(101), [30, 70]), -1, 0) + np.arange(101)]
}
PLANTED = {
    "a row repeated": (
        rows(repeated(50, 1)),
        "the row at t = 2.04 s is the one before it again, to the last digit, and what follows is "
        "0.04 s late: a row is repeated",
    ),
    "a row repeated in place": (
        rows(np.where(np.arange(101) == 51, 50, np.arange(101))),
        "the row at t = 2.04 s is the one before it again, to the last digit: leave it out",
    ),
    "two rows repeated": (
        rows(np.where(np.isin(np.arange(101), [20, 51]), np.arange(101) - 1, np.arange(101))),
        "rows are those before them again, to the last digit, at 2 samples, the first at t = 0.8 "
        "s, the last at 2.04 s: leave them out",
    ),
    "a pause": (
        rows(repeated(50, 10)),
        "it stands still, to the last digit, for 10 samples, from t = 2 s to 2.4 s, and goes on "
        "from there, 0.4 s late, as a simulation that is paused while the clock runs",
    ),
    "an end that stands still": (
        rows(np.minimum(np.arange(101), 80)),
        "from t = 3.2 s on it stands still, to the last digit, for 20 samples",
    ),
    "asleep": (
        asleep(),
        "from t = 2.4 s on, for 41 samples, it is asleep: ω is exactly 0, and the attitude stays "
        "the same to the last digit",
    ),
    "attitude held": (
        HELD,
        "the attitude is held: it is new at one sample in 5 only; record those alone",
    ),
    "attitudes stale": (
        STALE,
        "the attitude is that of the sample before, to the last digit, at 2 samples, the first at "
        "t = 1.2 s, the last at 2.8 s",
    ),
    "dropouts": (
        of_omega(zeroed),
        "ω is exactly 0, though the attitude goes on turning, at 4 samples, the first at t = 0.8 "
        "s, the last at 3.2 s: leave them out",
    ),
    "a frozen column": (
        of_omega(frozen),
        f"wz is {RIGHT['omega'][50, 2]:.6g} rad/s, to the last digit, from t = 2 s on, for 51 "
        "samples, though the attitudes show it change: its column is stuck",
    ),
    "a dead column": (
        of_omega(dead),
        "wy is 0 rad/s, to the last digit, in all 101 samples, though the attitudes show it "
        "change: its column is dead",
    ),
    "rounded": (RIGHT | {"omega": np.round(RIGHT["omega"], 1)}, "ω is rounded to 0.1 rad/s"),
    "rounded degrees": (
        RIGHT | {"omega": np.radians(5 * np.round(np.degrees(RIGHT["omega"]) / 5))},
        "ω is rounded to 5 deg/s",
    ),
    "a coarse quaternion": (RIGHT | {"q": coarse()}, "the quaternions are rounded to 0.02"),
    "times of a coarse clock": (
        RIGHT | {"t": np.rint(512 * T) / 512},
        "the times are rounded to 0.00195312 s: samples are 1/25 s apart",
    ),
    "wrapped": (of_omega(overflown), "ω wraps around, off by "),
    "a lost sign": (without_sign(), "the sign of qw is lost, it is never negative: conjugating "),
    "across signs": (across_signs(), "attitudes are interpolated between quaternions of opposite "),
    "exchanged": (rows(EXCHANGED), "the rows at t = 1.6 s and 1.64 s are exchanged"),
    "jitter": (jittered(), "the times jitter, by up to 4"),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_what_the_numbers_show_is_named_with_its_count(fault: str) -> None:
    arrays, words = PLANTED[fault]
    found = judged(ONE.scenario, arrays, 1e-4)
    (said,) = found.explained_by
    assert said.startswith(words)


def test_mistakes_before_what_the_numbers_show_are_named_too() -> None:
    in_world = Rotation.from_quat(RIGHT["q"], scalar_first=True).apply(RIGHT["omega"])
    at = repeated(50, 10)
    arrays = {"t": T, "q": RIGHT["q"][at], "omega": in_world[at]}
    still, world = judged(ONE.scenario, arrays, 1e-4).explained_by
    assert still.startswith("it stands still")
    assert world == "ω is in world axes (state 'omega = world')"


def test_two_faults_of_the_numbers_are_both_named() -> None:
    arrays = of_omega(zeroed) | {"q": STALE["q"]}
    stale, zeros = judged(ONE.scenario, arrays, 1e-4).explained_by
    assert stale.startswith("the attitude is that of the sample before, to the last digit, at 2")
    assert zeros.startswith("ω is exactly 0, though the attitude goes on turning, at 4")


def test_every_wrong_sample_is_counted() -> None:
    (zeros,) = np.nonzero(RIGHT["q"][:, 0] < 0)
    (said,) = judged(ONE.scenario, without_sign(), 1e-4).explained_by
    assert f"conjugating {len(zeros)} of 101 samples" in said or (
        f"conjugating {101 - len(zeros)} of 101 samples" in said
    )
    arrays = of_omega(overflown)
    wrong = np.flatnonzero(np.abs(arrays["omega"] - RIGHT["omega"]).max(axis=1) > 1)
    (said,) = judged(ONE.scenario, arrays, 1e-4).explained_by
    assert f"at {len(wrong)} samples" in said


@pytest.mark.parametrize("digits", [3, 17])
def test_a_gyroscope_saturates_just_below_the_largest_rate(digits: int) -> None:
    scene = body([0.3, 0.5, 2.0], [1.0, 2.0, 2.2])
    motion = solve(scene, np.linspace(0.0, 10.0, 301)).trajectory
    read = np.vectorize(lambda x: float(f"{x:.{digits}g}"), otypes=[float])
    omega = read(np.clip(motion.omega_body, -1.99, 1.99))
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": omega}
    (words, *_) = judged(scene, arrays, None).explained_by
    assert words.startswith("the gyroscope saturates: each component of ω is clamped to 1.99 rad/s")


@pytest.mark.parametrize("decimals", [4, 6])
def test_uneven_times_are_told_where_rounding_hides_the_change_of_omega(decimals: int) -> None:
    scene = body([1e-5, 0.0, 2.0], [2.0, 2.0, 3.0])
    even, chance = np.linspace(0.0, 4.0, 201), np.random.default_rng(0)
    true = np.concatenate([[0.0], np.cumsum(chance.uniform(0.5, 1.5, 200))])
    motion = solve(scene, 4.0 * true / true[-1]).trajectory
    omega = np.round(motion.omega_body, decimals)
    arrays = {"t": even, "q": np.round(motion.q_world_body_wxyz, 9), "omega": omega}
    (words,) = judged(scene, arrays, None).explained_by
    assert words.startswith("each state is that of another time")


def body(omega: list[float], moments: list[float]) -> Scenario:
    """A body in its own axes that turns freely."""
    tables = {
        "title": "Honest",
        "source": "made up",
        "body": {"mass": 1.0, "inertia": np.diag(moments).tolist()},
        "start": {"quaternion_wxyz": [1.0, 0.0, 0.0, 0.0], "omega_body": omega},
        "window": {"duration": 2.0, "samples": 51},
    }
    return from_tables(tables, "honest")


def printed(arrays: Arrays, digits: int) -> Arrays:
    """Numbers of so many digits."""
    short = {
        name: np.vectorize(lambda x: float(f"{x:.{digits}g}"))(arrays[name])
        for name in ("q", "omega")
    }
    return arrays | short


HONEST = {
    "a sphere": body([0.3, 0.0, 2.0], [1.0, 1.0, 1.0]),
    "at rest": body([0.0, 0.0, 0.0], [1.0, 1.1, 1.2]),
    "a sleeping top": body([0.0, 0.0, 2.0], [1.0, 1.0, 1.5]),
    "a symmetric body": body([0.4, 0.0, 2.0], [1.0, 1.0, 1.5]),
    "any body": body([0.4, -0.3, 2.0], [1.0, 1.2, 1.5]),
    "slow": body([4e-4, -3e-4, 2e-3], [1.0, 1.2, 1.5]),
}


@pytest.mark.parametrize("which", HONEST)
@pytest.mark.parametrize("how", ["in full", "5 digits", "3 digits", "single", "qw positive"])
def test_an_honest_motion_is_not_accused(which: str, how: str) -> None:
    scene = HONEST[which]
    motion = solve(scene, scene.times).trajectory
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    arrays = {name: np.array(numbers) for name, numbers in arrays.items()}
    if how.endswith("digits"):
        arrays = printed(arrays, int(how[0]))
    elif how == "single":
        arrays |= {name: arrays[name].astype(np.float32).astype(float) for name in ("q", "omega")}
    elif how == "qw positive":
        arrays["q"] = arrays["q"] * np.where(arrays["q"][:, :1] < 0, -1.0, 1.0)
    found = judged(scene, arrays, 1e-4)
    assert found.explained_by == ()
