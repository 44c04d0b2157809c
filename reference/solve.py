"""Solves a scene by the simplest method that covers its effects, and bounds the error."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from mpmath import mp, mpf

from ..scenarios import Errors, FloatArray, Scenario, Trajectory, error_series, errors_between
from ..scenarios.exact import DIGITS, Vector, normalised, product
from .closed_forms import ClosedForm, closed_form
from .motion import motion
from .pose import pose
from .problem import Problem
from .solution import MAX_UNCERTAINTY, Solution
from .symmetry import gravity_torque_scale
from .taylor import CHECK_ORDERS, integrate

EPS = float(np.finfo(float).eps)
#: Rounding of the states to double and of L and E computed from them, in ulp.
ROUNDING = 8 * EPS
#: rad a radian turned: a closed form's phase is a rate in double-double, within EPS²/4, times t.
PHASE_ROUNDING = EPS**2
#: rad; how far along a closed form is compared with the ODE: a tenth of a second of its time.
CHECKED_TURN = 5e3
#: Samples at which it is compared.
CHECKED_SAMPLES = 16
#: Relative change by which conditioning is measured: large against rounding, small against 1.
NUDGE = 2.0**-30
#: Directions of the nudge: no axis is left out, no two moments change alike.
NUDGED_OMEGA = (mpf(3) / 7, -mpf(6) / 7, mpf(2) / 7)
NUDGED_MOMENTS = (mpf(1), -mpf(1) / 2, mpf(1) / 3)

Solver = Callable[[Problem, FloatArray], Trajectory]


def solve(scenario: Scenario, times: FloatArray) -> Solution:
    """The exact motion of a scene.

    Parameters
    ----------
    times : (n,) s, increasing, from 0 on

    Raises
    ------
    ValueError
        If the times do not increase or are negative.
    IntegrationError
        If the motion cannot be integrated over that span.
    """
    times = np.asarray(times, dtype=float)
    if not (len(times) and times[0] >= 0 and (np.diff(times) > 0).all()):
        raise ValueError("'times' must increase from 0 on.")
    problem = pose(scenario)
    closed = closed_form(problem)
    if closed is not None:
        return _solve_closed(scenario, problem, closed, times)
    return _solve_ode(scenario, problem, times)


def solve_ode(scenario: Scenario, times: FloatArray) -> Trajectory:
    """The same motion by the ODE integrator, whichever class the scene is of."""
    problem = pose(scenario)
    return motion(scenario, problem, times, integrate(problem, times))


def _solve_closed(
    scenario: Scenario, problem: Problem, closed: ClosedForm, times: FloatArray
) -> Solution:
    trajectory = motion(scenario, problem, times, closed.states(times))
    nudged = _nudged(problem)
    shadow_form = closed_form(nudged)
    assert shadow_form is not None, "a nudge keeps the symmetry that the closed form rests on"
    shadow = motion(scenario, nudged, times, shadow_form.states(times))
    rate = _rate(problem, trajectory)
    checked = _checked_times(times, rate)
    by_ode = motion(scenario, problem, checked, integrate(problem, checked))
    by_form = motion(scenario, problem, checked, closed.states(checked))
    difference = errors_between(scenario, by_form, by_ode)
    turned = rate * float(times[-1])
    return Solution(
        trajectory=trajectory,
        method=closed.label,
        uncertainty=_at_least(difference, ROUNDING + closed.residual + PHASE_ROUNDING * turned),
        conditioning=_conditioning(scenario, trajectory, shadow),
    )


def _solve_ode(scenario: Scenario, problem: Problem, times: FloatArray) -> Solution:
    trajectory = motion(scenario, problem, times, integrate(problem, times))
    coarser = motion(scenario, problem, times, integrate(problem, times, CHECK_ORDERS))
    nudged = _nudged(problem)
    shadow = motion(scenario, nudged, times, integrate(nudged, times, CHECK_ORDERS))
    series = error_series(scenario, trajectory, coarser)
    beyond = np.flatnonzero(np.maximum(series.omega, series.attitude) > MAX_UNCERTAINTY)
    horizon = float(times[beyond[0]]) if len(beyond) else None
    n = int(beyond[0]) if len(beyond) else len(times)
    within = trajectory.until(n)
    return Solution(
        trajectory=within,
        method="Taylor series of the equations of motion, low orders in double-double",
        uncertainty=_at_least(errors_between(scenario, within, coarser.until(n)), ROUNDING),
        conditioning=_conditioning(scenario, within, shadow.until(n)),
        horizon=horizon,
    )


def _rate(problem: Problem, trajectory: Trajectory) -> float:
    """rad/s: of the turning, and of the swinging, which may be small and is no slower for that."""
    turning = float(np.linalg.norm(trajectory.omega_body, axis=1).max())
    across = sorted(problem.moments)[1]  # of a symmetric top, about the axes that it swings about
    with mp.workdps(DIGITS):
        return max(turning, float(mp.sqrt(gravity_torque_scale(problem) / across)))


def _checked_times(times: FloatArray, rate: float) -> FloatArray:
    """A few samples, spread over the span that the ODE reaches in good time, and its end."""
    end = min(CHECKED_TURN / rate, times[-1]) if rate else times[-1]
    within = times[times < end]
    return np.append(within[:: max(len(within) // CHECKED_SAMPLES, 1)], end)


def _nudged(problem: Problem) -> Problem:
    """The problem with its start and body changed by `NUDGE`, keeping what is symmetric so."""
    with mp.workdps(DIGITS):
        delta = mpf(NUDGE)
        speed = mp.sqrt(sum(w * w for w in problem.omega_axes))
        omega = _plus(problem.omega_axes, NUDGED_OMEGA, delta * speed)
        x, y, z = (direction * delta for direction in NUDGED_OMEGA)
        turn = normalised((mpf(1), x, y, z))
        scales = {m: 1 + delta * s for m, s in zip(problem.moments, NUDGED_MOMENTS, strict=True)}
        first, second, third = (moment * scales[moment] for moment in problem.moments)
        return replace(
            problem,
            moments=(first, second, third),
            omega_axes=omega,
            q_world_axes=product(problem.q_world_axes, turn),
        )


def _plus(vector: Vector, direction: Vector, size: mpf) -> Vector:
    x, y, z = (v + size * d for v, d in zip(vector, direction, strict=True))
    return (x, y, z)


def _conditioning(scenario: Scenario, trajectory: Trajectory, shadow: Trajectory) -> Errors:
    """Growth of the nudge, scaled to one ulp."""
    apart = errors_between(scenario, shadow, trajectory)
    return Errors(**{name: max(value * EPS / NUDGE, EPS) for name, value in apart})


def _at_least(errors: Errors, least: float) -> Errors:
    return Errors(**{name: max(value, least) for name, value in errors})
