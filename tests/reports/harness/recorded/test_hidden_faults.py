"""Faults that are as small as a method's error, or hidden by noise, are named all the same.

They are those of an outsider's logs, exporters and engines, made here with nothing of what explains
them.
"""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from hidden import NOISE, NOISY, Hidden, changed, check, noisy, right, rounded
from planted_motions import Case, Rates, case, exactly, product, rates_of
from reported_faults import WHEEL, Arrays, euler, recorded, turning
from scipy.integrate import solve_ivp
from scipy.interpolate import interp1d
from scipy.spatial.transform import Rotation
from spincheck.reference.other_equations import equations_of
from spincheck.reports.harness.recorded.files.exact_at import exact_at
from spincheck.reports.harness.recorded.files.motion import reading_of, recorded_motion
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.fits.log import log_of
from spincheck.reports.harness.recorded.fits.measured import Measured
from spincheck.reports.harness.recorded.fits.since import since_when
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.scenarios import Scenario, from_tables

pytestmark = pytest.mark.slow


def symmetric() -> Case:
    """A body with two equal moments, along its axes."""
    one, inertia = case(324, samples=101), np.diag([2.0, 2.0, 1.0])
    document = one.scenario.document.model_dump(mode="json", exclude_none=True)
    document["body"]["inertia"] = [2.0, 2.0, 1.0]
    return replace(one, scenario=from_tables(document, "symmetric"), inertia=inertia)


def dragged() -> Case:
    """A body with drag."""
    one = case(324, samples=101)
    document = one.scenario.document.model_dump(mode="json", exclude_none=True)
    effects = {"drag": {"rotational": DRAG}}
    return replace(one, scenario=from_tables(document | {"effects": effects}, "dragged"))


#: Of a body with drag, N m s.
DRAG = 0.3
FREE, HEAVY = case(324, samples=101), case(322, is_pivoted=True, duration=2.0)
DRAGGED = dragged()
TOP, SPINNING = case(323, is_pivoted=True, duration=2.0), symmetric()
#: The scene's torque of a body with a thruster, N m, body axes.
PUSH = [0.3, -0.4, 0.2]
#: The axial moment of a rotor, kg m², and its spin, rad/s: no faster than the body turns.
AXIAL, SPIN = 0.2, 6.0


def dry_friction() -> Arrays:
    return rounded(exactly(HEAVY, rates_of(HEAVY, torque=lambda _: np.array([0, 0, -0.02]))))


def damped() -> Arrays:
    """L slowed at a rate, as by an engine's angular damping, in place of drag."""
    return exactly(DRAGGED, rates_of(DRAGGED, torque=lambda w: -0.2 * DRAGGED.inertia @ w))


def turned_too_early() -> Arrays:
    """ω by the midpoint rule, and the attitude by what ω was a quarter of a step too early."""
    rates, h, start = rates_of(TOP), float(TOP.scenario.times[1]) / 5, TOP.scenario.start
    q, omega, rows = start.q_world_body_wxyz, start.omega_body, []
    for _ in TOP.scenario.times:
        rows.append(np.concatenate([q, omega]))
        for _ in range(5):
            turns, accelerated = rates(q, omega)
            turn = Rotation.from_rotvec(h * (omega + h / 4 * accelerated))
            omega = omega + h * rates(q + h / 2 * turns, omega + h / 2 * accelerated)[1]
            q = (Rotation.from_quat(q, scalar_first=True) * turn).as_quat(scalar_first=True)
    table = np.array(rows)
    return {"t": TOP.scenario.times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


def game_engine() -> Arrays:
    """Semi-implicit Euler, damped by 0.05 /s and without the gyroscopic term."""
    inertia, h = FREE.inertia, float(FREE.scenario.times[1])
    rates = rates_of(FREE, gyroscopic=0 * inertia, torque=lambda w: -0.05 * inertia @ w)
    q, omega = FREE.scenario.start.q_world_body_wxyz, FREE.scenario.start.omega_body
    rows = []
    for _ in FREE.scenario.times:
        rows.append((q, omega))
        omega = omega + h * rates(q, omega)[1]
        turn = Rotation.from_rotvec(h * omega)
        q = (Rotation.from_quat(q, scalar_first=True) * turn).as_quat(scalar_first=True)
    qs, omegas = (np.array(column) for column in zip(*rows, strict=True))
    return {"t": FREE.scenario.times.copy(), "q": qs, "omega": omegas}


def by_one_stage() -> Arrays:
    """ω by many steps, and an attitude by explicit Euler."""
    arrays = right(FREE)
    q, h, rows = arrays["q"][0], float(arrays["t"][1]), [arrays["q"][0]]
    for omega in arrays["omega"][:-1]:
        q = q + h / 2 * product(q, np.array([0, *omega]))
        q = q / np.linalg.norm(q)
        rows.append(q)
    return arrays | {"q": np.array(rows)}


def smoothed() -> Arrays:
    """Each attitude goes a third of the way from the one before to the body's."""
    arrays = right(FREE)
    turns = Rotation.from_quat(arrays["q"], scalar_first=True)
    rows = [turns[0]]
    for one in turns[1:]:
        rows.append(rows[-1] * Rotation.from_rotvec((rows[-1].inv() * one).as_rotvec() / 3))
    return arrays | {"q": Rotation.concatenate(rows).as_quat(scalar_first=True)}


def between_keys() -> Arrays:
    """Straight lines between every fourth attitude."""
    arrays = right(FREE)
    q = (
        arrays["q"]
        * np.sign(np.cumprod([1, *np.sum(arrays["q"][1:] * arrays["q"][:-1], axis=1)]))[:, None]
    )
    made = interp1d(arrays["t"][::4], q[::4], axis=0)(arrays["t"])
    return arrays | {"q": made / np.linalg.norm(made, axis=1)[:, None]}


def three_of_ten_bits() -> Arrays:
    """The three smaller components are rounded, and the largest follows from them."""
    arrays, unit = right(FREE), np.sqrt(2) / 1023
    q = arrays["q"].copy()
    for row in q:
        k = int(np.abs(row).argmax())
        others = np.arange(4) != k
        row[others] = np.rint(row[others] / unit) * unit
        row[k] = np.sign(row[k]) * np.sqrt(1 - np.sum(row[others] ** 2))
    return arrays | {"q": q}


def clock_set() -> Arrays:
    arrays = right(FREE)
    return arrays | {"t": arrays["t"] + 0.3 * (np.arange(len(arrays["t"])) > 60)}


def filled() -> Arrays:
    """Two gaps of a measured motion, filled by lines."""
    arrays = rounded(noisy(right(FREE)))
    for a, b in (20, 28), (61, 66):
        part = np.linspace(0, 1, b - a + 1)[:, None]
        for name in "q", "omega":
            arrays[name][a : b + 1] = (1 - part) * arrays[name][a] + part * arrays[name][b]
    return arrays


def drifting() -> Arrays:
    arrays = noisy(right(FREE))
    return arrays | {"omega": arrays["omega"] + np.outer(arrays["t"], [0, 0, 0.02])}


def of_turned_markers() -> Arrays:
    arrays = noisy(right(FREE))
    turn = Rotation.from_euler("x", 3, degrees=True)
    q = (Rotation.from_quat(arrays["q"], scalar_first=True) * turn).as_quat(scalar_first=True)
    return arrays | {"q": q}


def late_attitudes() -> Arrays:
    """Attitudes of 0.05 s before."""
    document = HEAVY.scenario.document.model_dump(mode="json", exclude_none=True)
    window = {"duration": 2.0, "samples": 801}
    fine = right(replace(HEAVY, scenario=from_tables(document | {"window": window}, "fine")))
    at = np.arange(20, 801, 4)
    return noisy({"t": fine["t"][at], "q": fine["q"][at - 20], "omega": fine["omega"][at]})


def slower_wheels() -> Arrays:
    e = equations_of(WHEEL)
    inertia, h = np.array(e.inertia), 0.9 * np.array(e.kept)
    rates = euler(inertia, lambda R, omega: np.cross(h, R.T @ omega))
    return noisy(recorded(*turning(WHEEL, rates)))


def knocked(inertia: np.ndarray) -> Arrays:
    """The motion, but from 2 s on with another ω, of a body with this tensor."""
    arrays, at = right(FREE), 50
    start = {
        "quaternion_wxyz": arrays["q"][at].tolist(),
        "omega_body": (arrays["omega"][at] + [0.3, -0.2, 0.25]).tolist(),
    }
    document = FREE.scenario.document.model_dump(mode="json", exclude_none=True)
    window = {"duration": 4.0 - float(arrays["t"][at]), "samples": 101 - at}
    later = replace(
        FREE, scenario=from_tables(document | {"start": start, "window": window}, "later")
    )
    after = exactly(later, rates_of(later, inertia=inertia))
    joined = {n: np.concatenate([arrays[n][:at], after[n]]) for n in ("q", "omega")}
    return noisy({"t": arrays["t"], **joined})


def by_a_wrong_stage() -> Arrays:
    """RK4 whose last stage is at half of the step."""
    rates, h, start = rates_of(TOP), float(TOP.scenario.times[1]), TOP.scenario.start

    def slope(y: np.ndarray) -> np.ndarray:
        return np.concatenate(rates(y[:4], y[4:]))

    rows = [np.concatenate([start.q_world_body_wxyz, start.omega_body])]
    for _ in TOP.scenario.times[1:]:
        y = rows[-1]
        k = [slope(y)]
        for _ in range(3):
            k.append(slope(y + h / 2 * k[-1]))
        y = y + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
        y[:4] /= np.linalg.norm(y[:4])
        rows.append(y)
    table = np.array(rows)
    return {"t": TOP.scenario.times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


def by_euler(one: Case, rates: Rates) -> Arrays:
    """Ten steps of explicit Euler from sample to sample."""
    start, h = one.scenario.start, float(one.scenario.times[1]) / 10
    y, rows = np.concatenate([start.q_world_body_wxyz, start.omega_body]), []
    for _ in one.scenario.times:
        rows.append(y)
        for _ in range(10):
            y = y + h * np.concatenate(rates(y[:4], y[4:]))
            y[:4] /= np.linalg.norm(y[:4])
    table = np.array(rows)
    return {"t": one.scenario.times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


def heavier_by(part: float) -> Arrays:
    """Euler's motion of a body with one of its principal moments larger by a part."""
    moments, axes = np.linalg.eigh(HEAVY.inertia)
    inertia = (axes * moments * [1.0, 1.0 + part, 1.0]) @ axes.T
    return by_euler(HEAVY, rates_of(HEAVY, inertia=inertia))


def exchanged() -> Arrays:
    """A body that keeps its spin, in axes of which two are exchanged, of every vector."""
    arrays, order = right(SPINNING), [0, 2, 1]
    q = np.hstack([arrays["q"][:, :1], -arrays["q"][:, 1:][:, order]])
    return arrays | {"q": q, "omega": arrays["omega"][:, order]}


def transposed() -> Arrays:
    """ω = Rᵀ I⁻¹ R L, of an L that is kept."""
    R = Rotation.from_quat(np.array(FREE.scenario.start.q_world_body_wxyz), scalar_first=True)
    inertia, h, rows = FREE.inertia, 1e-3, []
    L = (
        R.as_matrix().T
        @ inertia
        @ R.as_matrix()
        @ R.apply(np.array(FREE.scenario.start.omega_body))
    )

    def omega_world(R: Rotation) -> np.ndarray:
        M = R.as_matrix()
        return np.asarray(M.T @ np.linalg.solve(inertia, M @ L))

    for step in range(round(FREE.scenario.times[-1] / h) + 1):
        omega = omega_world(R)
        if step % 40 == 0:
            rows.append((R.as_quat(scalar_first=True), R.inv().apply(omega)))
        half = Rotation.from_rotvec(h / 2 * omega) * R
        R = Rotation.from_rotvec(h * omega_world(half)) * R
    qs, omegas = (np.array(column) for column in zip(*rows, strict=True))
    return {"t": FREE.scenario.times.copy(), "q": qs, "omega": omegas}


def of_a_slow_clock() -> Arrays:
    """Times that are too short by a part of 1 / 251."""
    arrays = right(changed(FREE, window={"duration": 4.016, "samples": 101}))
    return noisy(arrays | {"t": FREE.scenario.times.copy()})


def low_passed() -> Arrays:
    """ω behind a filter of 0.03 s, recorded from the sixteenth sample on."""
    every, constant = 40, 0.03
    fine = right(changed(FREE, window={"duration": 4.0, "samples": 100 * every + 1}))
    omega, part = fine["omega"].copy(), -np.expm1(-fine["t"][1] / constant)
    for k, new in enumerate(fine["omega"][1:], 1):
        omega[k] += (1 - part) * (omega[k - 1] - new)
    kept = slice(15 * every, None, every)
    return noisy({"t": fine["t"][kept], "q": fine["q"][kept], "omega": omega[kept]})


def cut_off() -> Arrays:
    """The scene's torque acts until 2 s, and then none does."""
    at, every = 50, PUSHED.scenario.times
    torque = np.array(PUSH)
    first = exactly(PUSHED, rates_of(PUSHED, torque=lambda _: torque))
    start = {
        "quaternion_wxyz": first["q"][at].tolist(),
        "omega_body": first["omega"][at].tolist(),
    }
    rest = changed(FREE, start=start, window={"duration": 2.0, "samples": 51})
    after = exactly(rest, rates_of(rest))
    joined = {n: np.concatenate([first[n][:at], after[n]]) for n in ("q", "omega")}
    return noisy({"t": every.copy(), **joined})


def saturated() -> Arrays:
    """ω at 3/4 of its largest component, beneath the noise of what is recorded."""
    arrays = right(FREE)
    bound = 0.75 * np.abs(arrays["omega"]).max()
    return noisy(arrays | {"omega": np.clip(arrays["omega"], -bound, bound)})


def of_exchanged_columns() -> Arrays:
    arrays, order = right(FREE), [0, 2, 1]
    q = np.hstack([arrays["q"][:, :1], arrays["q"][:, 1:][:, order]])
    return arrays | {"q": q, "omega": arrays["omega"][:, order]}


def reversed_wheels() -> Arrays:
    e = equations_of(WHEELED)
    h = np.array(e.kept) - 2 * AXIAL * SPIN * np.eye(3)[2]
    rates = euler(np.array(e.inertia), lambda R, omega: np.cross(h, R.T @ omega))
    return recorded(*turning(WHEELED, rates))


def sloshing() -> Arrays:
    """A ball of fuel that is dragged along by the body, and slows it."""
    drag, ball, start = 0.2, 0.05, FREE.scenario.start
    rates, times = rates_of(FREE), np.linspace(0, 20, 251)

    def every_rate(_: float, y: np.ndarray) -> np.ndarray:
        q, omega, of_ball = y[:4], y[4:7], y[7:]
        turned, accelerated = rates(q, omega)
        torque = drag * (of_ball - omega)
        slowed = -np.cross(omega, of_ball) - torque / ball
        return np.concatenate([turned, accelerated + np.linalg.solve(FREE.inertia, torque), slowed])

    y = np.concatenate([start.q_world_body_wxyz, start.omega_body, start.omega_body])
    found = solve_ivp(every_rate, (0, 20), y, "DOP853", times, rtol=1e-10, atol=1e-10).y.T
    q = found[:, :4] / np.linalg.norm(found[:, :4], axis=1)[:, None]
    return noisy({"t": times, "q": q, "omega": found[:, 4:7]})


def capped() -> Arrays:
    """Semi-implicit Euler, damped by 0.05 /s, with a largest ‖ω‖."""
    h, inertia = float(FREE.scenario.times[1]), FREE.inertia
    rates = rates_of(FREE, torque=lambda w: -0.05 * inertia @ w)
    q, omega = FREE.scenario.start.q_world_body_wxyz, FREE.scenario.start.omega_body
    rows, bound = [], 0.95 * float(np.linalg.norm(right(FREE)["omega"], axis=1).max())
    for _ in FREE.scenario.times:
        rows.append((q, omega))
        omega = omega + h * rates(q, omega)[1]
        omega = omega * min(1.0, bound / np.linalg.norm(omega))
        turn = Rotation.from_rotvec(h * omega)
        q = (Rotation.from_quat(q, scalar_first=True) * turn).as_quat(scalar_first=True)
    qs, omegas = (np.array(column) for column in zip(*rows, strict=True))
    return {"t": FREE.scenario.times.copy(), "q": qs, "omega": omegas}


ROTOR = {
    "axis": [0.0, 0.0, 1.0],
    "position": [0.0, 0.0, 0.0],
    "mass": 0.3,
    "inertia": [0.1, AXIAL],
    "spin": SPIN,
    "hinge": "free",
}
WHEELED = changed(FREE, rotors=[ROTOR]).scenario


def with_a_wheel() -> Arrays:
    rates = euler(FREE.inertia, lambda R, omega: np.cross(MOMENTUM, R.T @ omega))
    return recorded(*turning(FREE.scenario, rates))


def frozen() -> Arrays:
    arrays = right(FREE)
    omega = arrays["omega"].copy()
    omega[40:55] = omega[40]
    return arrays | {"omega": omega}


def scattered() -> Arrays:
    """States of times that are off by 4 ms, standard deviation."""
    fine = right(changed(FREE, window={"duration": 4.0, "samples": 4001}))
    off = np.random.default_rng(3).normal(0, 4, 101)
    rows = np.clip(40 * np.arange(101) + np.rint(off).astype(int), 0, 4000)
    made = {"t": FREE.scenario.times.copy(), "q": fine["q"][rows], "omega": fine["omega"][rows]}
    return noisy(made)


def drawn_in() -> Arrays:
    """Masses that move inward along an axis from 2 to 3 s: L is kept."""
    start, times = FREE.scenario.start, FREE.scenario.times
    across = np.diag([0.0, 0.2, 0.2])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        inertia = FREE.inertia - np.clip(t - 2, 0, 1) * across
        R = Rotation.from_quat(y[:4], scalar_first=True).as_matrix()
        omega = np.linalg.solve(inertia, R.T @ y[4:])
        return np.concatenate([product(y[:4], np.array([0, *omega])) / 2, np.zeros(3)])

    q = np.array(start.q_world_body_wxyz)
    L = Rotation.from_quat(q, scalar_first=True).apply(FREE.inertia @ start.omega_body)
    made = [np.concatenate([q, L])]
    for a, b in pairwise(times):
        made.append(solve_ivp(rates, (a, b), made[-1], "DOP853", rtol=1e-12, atol=1e-13).y[:, -1])
    table = np.array(made)
    q = table[:, :4] / np.linalg.norm(table[:, :4], axis=1)[:, None]
    R = Rotation.from_quat(q, scalar_first=True)
    tensors = FREE.inertia - np.clip(times - 2, 0, 1)[:, None, None] * across
    omega = np.linalg.solve(tensors, R.inv().apply(table[:, 4:])[..., None])[..., 0]
    return {"t": times.copy(), "q": q, "omega": omega}


def half_turns() -> Arrays:
    """Attitudes off by half a turn about an axis of the body, in two stretches."""
    arrays = noisy(right(FREE))
    q, wrong = arrays["q"].copy(), np.r_[30:42, 70:78]
    q[wrong] = [product(one, np.eye(4)[3]) for one in q[wrong]]
    return arrays | {"q": q}


def of_a_torque_along_the_world() -> Arrays:
    """Gravity's torque, computed along world axes and added along the body's."""
    inertia, mass = HEAVY.inertia, HEAVY.scenario.body.mass

    def torque(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
        return np.cross(R @ HEAVY.com, mass * HEAVY.gravity)

    return recorded(*turning(HEAVY.scenario, euler(inertia, torque)))


def of_uneven_steps() -> Arrays:
    """States of uneven times, as those of an adaptive method, with even ones beside them."""
    t = FREE.scenario.times
    uneven = changed(FREE, window={"duration": 4.0, "samples": 4001})
    fine = right(uneven)
    rows = np.rint(1000 * (t + 0.05 * np.sin(np.pi * t / 4) ** 2)).astype(int)
    return {"t": t.copy(), "q": fine["q"][rows], "omega": fine["omega"][rows]}


def late_and_biased() -> Arrays:
    """ω of 0.04 s before, with a bias: five decimals, and noise that nobody states."""
    arrays = right(changed(FREE, window={"duration": 4.04, "samples": 102}))
    omega = arrays["omega"][:-1] + np.array([0.12, -0.07, 0.05])
    made = noisy({"t": arrays["t"][1:], "q": arrays["q"][1:], "omega": omega})
    return {name: one.round(5) for name, one in made.items()}


def stronger_gravity() -> Arrays:
    return stepped(COARSE, rates_of(HEAVY, scale=10 / 9.81))


def stepped(scene: Scenario, rates: Rates) -> Arrays:
    """Eight steps of RK4 from sample to sample."""
    h = float(scene.times[1]) / 8
    y = np.concatenate([scene.start.q_world_body_wxyz, scene.start.omega_body])
    rows = [y]

    def slope(y: np.ndarray) -> np.ndarray:
        return np.concatenate(rates(y[:4], y[4:]))

    for _ in scene.times[1:]:
        for _ in range(8):
            a = slope(y)
            b = slope(y + h / 2 * a)
            c = slope(y + h / 2 * b)
            y = y + h / 6 * (a + 2 * b + 2 * c + slope(y + h * c))
            y[:4] /= np.linalg.norm(y[:4])
        rows.append(y)
    table = np.array(rows)
    return {"t": scene.times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


#: The momentum of a wheel that a scene lacks, N m s.
MOMENTUM = np.array([0.0, 2.0, 0.0])
COARSE = changed(HEAVY, window={"duration": 2.0, "samples": 51}).scenario
PUSHED = changed(FREE, effects={"torque": {"body": PUSH}})
HIDDEN = {
    "a clock that is slow": Hidden(
        FREE.scenario,
        of_a_slow_clock,
        ("it moves as if samples were ",),
        NOISY,
        numbers=(1.004,),
        to=1e-4,
    ),
    "a low-pass filter": Hidden(
        FREE.scenario,
        low_passed,
        ("ω is what a low-pass filter of a time constant of ",),
        NOISY,
        numbers=(0.03,),
        to=1e-3,
    ),
    "a thruster that stops": Hidden(
        PUSHED.scenario,
        cut_off,
        ("until t = ",),
        NOISY,
        numbers=(2.0,),
        to=0.13,
    ),
    "the same, with noise that is not stated": Hidden(
        PUSHED.scenario, cut_off, ("until t = ",), numbers=(2.0,), to=0.13
    ),
    "a gyroscope that saturates": Hidden(
        FREE.scenario,
        saturated,
        (
            "the attitudes are those of the scene, but the recorded ω is not: the gyroscope "
            "saturates: each component of ω is clamped to ",
        ),
        NOISY,
        numbers=(0.75 * float(np.abs(right(FREE)["omega"]).max()),),
        to=5e-3,
    ),
    "columns that are exchanged": Hidden(
        FREE.scenario,
        of_exchanged_columns,
        ("x, y, z of the quaternion and of ω are [x, z, y] of their columns",),
    ),
    "wheels that are reversed": Hidden(
        WHEELED, reversed_wheels, ("it moves as if the rotors turned the other way round",)
    ),
    "fuel that sloshes": Hidden(
        changed(FREE, window={"duration": 20.0, "samples": 251}).scenario,
        sloshing,
        ("its energy falls by ",),
        NOISY,
    ),
    "the same, beneath the error of one step from sample to sample": Hidden(
        changed(FREE, window={"duration": 20.0, "samples": 251}).scenario,
        sloshing,
        ("its energy falls by ",),
    ),
    "a wheel that the scene lacks": Hidden(
        FREE.scenario,
        with_a_wheel,
        ("it moves as if a wheel in it had a constant angular momentum of [",),
        numbers=(0.0, 2.0, 0.0),
    ),
    "the same, in noise": Hidden(
        FREE.scenario,
        lambda: noisy(with_a_wheel()),
        ("it moves as if a wheel in it had a constant angular momentum of [",),
        numbers=(0.0, 2.0, 0.0),
    ),
    "no gyroscopic torque, exactly": Hidden(
        FREE.scenario,
        lambda: recorded(*turning(FREE.scenario, euler(FREE.inertia, gyroscopic=0 * FREE.inertia))),
        ("it moves as if there were no gyroscopic torque",),
        {"timestep": "0.004"},
    ),
    "markers that are exchanged for a while": Hidden(
        FREE.scenario,
        half_turns,
        ("ω is that of the scene, but the attitudes are not at 20 samples, the first at t = ",),
        NOISY,
    ),
    "a clock that is slow, exactly": Hidden(
        FREE.scenario,
        lambda: (
            right(changed(FREE, window={"duration": 4.016, "samples": 101}))
            | {"t": FREE.scenario.times.copy()}
        ),
        ("the times are 1.004 times too short",),
    ),
    "a gyroscope that stops for a while": Hidden(
        FREE.scenario, frozen, ("ω is held, as in the sample before, at 14 samples, ",)
    ),
    "times that scatter": Hidden(FREE.scenario, scattered, ("the times are off by 0.004",), NOISY),
    "arms that are drawn in": Hidden(
        FREE.scenario,
        drawn_in,
        ("until t = 2 s it is the exact motion, to rounding; from then on it is another one",),
    ),
    "gravity's torque along world axes": Hidden(
        HEAVY.scenario,
        of_a_torque_along_the_world,
        ("it moves as if gravity's torque along world axes were along the body's",),
    ),
    "uneven steps at even times": Hidden(
        FREE.scenario,
        of_uneven_steps,
        ("each state is that of another time, from 0 s before to 0.05 s after its own",),
    ),
    "a late gyroscope with a bias": Hidden(
        FREE.scenario,
        late_and_biased,
        ("the gyroscope has a bias of [", "ω lags the attitude by 0.0"),
        numbers=(0.12, -0.07, 0.05),
        to=2e-3,
    ),
    "gravity of 10 m/s², by RK4": Hidden(
        COARSE,
        stronger_gravity,
        ("it moves as if gravity were ",),
        {"timestep": "0.005"},
        4,
        (10 / 9.81,),
        1e-6,
    ),
    "friction in a bearing": Hidden(
        HEAVY.scenario,
        lambda: noisy(exactly(HEAVY, rates_of(HEAVY, torque=lambda _: np.array([0, 0, -0.3])))),
        ("it moves as if a torque of [",),
        numbers=(0.0, 0.0, -0.3),
    ),
    "a largest ‖ω‖, and damping": Hidden(
        FREE.scenario, capped, ("‖ω‖ is clamped to ",), {"timestep": "0.04"}
    ),
    "dry friction": Hidden(
        HEAVY.scenario,
        dry_friction,
        ("it moves as if a torque of [",),
        numbers=(0.0, 0.0, -0.02),
    ),
    "no gyroscopic torque, and damping": Hidden(
        FREE.scenario,
        game_engine,
        (
            "it moves as if there were no gyroscopic torque",
            "it moves as if L were slowed by 0.05 /s",
            "what is left is what semi-implicit Euler with the rotation vector ω h at 0.04 s",
        ),
        {"timestep": "0.04"},
    ),
    "an attitude by explicit Euler": Hidden(
        FREE.scenario,
        by_one_stage,
        ("what RK4 for ω, and explicit Euler for the attitude, at 0.04 s makes",),
        {"timestep": "0.04"},
        4,
    ),
    "a smoothed attitude": Hidden(
        FREE.scenario, smoothed, ("the attitude is filtered, which delays it by 0.08 s",)
    ),
    "attitudes between keys": Hidden(
        FREE.scenario,
        between_keys,
        ("the attitude is interpolated: it is new at one sample in 4 only",),
    ),
    "quaternions of ten bits": Hidden(
        FREE.scenario,
        three_of_ten_bits,
        ("the three smaller components of quaternions are rounded to 0.001382",),
    ),
    "a clock that is set": Hidden(
        FREE.scenario,
        clock_set,
        ("from t = 2.4 s to 2.74 s the motion goes on by 0.04 s, and the times by 0.34 s",),
    ),
    "gaps that are filled": Hidden(
        FREE.scenario,
        filled,
        ("ω is on a straight line from the sample before to the one after at 11 samples",),
    ),
    "a bias that drifts": Hidden(
        FREE.scenario,
        drifting,
        ("the gyroscope's bias drifts by [",),
        NOISY,
        numbers=(0.0, 0.0, 0.02),
        # Four standard errors of the slope of so many samples in 4 s.
        to=4 * NOISE[1] * np.sqrt(12 / 101) / 4.0,
    ),
    "markers that are turned": Hidden(
        FREE.scenario,
        of_turned_markers,
        ("the attitude is that of axes that are turned in the body by [",),
        NOISY,
        numbers=(3.0, 0.0, 0.0),
    ),
    "RK4 with a wrong stage": Hidden(
        TOP.scenario,
        by_a_wrong_stage,
        ("its method is of order 1, not 4: ",),
        {"timestep": "0.01"},
        4,
    ),
    "a moment off by a thousandth, by Euler": Hidden(
        HEAVY.scenario,
        lambda: heavier_by(1e-3),
        ("it moves as if the moments were [",),
        {"timestep": "0.001"},
        numbers=tuple(np.linalg.eigvalsh(HEAVY.inertia) * [1.0, 1.001, 1.0]),
        # A tenth of what it is off by.
        to=1e-4 * float(np.linalg.eigvalsh(HEAVY.inertia)[1]),
    ),
    "damping in place of drag, and no timestep": Hidden(
        DRAGGED.scenario,
        damped,
        ("it moves as if L were slowed by ",),
        numbers=(0.2,),
    ),
    "an attitude turned too early": Hidden(
        TOP.scenario,
        turned_too_early,
        ("its method is of order 1, not 2: ",),
        {"timestep": repr(float(TOP.scenario.times[1]) / 5)},
        2,
    ),
    "axes exchanged, and ω like any vector": Hidden(
        SPINNING.scenario,
        exchanged,
        ("its axes are left-handed, with y and z exchanged", "ω has the opposite sign"),
    ),
    "attitudes that are late": Hidden(
        HEAVY.scenario, late_attitudes, ("the attitude is that of ",), NOISY, numbers=(0.05,)
    ),
    "wheels that are slower": Hidden(
        WHEEL, slower_wheels, ("it moves as if the rotors had ",), NOISY, numbers=(0.9,)
    ),
    "a tensor turned the wrong way": Hidden(
        FREE.scenario,
        transposed,
        ("it moves as if ω were Rᵀ I⁻¹ R L along world axes, for R I⁻¹ Rᵀ L",),
        {"timestep": "0.001"},
        2,
    ),
}


@each_case("one", HIDDEN)
def test_a_hidden_fault_is_named(one: Hidden) -> None:
    check(one)


def test_what_no_change_explains_of_a_measured_motion_is_beyond_its_noise() -> None:
    """Without stated noise, too, though one step from sample to sample may be off by as much."""
    one = case(324, samples=41)
    odd = rates_of(one, torque=lambda w: 0.05 * np.sin([5 * w[1], 7 * w[2], 9 * w[0]]))
    found = judged_motion(one.scenario, Recording(Path("motion.csv"), noisy(exactly(one, odd))))
    assert found.is_another
    assert found.measured is not None


@pytest.mark.parametrize("part", [0.0, 1e-6])
def test_what_euler_makes_of_the_equations_is_no_change_of_them(part: float) -> None:
    recording = Recording(Path("motion.csv"), heavier_by(part), {"timestep": "0.001"})
    found = judged_motion(HEAVY.scenario, recording)
    assert not found.explained_by
    assert not found.is_beyond


@pytest.mark.parametrize("grown", [0.0, 0.3])
def test_since_when_a_measured_motion_is_another_one_is_named(grown: float) -> None:
    inertia = FREE.inertia + np.diag([grown, 0.0, grown])
    recording = Recording(Path("motion.csv"), knocked(inertia))
    exact = exact_at(FREE.scenario, recording.arrays["t"]).trajectory
    motion = recorded_motion(FREE.scenario, recording, reading_of(recording), exact).trajectory
    has = {"is_stated": True, "has_omega": True}
    log = log_of(FREE.scenario, motion, exact, np.array(NOISE), **has)
    (words,) = since_when(Measured(FREE.scenario, log), motion, exact)
    assert words.startswith("until t = 1.96 s it is the exact motion; there it ")
    if not grown:
        assert "jumps" in words
        return
    _, _, numbers = words.partition("Ixx, Iyy, Izz, Ixy, Ixz, Iyz = [")
    entries = [float(text) for text in numbers.partition("]")[0].split(",")]
    # Of a body that turns freely a motion shows its tensor up to a factor.
    wanted = inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)] / np.trace(inertia)
    assert np.array(entries) / sum(entries[:3]) == pytest.approx(wanted, abs=0.01)
