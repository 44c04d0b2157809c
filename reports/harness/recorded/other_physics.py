"""Other physics that explain a recorded motion: a clamp, an integrator, changes of the equations.

From each sample to the next one what the recording gains beyond the exact flow is compared with
what such changes would make: so it shows at any time, however far the motion is from the exact one
by then.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....reference.following import KNOWN
from ....reference.other_equations import OtherEquations
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from ...results.change_words import KINDS
from ..measuring.changes import changes
from ..measuring.likelihood import LEFT, Fit, Search
from .intervals import Intervals, intervals_of

#: Intervals that integrators are tried on, whose steps are many.
FEW = 12
#: Of what an integrator does wrong, what may be left: its steps are those, or they are not.
SAME = 1e-3
#: Samples at which a clamp is looked for, and how well it has to fit, relative.
FIRST, CLAMPED = 3, 1e-2
#: rad/s; no body turns so slowly.
TINY = 1e-300
#: What the rounding of numbers makes of a short flow, in their distance from one another.
ROUNDINGS = 8.0
#: Relative, of a span that is a multiple of the timestep.
MULTIPLE = 1e-6
KINEMATICS = "ω obeys Euler's equations, but the attitude does not follow ω"
DYNAMICS = "the attitude follows ω, but ω does not obey Euler's equations"


@dataclass(frozen=True, eq=False)
class Physics:
    """A recorded motion, and what may have made it.

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
        """The motion from sample to sample; None where these are too few, or too far apart."""
        return intervals_of(self.scenario, self.motion, self.timestep, self.order, self.noise)

    @cached_property
    def search(self) -> Search | None:
        """The search for a change of the equations."""
        data = self.intervals
        return None if data is None else Search(data, tuple(changes(self.scenario)))

    @property
    def is_beyond(self) -> bool:
        """Whether the recording is beyond what a method of its order and timestep makes."""
        return self.search is not None and self.search.is_called_for

    @cached_property
    def made_by(self) -> str:
        """The known integrator that made the motion by the scene's equations; empty if none did."""
        data = self.intervals
        return self._integrator(data, data.base.equations) if data else ""

    def _integrator(self, data: Intervals, equations: OtherEquations) -> str:
        """The known integrator that made the motion by these equations; empty if none did."""
        h = self.timestep
        if h is None:
            return ""
        intervals, scale = data.spread(FEW), np.repeat(self.noise, 3)
        multiples = intervals.spans / h
        if (np.abs(multiples - np.rint(multiples)) > MULTIPLE * multiples).any():
            return ""
        exactly = float(np.mean((intervals.apart(equations) / scale) ** 2))
        left = [float(np.mean((intervals.apart(equations, one, h) / scale) ** 2)) for one in KNOWN]
        best = int(np.argmin(left))
        if exactly <= 1 or not left[best] <= max(1.0, SAME**2 * exactly):
            return ""
        return f"what {KNOWN[best].name} at {h:.4g} s makes"

    def explained(self) -> list[str]:
        """The clamp, or the changes, that explain the motion, in words; often none."""
        clamps = _clamps(self.motion, self.exact) if len(self.motion.t) > FIRST else ()
        if words := [*clamps][:1]:
            return words
        if self.intervals is None or self.search is None or not self.search.is_called_for:
            return []
        found = self.search.one_or_two()
        return self._in_words(self.intervals, found) if found else _where(self.intervals)

    def _in_words(self, data: Intervals, found: Fit) -> list[str]:
        sentences = []
        for change in found.changes:
            before = f"{KINEMATICS}: " if KINDS[change.kind].is_kinematic else "it moves as if "
            sentences.append(before + found.explanation(change).words)
        if made := self._integrator(data, found.hypothesis.equations):
            sentences.append(f"what is left is {made}")
        return sentences


def _where(data: Intervals) -> list[str]:
    """Whether it is kinematics alone, or dynamics, where no change explains the motion."""
    off = data.apart(data.base.equations)
    turned, omega = (np.sqrt(np.mean(part**2, axis=1)) for part in np.split(off, 2, axis=1))
    left = np.mean((off / data.scale) ** 2, axis=0)
    if left[3:].mean() <= 1:
        return [KINEMATICS]
    if (turned <= np.hypot(data.spans[:, 0] * omega, data.scale[:, 0])).all():
        return [DYNAMICS]
    return []


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
    clamped = right.omega_body * np.where(speeds > bound, bound / np.maximum(speeds, TINY), 1.0)
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
