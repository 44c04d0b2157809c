"""A recording that is to be explained: read in one way, beside the exact motion at its times."""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray, Misfit, Scenario, Trajectory
from ....scenarios.rotation import norms
from ....scenarios.scenario import started_at
from ..explaining.hypothesis import Hypothesis
from ..explaining.search import LEFT
from .files.exact_at import exact_at
from .files.motion import Reading, RecordedMotion, recorded_motion
from .files.recording import Recording, RecordingError
from .fits.other_physics import Physics
from .samples.digits import Numbers, numbers_of
from .samples.intervals import FEWEST_INTERVALS, intervals_of
from .samples.jumps import FAR, Jump, jumps
from .samples.mistakes import FITS

#: Names of the settings by which a file states the noise of attitude, rad, and of ω, rad/s.
NOISE = ("noise_attitude", "noise_omega")
#: Error by rounding in following the exact motion over a short interval, in units of the relative
#: resolution of the printed numbers.
ROUNDINGS = 8.0
#: Largest error of an ω that is computed from attitudes, in multiples of `DerivedOmega.error`.
STENCIL_ERRORS = 4.0


@dataclass(frozen=True, eq=False)
class Case:
    """A recording that is to be explained.

    Attributes
    ----------
    reading : the samples of the recording, read in one way
    exact, recorded : the exact motion, and the recorded one in that reading, at the reading's times
    timestep : timestep with which the motion was computed, s; None if unknown
    order : order of accuracy of the method that computed it
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,), of the noise or coarse
        rounding that earlier findings showed; zeros if they showed none
    undone : how often mistakes in recording have been undone in the reading
    is_smooth : whether samples have been left out because of a jump: no more jumps are looked for
    is_trial : whether the case is only tried: its explanation ends early if something stays open
    """

    scenario: Scenario
    recording: Recording
    reading: Reading
    exact: Trajectory
    recorded: RecordedMotion
    timestep: float | None
    order: int
    noise: FloatArray = field(default_factory=lambda: np.zeros(2))
    undone: int = 0
    is_smooth: bool = False
    is_trial: bool = False

    @property
    def motion(self) -> Trajectory:
        """The recorded motion."""
        return self.recorded.trajectory

    @property
    def has_omega(self) -> bool:
        """Whether ω was recorded."""
        return self.recorded.has_omega

    @property
    def reach(self) -> int:
        """How many samples on each side ω is computed from; 0 if it was recorded."""
        return self.recorded.derived.reach if self.recorded.derived else 0

    def of(self, samples: NDArray[np.intp]) -> "Case | None":
        """Return the case with only some of the samples, given by their indices, (k,).

        Returns
        -------
        None if they are too few, or too far apart to compute ω from attitudes
        """
        if len(samples) <= FEWEST_INTERVALS:
            return None
        try:
            return self._of_samples(self.reading.rows(samples), samples)
        except RecordingError:
            return None

    def read(self, reading: Reading) -> "Case | None":
        """Return the case of the recording in another reading, with other times or fewer samples.

        Returns
        -------
        None if the reading has both fewer samples and other times; if it has other times, and these
        begin before 0 or the exact motion is not known at them; or if ω was not recorded, and the
        attitudes are too far apart to compute it
        """
        t = self.reading.t
        kept = np.flatnonzero(np.isin(t, reading.t))
        try:
            if len(kept) == len(reading.t):
                return self._of_samples(reading, kept)
            if len(reading.t) == len(t) and reading.t[0] >= 0:
                exact = exact_at(self.scenario, reading.t).trajectory
                return self._beside(self.recording, reading, exact)
        except RecordingError:
            pass
        return None

    def _of_samples(self, reading: Reading, kept: NDArray[np.intp]) -> "Case":
        """Return the case of the samples with indices `kept`; `reading` has only these samples."""
        arrays = {name: array[kept] for name, array in self.recording.arrays.items()}
        return self._beside(replace(self.recording, arrays=arrays), reading, self.exact.at(kept))

    def _beside(self, recording: Recording, reading: Reading, exact: Trajectory) -> "Case":
        """Return this case with another recording, reading, and exact motion at the same times."""
        recorded = recorded_motion(self.scenario, recording, reading, exact)
        return replace(self, recording=recording, reading=reading, exact=exact, recorded=recorded)

    @property
    def stated(self) -> FloatArray | None:
        """The stated standard deviations of attitude, rad, and ω, rad/s, (2,); None without any.

        Each is at least that of `floor`.
        """
        stated = [float(self.recording.settings.get(name, 0.0)) for name in NOISE]
        return np.maximum(stated, self.floor) if any(stated) else None

    @cached_property
    def rounding(self) -> FloatArray:
        """The error of attitude, rad, and ω, rad/s, by the rounding of printed numbers, (2,)."""
        motion = self.motion
        speed, distance = float(norms(motion.omega_body).max()), float(np.median(np.diff(motion.t)))
        # Rounding of ω about the axis of the largest moment turns a needle about its thin axis.
        turns = speed * distance * float(np.linalg.cond(self.scenario.inertia))
        rounding = ROUNDINGS * self.recording.resolution * np.array([1.0, speed or 1.0])
        return np.asarray((1 + turns) * rounding)

    @cached_property
    def floor(self) -> FloatArray:
        """The error of attitude, rad, and ω, rad/s, (2,), by rounding of the recorded numbers.

        If ω was not recorded, it includes the error of computing ω from attitudes.
        """
        derived, of_attitude = self.recorded.derived, self.rounding[0]
        if derived is None:
            return self.rounding
        distances = np.diff(self.motion.t)
        # Attitudes with errors that need no explanation have a rate between them with such errors.
        of_rounding = 2 * max(of_attitude, FITS) / float(distances.min())
        omega_error = STENCIL_ERRORS * derived.error + of_rounding
        return np.array([of_attitude + float(distances.max()) * omega_error, omega_error])

    @cached_property
    def of_intervals(self) -> FloatArray:
        """Standard deviations of the noise of attitude, rad, and ω, rad/s, in an interval, (2,).

        An interval between two samples has the noise of both.
        """
        least = self.floor if self.stated is None else np.sqrt(2) * self.stated
        return np.asarray(np.maximum(least, np.sqrt(2) * self.noise))

    @cached_property
    def physics(self) -> Physics:
        """The search for other physics that explain the recorded motion."""
        of_method = self.timestep, self.order, self.of_intervals
        return Physics(self.scenario, self.motion, self.exact, *of_method, self.reach)

    @cached_property
    def numbers(self) -> Numbers:
        """The columns of the recording, as they are read, beside the exact motion."""
        return numbers_of(self.recording, self.reading, self.exact)

    def jumps(self, base: Hypothesis | None = None) -> list[Jump]:
        """Return the jumps of a motion that obeys the equations between nearly all samples.

        The list is empty if the motion does not obey them, or has no jump.

        Parameters
        ----------
        base : the equations that the motion should obey; the scene's if None
        """
        of_method = self.timestep, self.order, self.of_intervals
        intervals = intervals_of(self.scenario, self.motion, *of_method, near=FAR)
        if intervals and base is not None:
            # Deviations far below what the base explains are no jumps of the motion.
            noise = np.maximum(intervals.noise, LEFT**2 * self.physics.off)
            intervals = replace(intervals, base=base, noise=noise)
        return jumps(intervals, self.reach) if intervals else []

    def as_it_begins(self) -> "Case | None":
        """Return the case in which the scene starts with the first recorded state.

        Returns
        -------
        None if ω was not recorded, if the first sample is later than the scene's start, if its
        state is no valid start, or if the exact motion from that state is not known
        """
        if not self.has_omega or self.exact.t[0]:
            return None
        first = {f.name: getattr(self.motion, f.name)[0] for f in fields(self.motion)}
        del first["t"]
        if self.reading.spins is None:
            first["spins"] = self.scenario.start_spins
        try:
            scenario = started_at(self.scenario, **first)
            exact = exact_at(scenario, self.reading.t).trajectory
            return replace(self, scenario=scenario)._beside(self.recording, self.reading, exact)
        except (RecordingError, Misfit):
            return None
