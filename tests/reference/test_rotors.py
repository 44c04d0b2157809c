"""Scenes with rotors against a second derivation, integrated in forty digits: all the library has.

Verified: ω, attitude and spins over the first turns, to 1e-15 and to the uncertainty stated.
The second derivation is of coupled bodies: the rates of ω and of every spin are solved for together
from the tensors of all parts,

    I ω' + Σ C u s' = τ − ω × (I ω + Σ C s u),    u·ω' + s' = 0 on a free hinge,  s' = 0 elsewhere,

with no momentum taken for constant and no principal axes. Over long times a free symmetric gyrostat
has a closed form; of others conservation laws are all that is verified there.
"""

from dataclasses import replace

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation
from spincheck.reference import drifts, solve
from spincheck.reference.allowed_drift import allowed_drifts
from spincheck.scenarios import FloatArray, Scenario, Trajectory, loads
from spincheck.scenarios.exact import conjugate, rotate
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.scenarios.rotation import norms, rotation_vectors
from spincheck.scenarios.scenario import with_tables
from spincheck.scenarios.vary import varied
from two_turns import two_turns

pytestmark = pytest.mark.slow

#: Those on a table are among the scenes of `test_table`.
SCENES = [scene for scene in library() if scene.rotors and "table" not in scene.called_for]
DIGITS, ORDER = 40, 30
#: rad, of the fastest rate: a step's series leaves out 8^-31, and so many radians are followed.
STEP, REACH = mpf(1) / 8, 4
#: What the reference set out to be.
GOAL = 1e-15
CYCLIC = ((1, 2), (2, 0), (0, 1))
IDENTITY = ((1, 0, 0), (0, 1, 0), (0, 0, 1))

Series = list[list[mpf]]


class CoupledBodies:
    """The equations of motion of a scene, in its own axes, from the tables of its file."""

    def __init__(self, scenario: Scenario) -> None:
        tables = scenario.document.rotors or ()
        parts = [(scenario.carrier.mass_exact, scenario.carrier.com_exact)]
        parts += [(mpf(one.mass), tuple(map(mpf, one.position))) for one in tables]
        self.mass = sum(mass for mass, _ in parts)
        com = [sum(mass * place[k] for mass, place in parts) / self.mass for k in range(3)]
        fixed = [mpf(0)] * 3 if scenario.constraint.is_pivot else com
        self.lever = [self.mass * (com[k] - fixed[k]) for k in range(3)]
        self.axes = [mp.matrix(one.axis) / mp.norm(mp.matrix(one.axis)) for one in tables]
        self.along = [mpf(one.inertia[1]) for one in tables]
        self.is_free = [one.hinge == "free" for one in tables]
        self.inertia = mp.matrix(scenario.carrier.inertia_com_exact)
        for one, axis in zip(tables, self.axes, strict=True):
            across, along = map(mpf, one.inertia)
            self.inertia += across * mp.eye(3) + (along - across) * axis * axis.T
        for mass, place in parts:
            arm = mp.matrix([place[k] - fixed[k] for k in range(3)])
            self.inertia += mass * ((arm.T * arm)[0] * mp.eye(3) - arm * arm.T)
        self.solver = self._coupled() ** -1
        self.scenario = scenario

    def _coupled(self) -> mp.matrix:
        """What the rates of ω and spins are multiplied by."""
        count = len(self.axes)
        matrix = mp.zeros(3 + count)
        matrix[:3, :3] = self.inertia
        for k, axis in enumerate(self.axes):
            for i in range(3):
                matrix[i, 3 + k] = self.along[k] * axis[i]
                matrix[3 + k, i] = axis[i] if self.is_free[k] else 0
            matrix[3 + k, 3 + k] = 1
        return matrix

    def torque(self, rows: list[Series], omega: Series, n: int) -> list[mpf]:
        """Order n of the torque in body axes; rows are the world's axes seen from the body's."""
        scene = self.scenario
        pull, pushed = (
            [sum(mpf(v[row]) * rows[row][i][n] for row in range(3)) for i in range(3)]
            for v in (scene.gravity_world, scene.pushed["torque_world"])
        )
        constant = scene.pushed["torque_body"] if n == 0 else np.zeros(3)
        return [
            self.lever[j] * pull[k] - self.lever[k] * pull[j]
            + pushed[i] + mpf(constant[i]) - mpf(scene.pushed["drag"]) * omega[i][n]
            for i, (j, k) in enumerate(CYCLIC)
        ]  # fmt: skip

    def step(self, state: list[mpf], h: mpf) -> list[mpf]:
        """ω, spins and nine entries of the rotation a time h later."""
        columns = [[x] for x in state]
        count = len(self.axes)
        omega, spins = columns[:3], columns[3 : 3 + count]
        rows = [columns[3 + count + 3 * row : 6 + count + 3 * row] for row in range(3)]
        momentum: Series = [[], [], []]
        for n in range(ORDER):
            for i in range(3):
                turning = sum(self.inertia[i, k] * omega[k][n] for k in range(3))
                spinning = (
                    C * spin[n] * axis[i]
                    for C, spin, axis in zip(self.along, spins, self.axes, strict=True)
                )
                momentum[i].append(turning + sum(spinning))
            gained = self.torque(rows, omega, n)
            turned = crossed(omega, momentum, n)
            right = mp.matrix([gained[i] - turned[i] for i in range(3)] + [0] * count)
            rates = [*(self.solver * right)]
            for row in rows:
                rates += crossed(row, omega, n)
            for column, rate in zip(columns, rates, strict=True):
                column.append(rate / (n + 1))
        powers = [h**n for n in range(ORDER + 1)]
        return [mp.fdot(column, powers) for column in columns]

    def motion(self, time: mpf, steps: int) -> list[mpf]:
        """The state at a time."""
        start = self.scenario.start
        q = conjugate(start.q_exact)
        # The world's axes, seen from the body's.
        rows = [rotate(q, tuple(map(mpf, axis))) for axis in IDENTITY]
        spins = [mpf(spin) for spin in self.scenario.rotors.start_spins]
        state = [*start.omega_body_exact, *spins, *(x for row in rows for x in row)]
        for _ in range(steps):
            state = self.step(state, time / steps)
        return state


def crossed(a: Series, b: Series, n: int) -> list[mpf]:
    """Order n of a × b."""
    return [
        mp.fdot(a[j][: n + 1], b[k][n::-1]) - mp.fdot(a[k][: n + 1], b[j][n::-1])
        for j, k in CYCLIC
    ]  # fmt: skip


def first_turns(scenario: Scenario) -> tuple[float, int]:
    """s, and steps, that are followed."""
    motion = solve(scenario, scenario.times).trajectory
    speed = float(norms(motion.omega_body).max())
    rate = fastest_rate(scenario, motion.omega_body) + speed
    time = min(scenario.window.duration, REACH / rate)
    return time, int(time * rate / STEP) + 1


def apart(motion: Trajectory, scenario: Scenario, state: list[mpf]) -> dict[str, float]:
    """Distances of the last sample from a state, in the norms of the signals."""
    count = len(scenario.rotors.each)
    omega, spins = np.array(state[:3]), np.array(state[3 : 3 + count])
    R = np.array(state[3 + count :], dtype=float).reshape(3, 3)
    speed = float(norms(motion.omega_body).max())
    fastest = np.abs(motion.spins).max(axis=0) + speed
    return {
        "omega": float(np.linalg.norm((motion.omega_body[-1] - omega).astype(float))) / speed,
        "attitude": float(norms(turn_between(motion.q_world_body_wxyz[-1], R))[0]),
        "spins": float((np.abs((motion.spins[-1] - spins).astype(float)) / fastest).max()),
    }


def turn_between(q_wxyz: FloatArray, R: FloatArray) -> FloatArray:
    other = Rotation.from_matrix(R).as_quat(scalar_first=True)
    return rotation_vectors(q_wxyz[None], other[None])


@each_case("scenario", SCENES)
def test_the_motion_is_that_of_coupled_bodies(scenario: Scenario) -> None:
    time, steps = first_turns(scenario)
    times = np.linspace(0.0, time, 9)
    solution = solve(scenario, times)
    with mp.workdps(DIGITS):
        state = CoupledBodies(scenario).motion(mpf(time), steps)
        off = apart(solution.trajectory, scenario, state)
        assert max(off.values()) <= GOAL, off
        assert off["omega"] <= solution.uncertainty.omega
        assert off["attitude"] <= solution.uncertainty.attitude
        if scenario.rotors.is_free.any() and "symmetric" not in scenario.document.tags:
            # Teeth: free rotors that are taken for driven ones, unless u·ω stays by symmetry.
            wrong = solve(all_driven(scenario), times).trajectory
            assert max(apart(wrong, scenario, state).values()) > GOAL


def all_driven(scenario: Scenario) -> Scenario:
    rotors = tuple(
        one.model_copy(update={"hinge": "driven"}) if one.hinge == "free" else one
        for one in scenario.document.rotors or ()
    )
    return with_tables(scenario, rotors=rotors)


@each_case("scenario", SCENES)
def test_the_motion_keeps_what_it_conserves(scenario: Scenario) -> None:
    solution = solve(scenario, scenario.times)
    allowed = allowed_drifts(scenario, solution.trajectory, solution.uncertainty)
    drifted = drifts(scenario, solution.trajectory)
    assert "rotors_momentum" in drifted
    assert all(drifted[name] <= allowed[name] for name in drifted), (drifted, allowed)
    faster = replace(solution.trajectory, spins=solution.trajectory.spins * (1 + 1e-9))
    moving = np.abs(solution.trajectory.spins).max() > 0
    later = np.where(np.arange(len(faster.t))[:, None] > 0, faster.spins, solution.trajectory.spins)
    wrong = drifts(scenario, replace(faster, spins=later))["rotors_momentum"]
    assert not moving or wrong > allowed["rotors_momentum"]


#: A symmetric body with rotors about its axis, one off it; some 600 turns.
GYROSTAT = """spincheck = 1
title = "A symmetric body with two rotors along its axis"
source = "made up"
[body]
mass = 1.0
inertia = [0.002, 0.002, 0.003]
[start]
rotation_vector_deg = [20.0, -40.0, 70.0]
omega_body = [3.0, -1.0, 2.0]
[[rotors]]
axis = [0.0, 0.0, 1.0]
position = [0.0, 0.0, 0.05]
mass = 0.1
inertia = [2e-5, 3e-5]
spin = 300.0
hinge = "free"
[[rotors]]
axis = [0.0, 0.0, -1.0]
position = [0.0, 0.0, -0.08]
mass = 0.2
inertia = [5e-5, 4e-5]
spin = {spin}
hinge = "driven"
[window]
duration = 400.0
samples = 41
"""
#: Relative, of a rotor's spin: a fault that must show.
PLANTED = 1e-12


def closed_form(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """The attitude's quaternion and ω in body axes of a free symmetric gyrostat, at its times.

    By symmetry ω₃ stays, and so does L₃ = I₃ ω₃ + Σ C s u₃.
    """
    start, inertia = scenario.start, scenario.body.inertia_com_exact
    with mp.workdps(DIGITS):
        across, along, (w1, w2, w3) = inertia[0][0], inertia[2][2], start.omega_body_exact
        L3 = along * w3 + sum(one.along * one.spin * one.axis[2] for one in scenario.rotors.each)
        L = across * w1, across * w2, L3
        begun = across, L, start.q_exact, start.omega_body_exact, 2
        states = [two_turns(*begun, t) for t in map(mpf, scenario.times.tolist())]
        return tuple(np.array([s[k] for s in states], dtype=float) for k in range(2))


def off_closed_form(scenario: Scenario, told: Scenario) -> float:
    """By how much the exact motion of one scene is off another's, in what it may be off."""
    solution = solve(scenario, scenario.times)
    motion, own = solution.trajectory, solution.uncertainty
    attitude, omega = closed_form(told)
    turned = norms(rotation_vectors(motion.q_world_body_wxyz, attitude))
    off = norms(motion.omega_body - omega) / norms(omega).max()
    spins = np.abs(motion.spins - told.rotors.start_spins) / np.abs(motion.spins).max()
    largest = turned.max() / own.attitude, off.max() / own.omega, spins.max() / own.omega
    return float(max(largest))


@each_case("spin", [0.0, 150.0, -450.0])
def test_a_free_symmetric_gyrostat_is_its_closed_form(spin: float) -> None:
    scenario = loads(GYROSTAT.format(spin=spin), "gyrostat")
    assert off_closed_form(scenario, scenario) <= 1
    faster = varied(scenario, {"rotors[0].spin": 300.0 * (1 + PLANTED)})
    assert off_closed_form(scenario, faster) > 1
