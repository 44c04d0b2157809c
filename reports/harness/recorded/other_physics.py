"""Other physics that explain a recorded motion: a clamp, an integrator, changes of the equations.

From each sample to the next one what the recording gains beyond the exact flow is compared with
what such changes would make: so it shows at any time, however far the motion is from the exact one
by then.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....reference.other_equations import KNOWN, OtherEquations, equations_of, follow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from .changes import changes
from .fits import LEFT, Fit, Intervals, Search

#: rad between two samples at most; intervals looked at.
NEAR, FEWEST_INTERVALS, MOST_INTERVALS = 0.7, 4, 60
#: Intervals that integrators are tried on, whose steps are many.
FEW = 12
#: Of what an integrator does wrong, what may be left: its steps are those, or they are not.
SAME = 1e-3
#: Samples at which a clamp is looked for, and how well it has to fit, relative.
FIRST, CLAMPED = 3, 1e-2
#: What the rounding of numbers makes of a short flow, in their distance from one another.
ROUNDINGS = 8.0
#: Relative, of a span that is a multiple of the timestep.
MULTIPLE = 1e-6
KINEMATICS = "ω obeys Euler's equations, but the attitude does not follow ω"
DYNAMICS = "the attitude follows ω, but ω does not obey Euler's equations"


@dataclass(frozen=True, eq=False)
class Physics:
    """A recorded motion from sample to sample, beside what a method may make of it.

    Attributes
    ----------
    motion, exact : recorded, and exact at the same times
    timestep : s, that it was made with; None if that is unknown: then the samples' distance
    order : of accuracy of the method that made it
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    """

    scenario: Scenario
    motion: Trajectory
    exact: Trajectory
    timestep: float | None
    order: int
    noise: FloatArray

    @cached_property
    def intervals(self) -> Intervals | None:
        """Those that are short enough; None if they are too few."""
        motion = self.motion
        spans, equations = np.diff(motion.t), self.equations
        rates = np.maximum(norms(motion.omega_body), equations.rate)[:-1]
        near = np.flatnonzero(spans * rates <= NEAR)
        if len(near) < FEWEST_INTERVALS or not motion.omega_body.any():
            return None
        kept = near[np.unique(np.linspace(0, len(near) - 1, MOST_INTERVALS).astype(int))]
        spans, rates = spans[kept], rates[kept]
        states = np.hstack([motion.q_world_body_wxyz, motion.omega_body])
        taken = spans if self.timestep is None else np.minimum(self.timestep, spans)
        method = _of_method(self.equations, states[kept], spans, rates, rates * taken, self.order)
        return Intervals(states[kept], spans[:, None], states[kept + 1], self.noise, method)

    @cached_property
    def equations(self) -> OtherEquations:
        """The scene's."""
        return equations_of(self.scenario)

    @cached_property
    def search(self) -> Search | None:
        """The search for a change of the equations."""
        if self.intervals is None:
            return None
        return Search(self.intervals, self.equations, tuple(changes(self.scenario, self.equations)))

    @property
    def is_beyond(self) -> bool:
        """Whether the recording is beyond what a method of its order and timestep makes."""
        return self.search is not None and self.search.is_called_for

    def integrator(self, equations: OtherEquations) -> str | None:
        """The known integrator that made the motion by these equations; None if none did."""
        if self.intervals is None or self.timestep is None:
            return None
        intervals, h = self.intervals.spread(FEW), self.timestep
        multiples = intervals.spans / h
        if (np.abs(multiples - np.rint(multiples)) > MULTIPLE * multiples).any():
            return None
        scale = np.repeat(self.noise, 3)
        exactly = float(np.mean((intervals.off(equations) / scale) ** 2))
        left = [float(np.mean((intervals.off(equations, one, h) / scale) ** 2)) for one in KNOWN]
        best = int(np.argmin(left))
        if exactly <= 1 or left[best] > max(1.0, SAME**2 * exactly):
            return None
        return f"what {KNOWN[best].name} at {h:.4g} s makes"

    def explained(self) -> list[str]:
        """The clamp, or the changes, that explain the motion, in words; often none."""
        clamps = _clamps(self.motion, self.exact) if len(self.motion.t) > FIRST else ()
        if words := [*clamps][:1]:
            return words
        search = self.search
        if search is None or not search.is_called_for:
            return []
        if (found := search.found()) is not None:
            return self._in_words(found)
        return self._where(search)

    def _in_words(self, found: Fit) -> list[str]:
        sentences = [
            f"{KINEMATICS}: {words}" if change.is_kinematic else f"it moves as if {words}"
            for change, words in zip(found.changes, found.words, strict=True)
        ]
        if made := self.integrator(found.equations):
            sentences.append(f"what is left is {made}")
        return sentences

    def _where(self, search: Search) -> list[str]:
        """Whether it is kinematics alone, or dynamics, where no change explains the motion."""
        intervals = search.intervals
        off = intervals.off(self.equations)
        turned, omega = (np.sqrt(np.mean(part**2, axis=1)) for part in np.split(off, 2, axis=1))
        left = np.mean((off / intervals.scale) ** 2, axis=0)
        if left[3:].mean() <= 1:
            return [KINEMATICS]
        if (turned <= np.hypot(intervals.spans[:, 0] * omega, intervals.scale[:, 0])).all():
            return [DYNAMICS]
        return []


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


def _clamps(motion: Trajectory, exact: Trajectory) -> Iterator[str]:
    """Clamps of ω that make of the first exact samples what was recorded."""
    # The first may be the start as it was set.
    recorded, right = (one.until(FIRST + 1).at(np.arange(1, FIRST + 1)) for one in (motion, exact))
    frames = (
        ("each component of ω in world axes", recorded.to_world, right.to_world),
        ("each component of ω in body axes", np.asarray, np.asarray),
    )
    for words, of_recorded, of_right in frames:
        omega, wanted = of_recorded(recorded.omega_body), of_right(right.omega_body)
        bound = float(np.abs(omega).max())
        if _fits(omega, np.clip(wanted, -bound, bound), wanted):
            yield f"{words} is clamped to {bound:.4g} rad/s"
    speeds = norms(right.omega_body)[:, None]
    bound = float(norms(recorded.omega_body).max())
    clamped = right.omega_body * np.minimum(1.0, bound / np.maximum(speeds, bound))
    if _fits(recorded.omega_body, clamped, right.omega_body):
        yield f"‖ω‖ is clamped to {bound:.4g} rad/s"


def _fits(omega: FloatArray, clamped: FloatArray, wanted: FloatArray) -> bool:
    """Whether ω is what a clamp makes of what it should be, and it makes something else of it."""
    size = float(norms(wanted).max())
    off, changed = (float(norms(one - clamped).max()) for one in (omega, wanted))
    is_moving = bool(clamped.any())
    return is_moving and off <= CLAMPED * size and changed > off / LEFT and changed > CLAMPED * size


def rounding(motion: Trajectory, resolution: float) -> FloatArray:
    """What the rounding of numbers makes of attitude, rad, and ω, rad/s, (2,).

    Parameters
    ----------
    resolution : relative, of the numbers
    """
    speed = float(norms(motion.omega_body).max()) or 1.0
    return ROUNDINGS * resolution * np.array([1.0, speed])
