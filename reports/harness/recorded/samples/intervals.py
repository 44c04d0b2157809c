"""The intervals between the samples of a recorded motion, with bounds on a method's error."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .....reference.deviations import apart
from .....reference.following import EXACT, Integrator, follow, follow_each
from .....reference.other_equations import OtherEquations, equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import norms, rotation_vectors
from ...explaining.fit import Data
from ...explaining.hypothesis import Hypothesis, as_it_is
from .sensors import as_it_was, as_read

#: Largest turn of the body in an interval between two samples, rad; least number of intervals.
NEAR, FEWEST_INTERVALS = 0.7, 4
#: The most intervals into which the time before the first sample is divided.
MOST_BEFORE = 1000
#: Difference of starts, rad and relative to the fastest rate, by which the growth of errors along a
#: motion is found.
SMALL = 1e-6
#: Smallest rate that is assumed of a state, relative to the largest rate of the motion.
LEAST_RATE = 1e-6
#: Largest ‖ω‖ up to which the motions of hypotheses are followed, relative to the largest recorded.
FASTER = 30.0


@dataclass(frozen=True, eq=False)
class Intervals(Data):
    """S intervals of a recorded motion, each from one recorded state to the next.

    Attributes
    ----------
    starts : recorded states at the starts of the intervals: q, scalar first, and ω, rad/s, body
        axes, (S, 7)
    t : times at the ends of the intervals, s, (S,)
    spans : lengths of the intervals, s, (S, 1)
    ends : recorded states at the ends of the intervals, (S, 7)
    noise : standard deviations of recorded attitude, rad, and ω, rad/s, (2,)
    method : bounds on a method's error in each interval, in attitude, rad, and ω, rad/s, (S, 2)
    integrator : the integrator with which the equations of hypotheses are solved
    timestep : timestep of the integrator, s; not used by `EXACT`, which chooses its own
    is_derived : whether ω was not recorded, but computed from the attitudes
    """

    starts: FloatArray
    t: FloatArray
    spans: FloatArray
    ends: FloatArray
    noise: FloatArray
    method: FloatArray
    integrator: Integrator = EXACT
    timestep: float = 0.0
    is_derived: bool = False

    @cached_property
    def scale(self) -> FloatArray:
        """Standard deviations, by noise and a method's error together, of the residuals, (S, 6).

        The residuals of each of S intervals are three of attitude, rad, and three of ω, rad/s.
        """
        return np.repeat(np.hypot(self.noise, self.method), 3, axis=1)

    @cached_property
    def omegas(self) -> tuple[FloatArray, FloatArray] | None:
        """The mean ω of each interval, by its attitudes and as recorded, rad/s, (S, 3) each.

        None if ω was not recorded.
        """
        if self.is_derived:
            return None
        rates = rotation_vectors(self.starts[:, :4], self.ends[:, :4]) / self.spans
        return rates, (self.starts[:, 4:] + self.ends[:, 4:]) / 2

    @cached_property
    def fastest(self) -> float:
        """The largest ‖ω‖, rad/s, up to which motions by a hypothesis' equations are integrated.

        States beyond it are nan.
        """
        speeds = norms(np.vstack([self.starts, self.ends])[:, 4:])
        return FASTER * max(float(speeds.max()), float(self.base.rate))

    @cached_property
    def of_method(self) -> FloatArray:
        """The fraction of error variance due to a method's error, in each of S intervals, (S,)."""
        return np.asarray(np.mean(self.method**2 / (self.noise**2 + self.method**2), axis=1))

    @cached_property
    def correlated(self) -> float:
        """The number of residuals that count as one in χ².

        If noise is far larger than a method's error, each residual counts by itself. If the error
        is far larger, all count as one: it follows one law, however many samples show it.
        """
        return 1 + (self.scale.size - 1) * float(np.mean(self.of_method))

    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the residuals of S intervals with H hypotheses, in units of `scale`, (H, S, 6).

        They are the deviations of the recorded ends, in attitude and ω, from the states to which a
        hypothesis leads from the recorded starts. They are nan where it leads to no finite state.
        """
        starts = as_it_was(hypotheses, self.starts, self.t - self.spans[:, 0])
        steps = hypotheses.step
        of_method = self.integrator, steps * self.timestep, self.fastest
        spans = steps[:, None, None] * self.spans
        computed = follow_each(hypotheses, starts, spans, *of_method)[:, :, 0]
        with np.errstate(over="ignore", invalid="ignore"):
            return apart(as_read(hypotheses, computed, self.t), self.ends) / self.scale

    def apart(self, equations: OtherEquations) -> FloatArray:
        """Return the deviations of the S ends from the exact flow from the starts, (S, 6).

        They are a rotation vector, rad, and a difference of ω, rad/s, along body axes.

        Parameters
        ----------
        equations : the equations of which this is the exact flow
        """
        return apart(follow(equations, self.starts, self.spans)[:, 0], self.ends)

    def with_error(self, size: FloatArray) -> "Intervals":
        """Return the intervals with another bound on a method's error, the same in all intervals.

        Parameters
        ----------
        size : bound on the error of attitude, rad, and ω, rad/s, (2,)
        """
        return replace(self, method=np.tile(size, (len(self.spans), 1)))

    def made_by(self, integrator: Integrator, timestep: float) -> "Intervals":
        """Return the intervals with another `integrator`, and with 0 as bound on a method's error.

        Parameters
        ----------
        integrator : the integrator with which the equations of hypotheses are solved
        timestep : timestep of the integrator, s
        """
        without = np.zeros_like(self.method)
        return replace(self, method=without, integrator=integrator, timestep=timestep)

    def spread(self, most: int) -> "Intervals":
        """Return at most `most` of the intervals, spread evenly over all."""
        return self.rows(np.unique(np.linspace(0, len(self.spans) - 1, most).astype(int)))

    def rows(self, kept: Sequence[int] | NDArray[np.int_]) -> "Intervals":
        """Return k of the intervals; `kept` are their indices, (k,)."""
        names = "starts", "t", "spans", "ends", "method"
        return replace(self, **{name: getattr(self, name)[kept] for name in names})


def root_mean_squares(differences: FloatArray) -> FloatArray:
    """Return the root mean squares of differences of attitude, rad, and of ω, rad/s, (2,).

    Means are over all intervals and components.

    Parameters
    ----------
    differences : differences of attitude, rad, and ω, rad/s, at the ends of S intervals, (S, 6)
    """
    return np.asarray(np.sqrt(np.mean(differences.reshape(-1, 2, 3) ** 2, axis=(0, 2))))


def deviations_from_flow(scenario: Scenario, motion: Trajectory) -> FloatArray:
    """Return the deviation of each of n samples from the exact flow from the sample before it.

    The flow is that of the scene's equations.

    Returns
    -------
    Deviations of attitude, rad, and ω, rad/s, (n - 1, 6)
    """
    states, spans = states_of(motion), np.diff(motion.t)[:, None]
    return apart(follow(equations_of(scenario), states[:-1], spans)[:, 0], states[1:])


def error_at_first_sample(
    scenario: Scenario, t: FloatArray, timestep: float | None, order: int
) -> FloatArray:
    """Return bounds on a method's error at the first sample, in attitude, rad, and ω, rad/s, (2,).

    The error grows from the scene's start to that sample. The bounds are 0 if the sample is at the
    start. They are infinite if the motion is so unstable that its derivatives overflow.

    Parameters
    ----------
    t : times of the n samples since the scene's start, s, (n,)
    timestep : timestep of the method, s; if None, the median time between samples is used
    order : order of accuracy of the method
    """
    distance = float(np.median(np.diff(t)))
    count = min(MOST_BEFORE, int(np.ceil(t[0] / distance)))
    if not count:
        return np.zeros(2)
    equations, start = equations_of(scenario), scenario.start
    first = np.concatenate([start.q_world_body_wxyz, start.omega_body])[None]
    spans = np.full(count, t[0] / count)
    states = np.vstack([first, follow(equations, first, spans[None, 1:])[0]])
    rates = np.maximum(norms(states[:, 4:]), equations.rate)
    rates = np.maximum(rates, LEAST_RATE * rates.max())
    step_lengths = min(timestep or distance, distance)
    method = _bounds(equations, states, spans, rates, step_lengths, order).sum(axis=0)
    # Errors grow along the motion as small differences of its start do.
    units = np.array([1.0, rates.max()])
    (grown,) = derivatives_of_flow(equations, first, np.array([t[0]]), units[1])
    if not np.isfinite(grown).all():
        return np.full(2, np.inf)
    return np.asarray(np.linalg.norm(grown, 2) * np.sum(method / units) * units)


def derivatives_of_flow(
    equations: OtherEquations, states: FloatArray, spans: FloatArray, rate: float
) -> FloatArray:
    """Return the derivatives of states at the ends of S spans by those at the starts, (S, 6, 6).

    A change of a state is a rotation vector, rad, and a change of ω in units of `rate`, both in
    body axes. Derivatives are computed by finite differences, with changes of size `SMALL`.

    Parameters
    ----------
    equations : the equations of motion
    states : q, scalar first, and ω, rad/s, body axes, at the starts, (S, 7)
    spans : lengths of the spans, s, (S,)
    rate : the unit of ω, rad/s
    """
    ends = follow(equations, states, spans[:, None])[:, 0]
    q, columns = Rotation.from_quat(states[:, :4], scalar_first=True), []
    for turn, faster in SMALL * np.eye(6).reshape(6, 2, 3):
        turned = (q * Rotation.from_rotvec(turn)).as_quat(scalar_first=True)
        starts = np.hstack([turned, states[:, 4:] + rate * faster])
        columns.append(apart(ends, follow(equations, starts, spans[:, None])[:, 0]))
    units = SMALL * np.repeat([1.0, rate], 3)
    return np.asarray(np.stack(columns, axis=2) / units[:, None])


def states_of(motion: Trajectory) -> FloatArray:
    """Return q, scalar first, and ω, rad/s, body axes, of a motion's n samples, (n, 7)."""
    return np.hstack([motion.q_world_body_wxyz, motion.omega_body])


def intervals_of(
    scenario: Scenario,
    motion: Trajectory,
    timestep: float | None,
    order: int,
    noise: FloatArray,
    most: int | None = None,
    near: float = NEAR,
) -> Intervals | None:
    """Return the intervals between samples in which the body turns by at most `near`.

    Parameters
    ----------
    scenario : the scene whose equations are compared with the motion
    motion : the recorded motion
    timestep : timestep with which the motion was computed, s; if None, it is unknown, and the
        median time between samples is used
    order : order of accuracy of the method that computed the motion
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    most : the largest number of intervals, which are spread evenly over all; None for all
    near : the largest turn of the body in an interval, rad

    Returns
    -------
    The intervals; None if they are fewer than `FEWEST_INTERVALS`, or if ω is 0 at all samples
    """
    if len(motion.t) <= FEWEST_INTERVALS:
        return None
    base = as_it_is(scenario)
    spans = np.diff(motion.t)
    rates = np.maximum(norms(motion.omega_body), base.rate)[:-1]
    # The rate of a body that starts from rest is 0 at first, and bounds are divided by rates.
    rates = np.maximum(rates, LEAST_RATE * rates.max())
    kept = np.flatnonzero(spans * rates <= near)
    if len(kept) < FEWEST_INTERVALS or not motion.omega_body.any():
        return None
    if most is not None:
        kept = kept[np.unique(np.linspace(0, len(kept) - 1, most).astype(int))]
    spans, rates, states = spans[kept], rates[kept], states_of(motion)
    step_lengths = np.minimum(timestep or float(np.median(spans)), spans)
    method = _bounds(base, states[kept], spans, rates, step_lengths, order)
    starts, ends = states[kept], states[kept + 1]
    return Intervals(base, starts, motion.t[kept + 1], spans[:, None], ends, noise, method)


def _bounds(
    equations: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    rates: FloatArray,
    step_lengths: FloatArray | float,
    order: int,
) -> FloatArray:
    """Return bounds on a method's error over S spans, in attitude, rad, and ω, rad/s, (S, 2).

    The errors of a method of order p are proportional to the p-th power of the angle of a step. The
    factors are those of explicit Euler: its error in a step h is h²/2 times a second derivative,
    which is |ω'| times the fastest rate at most. About a constant axis even a method of order 1
    turns correctly to second order.

    Parameters
    ----------
    equations : the equations of motion that the method solves
    states : q and ω at the start of each span, (S, 7)
    spans : lengths of the spans, s, (S,)
    rates : the fastest rate of each state, rad/s, (S,)
    step_lengths : lengths of the method's steps, s, (S,) or one for all
    order : order of accuracy of the method
    """
    computed = follow(equations, states, spans[:, None])[:, 0, 4:]
    speed = float(norms(states[:, 4:]).max())
    fastest = float((norms(computed - states[:, 4:]) / spans).max())
    # A body that is pushed from rest is fast only at the end of a span.
    rates = np.maximum(rates, norms(computed))
    angles = np.minimum(1.0, rates * step_lengths)
    of_turning = angles ** max(order, 2) * rates * spans / 4
    of_omega = angles**order * fastest * spans / 2
    return of_turning[:, None] * [1.0, speed] + of_omega[:, None] * np.stack(
        [1 / rates, np.ones_like(rates)], axis=1
    )
