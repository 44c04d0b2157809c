"""Two faults at once, and faults that only all of a log, or a guessed timestep, shows."""

from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from hidden import NOISY, Hidden, changed, check, noisy, right
from planted_motions import case, exactly, product, rates_of, stepped
from reported_faults import Arrays
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import judged_motion

pytestmark = pytest.mark.slow

FREE = case(324, samples=101)
OTHER_PRODUCTS = FREE.inertia * (2 * np.eye(3) - 1)
PUSH, LATE = np.array([0.5, -0.9, 0.7]), 1.6
#: A dipole, body axes, in a field, world axes: their product is a torque, N m.
DIPOLE, FIELD = np.array([0.0, 0.0, 0.04]), np.array([0.6, 0.0, -0.8])
#: Steps of a method from sample to sample.
STEPS = 4


def crossed(angle: float) -> Arrays:
    """ω as a gyroscope reads it whose axes are turned about y."""
    arrays = right(FREE)
    return arrays | {"omega": Rotation.from_rotvec([0, angle, 0]).apply(arrays["omega"])}


def picking_up() -> Arrays:
    arrays = right(FREE)
    omega = arrays["omega"].copy()
    omega[:, 2] += 0.012 * omega[:, 0]
    return arrays | {"omega": omega}


def conjugated() -> Arrays:
    arrays = exactly(FREE, rates_of(FREE, inertia=OTHER_PRODUCTS))
    return arrays | {"q": arrays["q"] * [1, -1, -1, -1]}


def late_on_the_wrong_side() -> Arrays:
    """q' = ½ ω q, with ω of a body that the scene's torque pushes from a time on."""
    t, inertia = FREE.scenario.times, FREE.inertia

    def slopes(time: float, state: np.ndarray) -> np.ndarray:
        q, omega = state[:4], state[4:]
        torque = PUSH * (time >= LATE)
        accelerated = np.linalg.solve(inertia, torque - np.cross(omega, inertia @ omega))
        return np.concatenate([product(np.array([0, *omega]), q) / 2, accelerated])

    begun = np.concatenate([FREE.scenario.start.q_world_body_wxyz, FREE.scenario.start.omega_body])
    states = begun[None]
    for part in (t[t <= LATE], t[t >= LATE]):
        found = solve_ivp(
            *(slopes, (part[0], part[-1]), states[-1], "DOP853", part),
            rtol=1e-12,
            atol=1e-12,
        )
        states = np.vstack([states[:-1], found.y.T])
    q = states[:, :4] / np.linalg.norm(states[:, :4], axis=1)[:, None]
    return {"t": t, "q": q, "omega": states[:, 4:]}


def in_a_field() -> Arrays:
    def torque(q: np.ndarray) -> np.ndarray:
        return np.cross(DIPOLE, Rotation.from_quat(q, scalar_first=True).inv().apply(FIELD))

    usual = rates_of(FREE)

    def rates(q: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turning, accelerated = usual(q, omega)
        return turning, accelerated + np.linalg.solve(FREE.inertia, torque(q))

    return noisy(exactly(FREE, rates))


def without_seven_rows() -> Arrays:
    """Attitudes alone, from which rows are lost while the times go on."""
    arrays = right(changed(FREE, window={"duration": 4.28, "samples": 108}))
    kept = np.r_[0:40, 47:108]
    return {"t": arrays["t"][:101], "q": arrays["q"][kept]}


def rounded_times() -> Arrays:
    """A heavier axis, and times of 30 Hz in ms."""
    tensor = FREE.inertia.copy()
    tensor[1, 1] *= 1.01
    arrays = exactly(THIRTY, rates_of(FREE, inertia=tensor))
    return arrays | {"t": arrays["t"].round(3)}


def filtered_from_the_start() -> Arrays:
    """A low-pass filter of 0.1 s that begins with the log."""
    arrays, constant = right(FREE), 0.1
    fine = right(changed(FREE, window={"duration": 4.0, "samples": 4001}))
    made, kept = [fine["omega"][0]], np.exp(-np.diff(fine["t"]) / constant)
    for before, after, part in zip(fine["omega"][:-1], fine["omega"][1:], kept, strict=True):
        made.append(part * made[-1] + (1 - part) * (before + after) / 2)
    return noisy(arrays | {"omega": np.array(made)[::40]})


def by(order: int) -> Arrays:
    """A method of an order, by a few steps from sample to sample."""
    h = float(FREE.scenario.times[1]) / STEPS
    return stepped(FREE.scenario, rates_of(FREE), order, h, np.random.default_rng(5))


def by_the_midpoint_rule() -> Arrays:
    """As `by` with order 2, by the rule that is known by name."""
    rates, states = rates_of(FREE), []
    y = np.concatenate([FREE.scenario.start.q_world_body_wxyz, FREE.scenario.start.omega_body])
    h = float(FREE.scenario.times[1]) / STEPS
    for _ in FREE.scenario.times:
        states.append(y)
        for _ in range(STEPS):
            half = y + h / 2 * np.concatenate(rates(y[:4], y[4:]))
            y = y + h * np.concatenate(rates(half[:4], half[4:]))
            y[:4] /= np.linalg.norm(y[:4])
    table = np.array(states)
    return {"t": FREE.scenario.times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


def in_world_axes() -> Arrays:
    arrays = by_the_midpoint_rule()
    turn = Rotation.from_quat(arrays["q"], scalar_first=True)
    return arrays | {"omega": turn.apply(arrays["omega"])}


def capped_and_damped() -> Arrays:
    """The midpoint rule with a largest ‖ω‖ that is reached late, and L slowed by 0.01 /s."""
    rates = rates_of(SWINGING, torque=lambda omega: -0.01 * SWINGING.inertia @ omega)
    q, omega = SWINGING.scenario.start.q_world_body_wxyz, SWINGING.scenario.start.omega_body
    bound, rows = 0.94 * float(np.linalg.norm(right(SWINGING)["omega"], axis=1).max()), []
    for _ in SWINGING.scenario.times:
        rows.append(np.concatenate([q, omega]))
        for _ in range(40):
            turning, accelerated = rates(q, omega)
            turning, accelerated = rates(q + 5e-4 * turning, omega + 5e-4 * accelerated)
            q, omega = q + 1e-3 * turning, omega + 1e-3 * accelerated
            q, omega = q / np.linalg.norm(q), omega * min(1.0, bound / np.linalg.norm(omega))
    table = np.array(rows)
    return {"t": SWINGING.scenario.times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


def of_eight_bits() -> Arrays:
    arrays = right(FREE)
    return arrays | {"q": np.rint(127 * arrays["q"]) / 127}


def one_column_cut() -> Arrays:
    """wx at four fifths of its largest value, and the other columns beyond it."""
    arrays = right(FREE)
    omega, column = arrays["omega"].copy(), int(np.abs(arrays["omega"]).max(axis=0).argmin())
    bound = 0.8 * float(np.abs(omega[:, column]).max())
    omega[:, column] = np.clip(omega[:, column], -bound, bound)
    return arrays | {"omega": omega}


def trailing_means() -> Arrays:
    """ω as the mean of thirteen samples up to each."""
    arrays = right(changed(FREE, window={"duration": 4.48, "samples": 113}))
    means = [arrays["omega"][k - 12 : k + 1].mean(axis=0) for k in range(12, 113)]
    return {"t": arrays["t"][12:], "q": arrays["q"][12:], "omega": np.array(means)}


def of_drag_in_air() -> Arrays:
    """Quadratic drag, in noise."""
    rates = rates_of(FREE, torque=lambda omega: -AIR * np.linalg.norm(omega) * omega)
    return noisy(exactly(FREE, rates))


def with_a_glitch() -> Arrays:
    """Attitudes alone, one of them off by 5 degrees."""
    arrays = right(FREE)
    q = arrays["q"].copy()
    turn = Rotation.from_rotvec(np.radians([3.0, 4.0, 0.0]))
    q[60] = (Rotation.from_quat(q[60], scalar_first=True) * turn).as_quat(scalar_first=True)
    return {"t": arrays["t"], "q": q}


def halted() -> Arrays:
    """A body without the scene's drag, whose rows repeat for a while."""
    arrays = right(FREE)
    kept = np.r_[0:70, [70] * 8, 78:101]
    return {"t": arrays["t"], "q": arrays["q"][kept], "omega": arrays["omega"][kept]}


#: A body whose ‖ω‖ rises by an eighth only after half of a second.
SWINGING = case(276, samples=151, duration=6.0)
#: The coefficient of a quadratic drag, N m s².
AIR = 0.05
DRAGGED = changed(FREE, effects={"drag": {"rotational": 0.1}})
THIRTY = changed(FREE, window={"duration": 4.0, "samples": 121})
#: The timestep of `by`, s.
TIMESTEP = float(FREE.scenario.times[1]) / STEPS
PAIRS = {
    "a gyroscope that is turned": Hidden(
        FREE.scenario,
        lambda: crossed(np.radians(0.8)),
        ("the gyroscope's axes are turned against the body's by [",),
        numbers=(0.0, -0.8, 0.0),
        to=1e-6,
    ),
    "a gyroscope's cross-axis sensitivity": Hidden(
        FREE.scenario,
        picking_up,
        ("the gyroscope has a cross-axis sensitivity: ",),
        numbers=(0.0, 0.0, 0.0, 0.0, 0.012, 0.0),
        to=1e-6,
    ),
    "conjugated, and other products": Hidden(
        FREE.scenario,
        conjugated,
        (
            "the quaternion takes world to body components (it is conjugated)",
            "it moves as if the products of inertia had the other sign",
        ),
    ),
    "a torque that is late, and a product on the wrong side": Hidden(
        changed(FREE, effects={"torque": {"body": PUSH.tolist()}}).scenario,
        late_on_the_wrong_side,
        (
            "ω obeys Euler's equations, but the attitude does not follow ω: q' = ½ ω q",
            # Of a hundred intervals sixty are looked at: the last of them before 1.6 s ends then.
            "it moves as if there were no torque until t = 1.56 s",
        ),
    ),
    "a dipole in a field, in noise": Hidden(
        FREE.scenario,
        in_a_field,
        ("it moves as if a torque by the attitude, ",),
        NOISY,
        numbers=(float(np.linalg.norm(DIPOLE)),),
    ),
    "rows that are lost, of attitudes alone": Hidden(
        FREE.scenario, without_seven_rows, ("7 samples are lost before t = 1.6 s",)
    ),
    "rounded times, and a heavier axis": Hidden(
        THIRTY.scenario,
        rounded_times,
        ("the times are rounded to 0.001 s: samples are 1/30 s apart", "it moves as if Iyy were "),
    ),
    "a filter that begins with the log": Hidden(
        FREE.scenario,
        filtered_from_the_start,
        ("ω is what a low-pass filter of a time constant of ",),
        NOISY,
        numbers=(0.1,),
        to=2e-3,
    ),
    "order 1 within the error of order 2": Hidden(
        FREE.scenario,
        lambda: by(1),
        ("its method is of order 1, not 2: ",),
        {"timestep": repr(TIMESTEP)},
        2,
    ),
    "another timestep than is stated": Hidden(
        FREE.scenario,
        by_the_midpoint_rule,
        ("its timestep is not the stated 0.001 s", "what the midpoint rule at 0.01 s makes"),
        {"timestep": "0.001"},
        2,
    ),
    "a largest ‖ω‖ that is reached late, and damping": Hidden(
        SWINGING.scenario,
        capped_and_damped,
        ("‖ω‖ is clamped to ", "it moves as if L were slowed by 0.01 /s"),
    ),
    "quaternions of eight bits": Hidden(
        FREE.scenario, of_eight_bits, ("the quaternions are rounded to 0.007874",)
    ),
    "a gyroscope that saturates in one column": Hidden(
        FREE.scenario, one_column_cut, ("the gyroscope saturates: w",)
    ),
    "a mean of the last thirteen samples": Hidden(
        FREE.scenario, trailing_means, ("ω is the mean over 13 samples, 0.48 s, up to each",)
    ),
    "drag in air, in noise": Hidden(
        FREE.scenario,
        of_drag_in_air,
        ("it moves as if drag were ",),
        NOISY,
        numbers=(AIR,),
    ),
    "an attitude that is off, of attitudes alone": Hidden(
        FREE.scenario, with_a_glitch, ("the sample at t = 2.4 s is off by 5°",)
    ),
    "rows that repeat, and no drag": Hidden(
        DRAGGED.scenario,
        halted,
        ("it stands still, to the last digit, for 7 samples, ", "it moves as if there were no dr"),
    ),
    "ω along the world's axes, and a timestep that is not stated": Hidden(
        FREE.scenario,
        in_world_axes,
        ("ω is in world axes", "what the midpoint rule at 0.01 s makes"),
    ),
    "a timestep that is not stated": Hidden(
        FREE.scenario, by_the_midpoint_rule, ("what the midpoint rule at 0.01 s makes",)
    ),
}


@each_case("one", PAIRS)
def test_two_faults_and_faults_that_all_of_a_log_shows_are_named(one: Hidden) -> None:
    check(one)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_a_method_of_the_stated_order_has_no_other_one(order: int) -> None:
    stated = {"timestep": repr(TIMESTEP)}
    found = judged_motion(FREE.scenario, Recording(Path("motion.csv"), by(order), stated), order)
    assert not found.explained_by
    assert not found.is_beyond
