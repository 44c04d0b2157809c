"""A recorded motion from sample to sample, beside what a method may make of it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....reference.following import EXACT, Integrator, follow
from ....reference.other_equations import OtherEquations
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms, rotation_vectors
from ..measuring.changes import Hypothesis, as_it_is
from ..measuring.likelihood import Data

#: rad between two samples at most; intervals looked at.
NEAR, FEWEST_INTERVALS, MOST_INTERVALS = 0.7, 4, 60
#: Rates this small beside the largest are no rates of a motion.
RESTS = 1e-6


@dataclass(frozen=True, eq=False)
class Intervals(Data):
    """Recorded states, and those that follow them.

    Attributes
    ----------
    starts : q, scalar first, and ω, rad/s, body axes, (S, 7)
    spans : s, (S, 1)
    ends : recorded a span later, (S, 7)
    noise : standard deviations that numbers have, of attitude, rad, and of ω, rad/s, (2,)
    method : what a method's error may come to, of the same, (S, 2)
    """

    starts: FloatArray
    spans: FloatArray
    ends: FloatArray
    noise: FloatArray
    method: FloatArray

    @cached_property
    def scale(self) -> FloatArray:
        """(S, 6)."""
        return np.repeat(np.hypot(self.noise, self.method), 3, axis=1)

    @cached_property
    def at_once(self) -> float:
        """How many of the numbers left count as one: all, where a method's error is larger.

        What a method does wrong is the same all along, however many samples show it.
        """
        of_method = float(np.mean(self.method**2 / (self.noise**2 + self.method**2)))
        return 1 + (self.scale.size - 1) * of_method

    def falls(self, before: FloatArray, after: FloatArray) -> float:
        """As of `Data`."""
        return super().falls(before, after) / self.at_once

    def off(self, hypothesis: Hypothesis, samples: int | None = None) -> FloatArray:
        """As of `Data`, (S, 6)."""
        return self.apart(hypothesis.equations)[:samples] / self.scale[:samples]

    def apart(
        self, equations: OtherEquations, integrator: Integrator = EXACT, timestep: float = 0.0
    ) -> FloatArray:
        """How far the recording is from where equations lead, rad and rad/s, (S, 6)."""
        return apart(
            follow(equations, self.starts, self.spans, integrator, timestep)[:, 0], self.ends
        )

    def spread(self, most: int) -> "Intervals":
        """Return so many of them at most, spread over all."""
        kept = np.unique(np.linspace(0, len(self.spans) - 1, most).astype(int))
        starts, spans, ends = self.starts[kept], self.spans[kept], self.ends[kept]
        return Intervals(self.base, starts, spans, ends, self.noise, self.method[kept])


def apart(made: FloatArray, recorded: FloatArray) -> FloatArray:
    """How far recorded states (S, 7) are from others, rad and rad/s, (S, 6)."""
    turned = rotation_vectors(made[:, :4], recorded[:, :4])
    return np.hstack([turned, recorded[:, 4:] - made[:, 4:]])


def states_of(motion: Trajectory) -> FloatArray:
    """q, scalar first, and ω, rad/s, body axes, of each sample, (n, 7)."""
    return np.hstack([motion.q_world_body_wxyz, motion.omega_body])


def intervals_of(
    scenario: Scenario, motion: Trajectory, timestep: float | None, order: int, noise: FloatArray
) -> Intervals | None:
    """Return the intervals of a motion that are short enough; None if they are too few.

    Parameters
    ----------
    timestep : s, that it was made with; None if that is unknown: then the samples' distance
    order : of accuracy of the method that made it
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    """
    base = as_it_is(scenario)
    spans, equations = np.diff(motion.t), base.equations
    rates = np.maximum(norms(motion.omega_body), equations.rate)[:-1]
    # A body may start from rest.
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
    """What the error of a method may come to over each span, attitude, rad, and ω, rad/s, (S, 2).

    A step of order p is off by its share of the p-th power of the angle of a step: explicit Euler's
    by h²/2 of a second derivative, |ω'| times the rate at most. About an axis that stays a step of
    order 1 turns to second order as it should.

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
