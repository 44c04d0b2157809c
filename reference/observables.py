"""What a physicist reads off a motion — rates, bounds, periods — each beside its exact value.

They are measured from samples by cubic Hermite splines through values and rates, so they are
displays, right to a few parts in 10⁵ at the coarsest sampling allowed; a run is judged by its
errors, not by these. Where the samples are too coarse or the window too short for one, it is
left out.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from mpmath import mp
from scipy.interpolate import CubicHermiteSpline, PPoly

from ..scenarios import FloatArray, Scenario, Trajectory
from ..scenarios.exact import DIGITS, rotate
from .facts import facts
from .problem import Problem
from .rotational_problem import rotational_problem
from .symmetry import (
    UNIT_VECTORS,
    across,
    angular_momentum_axes,
    norm,
    scaled,
    symmetry_axis,
    to_body,
    up_world,
)

#: A cubic spline through this many samples of a period is right to (2π/16)⁴/384 = 6e-5 of it.
SAMPLES_PER_PERIOD = 16
#: Relative to ω, or in rad: what changes by less than √ulp is taken for steady, or for rounding.
NO_CHANGE = float(np.sqrt(np.finfo(float).eps))


#: By the names of facts: exact values, and measured ones.
Exact = Mapping[str, float]
Measured = Iterator[tuple[str, float]]


@dataclass(frozen=True)
class Observable:
    """A measured number beside the exact one; `name` is that of the fact."""

    name: str
    value: float
    exact: float
    unit: str


def observables(scenario: Scenario, motion: Trajectory) -> list[Observable]:
    """What can be read off a motion of the scene."""
    problem, known = rotational_problem(scenario), {fact.name: fact for fact in facts(scenario)}
    exact = {name: fact.value for name, fact in known.items()}
    kinds = {
        "nutation period": _of_a_heavy_top,
        "body cone rate": _of_a_free_top,
        "tumbling period": _of_a_free_body,
    }
    return [
        Observable(name, value, exact[name], known[name].unit)
        for kind, measured in kinds.items()
        if kind in exact
        for name, value in measured(problem, exact, motion)
    ]


@dataclass(frozen=True, eq=False)
class AxisMotion:
    """A body axis as it moves round a fixed direction, splined.

    Attributes
    ----------
    t : (n,) s
    along : the axis, a unit vector, along two directions across the fixed one and along it;
        a spline of (3,)
    """

    t: FloatArray
    along: CubicHermiteSpline

    def angle(self, times: FloatArray) -> FloatArray:
        """The angle of axis and direction, rad; by an arctangent, good at 0 and π too."""
        x, y, z = self.along(times).T
        return np.asarray(np.arctan2(np.hypot(x, y), z))

    def turns(self) -> tuple[FloatArray, FloatArray]:
        """Times at which the angle is least, and at which it is largest, between the samples."""
        height = PPoly(self.along.c[..., 2], self.along.x)
        turning_times = _roots(height.derivative())
        bend = height.derivative(2)(turning_times)
        return turning_times[bend < 0], turning_times[bend > 0]

    def azimuth_rate(self) -> FloatArray:
        """The rate of the azimuth at the samples, rad/s; NaN where axis and direction coincide."""
        x, y, _ = self.along(self.t).T
        x_rate, y_rate, _ = self.along(self.t, 1).T
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray((x * y_rate - y * x_rate) / (x**2 + y**2))

    def azimuth(self) -> CubicHermiteSpline:
        """The azimuth of the axis about the direction, rad, without jumps of full turns."""
        x, y, _ = self.along(self.t).T
        return CubicHermiteSpline(self.t, np.unwrap(np.arctan2(y, x)), self.azimuth_rate())


def axis_motion(motion: Trajectory, axis_body: FloatArray, direction: FloatArray) -> AxisMotion:
    """Follow a body axis round a world direction, both unit vectors, (3,)."""
    R_world_body = motion.R_world_body
    axis = R_world_body.apply(axis_body)
    velocity = np.cross(R_world_body.apply(np.array(motion.omega_body)), axis)
    frame = frame_about(direction)
    return AxisMotion(motion.t, CubicHermiteSpline(motion.t, axis @ frame.T, velocity @ frame.T))


def frame_about(third: FloatArray) -> FloatArray:
    """Rows e1, e2, e3 of a right-handed frame with e3 given; x and y themselves for z, (3, 3)."""
    first = np.eye(3)[np.argmin(np.abs(third))]
    first = first - (first @ third) * third
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])


def _of_a_heavy_top(problem: Problem, exact: Exact, motion: Trajectory) -> Measured:
    axis = symmetry_axis(problem)
    assert axis is not None
    period = exact["nutation period"]
    if not _resolves(motion, period) or motion.t[-1] < period:
        return
    moving = axis_motion(motion, np.array(to_body(problem, axis), float), up_world(problem))
    steady = math.radians(exact["nutation to"] - exact["nutation from"]) < NO_CHANGE
    highest, lowest = moving.turns()
    beta = moving.angle(motion.t if steady else np.concatenate([motion.t, highest, lowest]))
    yield "nutation from", math.degrees(beta.min())
    yield "nutation to", math.degrees(beta.max())
    if not steady and len(lowest) >= 2:
        yield "nutation period", float(lowest[-1] - lowest[0]) / (len(lowest) - 1)
    if "precession rate" in exact and (steady or len(lowest) >= 2):
        yield from _precession(moving, motion.t if steady else lowest)


def _precession(moving: AxisMotion, phases: FloatArray) -> Measured:
    """Mean rate of precession between the first and the last of times of equal phase."""
    fastest = float(np.abs(moving.azimuth_rate()).max())
    if not fastest or _resolves(moving, math.tau / fastest):
        azimuth = moving.azimuth()
        first, last = float(phases[0]), float(phases[-1])
        yield "precession rate", float(azimuth(last) - azimuth(first)) / (last - first)


def _of_a_free_top(problem: Problem, exact: Exact, motion: Trajectory) -> Measured:
    axis = symmetry_axis(problem)
    assert axis is not None
    with mp.workdps(DIGITS):
        L = angular_momentum_axes(problem)
        direction = scaled(rotate(problem.q_world_axes, L), 1 / norm(L))
    cone = exact["body cone rate"]
    frame_body = np.array([to_body(problem, e) for e in (*across(axis), axis)], dtype=float)
    omega = motion.omega_body @ frame_body.T
    aside = np.hypot(omega[:, 0], omega[:, 1])
    if aside.min() < NO_CHANGE * np.abs(omega).max():
        return
    if cone and _resolves(motion, math.tau / abs(cone)):
        phase = np.unwrap(np.arctan2(omega[:, 1], omega[:, 0]))
        yield "body cone rate", _mean_rate(motion, phase)
    if _resolves(motion, math.tau / exact["precession rate"]):
        moving = axis_motion(motion, frame_body[2], np.array(direction, dtype=float))
        yield "precession rate", _mean_rate(motion, moving.azimuth()(motion.t))


def _of_a_free_body(problem: Problem, exact: Exact, motion: Trajectory) -> Measured:
    """Twice the mean time between sign changes of ω about the middle axis."""
    if not _resolves(motion, exact["tumbling period"]):
        return
    axes_body = np.array([to_body(problem, e) for e in UNIT_VECTORS], dtype=float)
    moments = np.array(problem.moments, dtype=float)
    omega = motion.omega_body @ axes_body.T
    rate = -np.cross(omega, omega * moments) / moments
    k = int(np.argsort(moments)[1])
    if np.abs(omega[:, k]).max() < NO_CHANGE * np.abs(omega).max():
        return
    flips = _roots(CubicHermiteSpline(motion.t, omega[:, k], rate[:, k]))
    if len(flips) >= 2:
        yield "tumbling period", 2 * float(flips[-1] - flips[0]) / (len(flips) - 1)


def _resolves(motion: Trajectory | AxisMotion, period: float) -> bool:
    """Whether the samples are close enough to follow something of that period."""
    finite = math.isfinite(period) and len(motion.t) > 1
    return finite and float(np.diff(motion.t).max()) * SAMPLES_PER_PERIOD <= period


def _mean_rate(motion: Trajectory, phase: FloatArray) -> float:
    return float((phase[-1] - phase[0]) / (motion.t[-1] - motion.t[0]))


def _roots(curve: PPoly) -> FloatArray:
    """Where a spline is zero, inside its samples; pieces that are zero throughout have none."""
    roots: FloatArray = curve.roots(discontinuity=False, extrapolate=False)
    return roots[np.isfinite(roots)]
