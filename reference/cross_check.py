"""Integrates a motion by a second implementation, independent of the reference.

It integrates Euler's equations with the full tensor in body axes, in double precision, by DOP853
(Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, §II.10): no principal axes, no
extended precision, no Taylor series. It is far less accurate than the reference.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ..scenarios import PUSHED, FloatArray, Scenario, Trajectory, push
from ..scenarios.exact import cross
from ..scenarios.fastest_rate import decay_rate, fastest_rate

EPS = float(np.finfo(float).eps)
#: The tightest relative tolerance that scipy accepts without a warning, rounded up.
RELATIVE_TOLERANCE = 1e-13
#: Longest step, in rad that the body turns.
TURN = 0.2
#: How far a motion is integrated, in rad turned or swung and in decay times: some seconds of work.
REACH = 1e3


@dataclass(frozen=True, eq=False)
class CrossCheck:
    """A motion that DOP853 has integrated.

    Attributes
    ----------
    trajectory : the motion
    steps : an upper bound on the number of steps taken
    tolerance : relative error allowed in each step
    """

    trajectory: Trajectory
    steps: int
    tolerance: float


def times_within_reach(scenario: Scenario, exact: Trajectory) -> FloatArray:
    """Return the sample times, s, that DOP853 reaches within some seconds of computing.

    If it does not reach all of them, the time at which it would be stopped is appended.

    Parameters
    ----------
    exact : the exact motion at all samples
    """
    rate = fastest_rate(scenario, exact.omega_body)
    end = REACH / rate if rate else np.inf
    return exact.t if exact.t[-1] <= end else np.append(exact.t[exact.t < end], end)


def cross_check(scenario: Scenario, times: FloatArray) -> CrossCheck:
    """Return the motion of a scene, integrated by DOP853 in body axes.

    It is not detected that a body leaves its table: the table also pulls.

    Parameters
    ----------
    times : (n,) s, increasing, from 0 on

    Raises
    ------
    RuntimeError
        If the integrator gives up.
    """
    start, tolerance = scenario.start, _tolerance(scenario)
    y0 = np.concatenate(
        [start.omega_body, start.q_world_body_wxyz, start.position_world, start.velocity_world]
    )
    solution = solve_ivp(
        _equations(scenario),
        (0.0, float(times[-1])),
        y0,
        method="DOP853",
        t_eval=times,
        rtol=tolerance,
        atol=tolerance * _sizes(scenario),
        max_step=_longest_step(scenario),
    )
    if not solution.success:
        raise RuntimeError(f"DOP853 gave up: {solution.message}")
    omega, q, com, velocity = np.split(solution.y.T, [3, 7, 10], axis=1)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    R_world_body, constraint = Rotation.from_quat(q, scalar_first=True), scenario.constraint
    swing = np.cross(omega, constraint.lever)
    com = constraint.com_world(R_world_body.apply(np.array(constraint.lever)), com)
    velocity = constraint.velocity_world(R_world_body.apply(swing), velocity)
    # A step takes at least eleven evaluations of the rates.
    steps = int(solution.nfev // 11)
    spins = scenario.spins(omega, scenario.kept_at_start)
    return CrossCheck(Trajectory(times, q, omega, com, velocity, spins), steps, tolerance)


def _equations(scenario: Scenario) -> Callable[[float, FloatArray], list[float]]:
    """Return the function dy/dt of (t, y), y = (ω in body axes, q, r, v), all in SI units.

    r and v are position and velocity of the com; with a pivot they stay as they are at t = 0.
    These are Euler's equations and q' = ½ q ω (Goldstein §5.5). They are written in plain floats,
    because numpy takes twenty times as long on arrays of three.
    """
    inverse = np.linalg.inv(scenario.inertia).tolist()
    differences = _differences(scenario).tolist()
    mass = scenario.body.mass * float(scenario.constraint.is_pivot)
    lever = (mass * scenario.body.com).tolist()
    gravity, is_pushed = scenario.gravity_world.tolist(), bool(scenario.called_for & PUSHED)
    answer = scenario.answer
    falling = [0.0, 0.0, 0.0] if scenario.constraint.is_pivot else gravity
    kept = scenario.kept_body(scenario.kept_at_start).tolist()

    def rate(_t: float, state: FloatArray) -> list[float]:
        a, b, c, w, x, y, z, *_, vx, vy, vz = state.tolist()
        norm = w * w + x * x + y * y + z * z
        R_body_world = [
            [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z],
        ]
        pull = _product(R_body_world, gravity)
        omega = [a, b, c]
        L = _product(differences, omega)
        fall = cross(lever, pull)
        gyroscopic = cross(omega, [L[k] + kept[k] for k in range(3)])
        torque = [fall[k] / norm - gyroscopic[k] for k in range(3)]
        if is_pushed:
            R = np.array(R_body_world) / norm
            pushed = R @ push(scenario.pushed, R.T, R.T @ omega)
            torque = [torque[k] + pushed[k] for k in range(3)]
        if answer is not None:
            up, turning = np.array(R_body_world).T[2] / norm, np.array(omega)
            acting = up, turning, np.array(torque), scenario.gravity_world
            torque = answer(scenario, *acting)[0].tolist()
        q_rate = [
            0.5 * (-x * a - y * b - z * c),
            0.5 * (w * a + y * c - z * b),
            0.5 * (w * b + z * a - x * c),
            0.5 * (w * c + x * b - y * a),
        ]
        velocity = [0.0, 0.0, 0.0] if scenario.constraint.is_pivot else [vx, vy, vz]
        return [*_product(inverse, torque), *q_rate, *velocity, *falling]

    return rate


def _product(M: list[list[float]], v: list[float]) -> list[float]:
    """Return the product of a matrix, (3, 3), and a vector, (3,), as plain floats."""
    x, y, z = v
    return [row[0] * x + row[1] * y + row[2] * z for row in M]


def _differences(scenario: Scenario) -> FloatArray:
    """Return the inertia tensor minus its second diagonal entry times the unit matrix, (3, 3).

    It is in kg m², body axes. It may replace I in ω × Iω, as ω × ω = 0. A rod's spin is then not
    driven by the rounding error of the difference of its two large moments.
    """
    inertia = scenario.inertia
    return np.asarray(inertia - inertia[1, 1] * np.eye(3), dtype=float)


def _tolerance(scenario: Scenario) -> float:
    """Return the relative error allowed in a step, `RELATIVE_TOLERANCE` or more.

    It is at least the rounding error of ω' divided by |ω|². This is large for a thin body in skew
    axes, whose I⁻¹ (ω × Iω) is a small difference of large numbers.
    """
    inverse, differences = np.abs(np.linalg.inv(scenario.inertia)), np.abs(_differences(scenario))
    return max(RELATIVE_TOLERANCE, EPS * float(np.linalg.norm(inverse @ differences, 2)))


def _longest_step(scenario: Scenario) -> float:
    """Return the longest step, s: the shorter of the decay time and the time of a turn by `TURN`.

    It is inf if the rates of decay and of turning are both zero at the start. DOP853 would be
    stable for steps of six times the decay time, but misjudges its error there. For a turn larger
    than `TURN` in a step, its dense output is of lower order than the step.
    """
    decay, rate = decay_rate(scenario), fastest_rate(scenario, scenario.start.omega_body)
    return min(1 / decay if decay else np.inf, TURN / rate if rate else np.inf)


def _sizes(scenario: Scenario) -> FloatArray:
    """Return typical sizes of the entries of the state (ω, q, r, v), SI, (13,).

    r and v are position and velocity of the com. The absolute error that is allowed in a step is in
    proportion to them.
    """
    duration = scenario.window.duration
    pull = np.linalg.norm(scenario.gravity_world)
    speed = np.linalg.norm(scenario.start.omega_body) + 1 / duration
    flight = np.linalg.norm(scenario.start.velocity_world) + pull * duration + 1
    place = np.linalg.norm(scenario.start.position_world) + flight * duration
    return np.repeat([speed, 1.0, place, flight], [3, 4, 3, 3])
