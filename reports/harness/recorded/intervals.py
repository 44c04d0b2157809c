"""The intervals of a recorded motion from sample to sample, with the error allowed to a method."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....reference.following import EXACT, Integrator, follow
from ....reference.other_equations import OtherEquations
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms, rotation_vectors
from ..measuring.changes import Hypothesis, as_it_is
from ..measuring.likelihood import Data

#: Largest turn between two samples, rad; largest number of intervals that are used.
NEAR, FEWEST_INTERVALS, MOST_INTERVALS = 0.7, 4, 60
#: Rates that are this small relative to the largest are not rates of a motion.
RESTS = 1e-6


@dataclass(frozen=True, eq=False)
class Intervals(Data):
    """Recorded states, and the recorded states that follow them.

    Attributes
    ----------
    starts : q, scalar first, and ω, rad/s, body axes, (S, 7)
    spans : lengths of the intervals, s, (S, 1)
    ends : recorded states at the ends of the intervals, (S, 7)
    noise : standard deviations of recorded attitude, rad, and ω, rad/s, (2,)
    method : bounds of a method's error in an interval, in attitude, rad, and ω, rad/s, (S, 2)
    """

    starts: FloatArray
    spans: FloatArray
    ends: FloatArray
    noise: FloatArray
    method: FloatArray

    @cached_property
    def scale(self) -> FloatArray:
        """Standard deviations of attitude, rad, and ω, rad/s, at the ends, (S, 6)."""
        return np.repeat(np.hypot(self.noise, self.method), 3, axis=1)

    @cached_property
    def at_once(self) -> float:
        """How many of the numbers left count as one: all, if a method's error is larger than noise.

        A method's error is the same throughout, however many samples show it.
        """
        of_method = float(np.mean(self.method**2 / (self.noise**2 + self.method**2)))
        return 1 + (self.scale.size - 1) * of_method

    def falls(self, before: FloatArray, after: FloatArray) -> float:
        """As in `Data`, but with correlated numbers counted once."""
        return super().falls(before, after) / self.at_once

    def off(self, hypothesis: Hypothesis, samples: int | None = None) -> FloatArray:
        """As in `Data`: what a hypothesis leaves of the ends, in units of `scale`, (S, 6)."""
        return self.apart(hypothesis.equations)[:samples] / self.scale[:samples]

    def apart(
        self, equations: OtherEquations, integrator: Integrator = EXACT, timestep: float = 0.0
    ) -> FloatArray:
        """Return how far the ends are from where equations lead, rad and rad/s, (S, 6)."""
        return apart(
            follow(equations, self.starts, self.spans, integrator, timestep)[:, 0], self.ends
        )

    def spread(self, most: int) -> "Intervals":
        """Return at most `most` of the intervals, spread over all."""
        kept = np.unique(np.linspace(0, len(self.spans) - 1, most).astype(int))
        starts, spans, ends = self.starts[kept], self.spans[kept], self.ends[kept]
        return Intervals(self.base, starts, spans, ends, self.noise, self.method[kept])


def apart(made: FloatArray, recorded: FloatArray) -> FloatArray:
    """Return how far recorded states, (S, 7), are from computed ones, rad and rad/s, (S, 6)."""
    turned = rotation_vectors(made[:, :4], recorded[:, :4])
    return np.hstack([turned, recorded[:, 4:] - made[:, 4:]])


def states_of(motion: Trajectory) -> FloatArray:
    """Return q, scalar first, and ω, rad/s, body axes, of each sample, (n, 7)."""
    return np.hstack([motion.q_world_body_wxyz, motion.omega_body])


def intervals_of(
    scenario: Scenario, motion: Trajectory, timestep: float | None, order: int, noise: FloatArray
) -> Intervals | None:
    """Return the intervals of a motion that are short enough; None if they are too few.

    Parameters
    ----------
    timestep : the timestep that it was made with, s; None if unknown: then the samples' distance is
        used
    order : of accuracy of the method that made it
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    """
    base = as_it_is(scenario)
    spans, equations = np.diff(motion.t), base.equations
    rates = np.maximum(norms(motion.omega_body), equations.rate)[:-1]
    # A body that starts from rest has rates only later.
    rates = np.maximum(rates, RESTS * rates.max())
    near = np.flatnonzero(spans * rates <= NEAR)
    if len(near) < FEWEST_INTERVALS or not motion.omega_body.any():
        return None
    kept = near[np.unique(np.linspace(0, len(near) - 1, MOST_INTERVALS).astype(int))]
    spans, rates, states = spans[kept], rates[kept], states_of(motion)
    taken = spans if timestep is None else np.minimum(timestep, spans)
    method = _of_method(equations, states[kept], spans, rates, rates * taken, order)
    return Intervals(base, states[kept], spans[:, None], states[kept + 1], noise, method)


def _of_method(
    equations: OtherEquations,
    states: FloatArray,
    spans: FloatArray,
    rates: FloatArray,
    turns: FloatArray,
    order: int,
) -> FloatArray:
    """Return bounds of a method's error over each span, in attitude, rad, and ω, rad/s, (S, 2).

    A step of order p is off by a part of the p-th power of the angle of a step: explicit Euler's by
    h²/2 of a second derivative, which is |ω'| times the rate at most. About a constant axis a step
    of order 1 turns correctly to second order.

    Parameters
    ----------
    turns : the angle of a step, rad, (S,)
    """
    made = follow(equations, states, spans[:, None])[:, 0, 4:]
    speed = float(norms(states[:, 4:]).max())
    fastest = float((norms(made - states[:, 4:]) / spans).max())
    turns = np.minimum(1.0, turns)
    of_turning = turns ** max(order, 2) * rates * spans / 4
    of_omega = turns**order * fastest * spans / 2
    return of_turning[:, None] * [1.0, speed] + of_omega[:, None] * np.stack(
        [1 / rates, np.ones_like(rates)], axis=1
    )
