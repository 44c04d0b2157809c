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
from .samples.alternation import Alternation, alternation
from .samples.digits import Numbers, numbers_of
from .samples.intervals import FEWEST_INTERVALS, intervals_of
from .samples.jumps import FAR, Jump, jumps
from .samples.mistakes import FITS

#: Names of the settings by which a file states the noise of attitude, rad, and of ω, rad/s.
NOISE = ("noise_attitude", "noise_omega")
#: Bound on the error that rounded numbers cause over a short interval, relative, in multiples of
#: the relative resolution of the numbers.
ROUNDINGS = 8.0
#: Bound on the error of an ω that is computed from attitudes, in multiples of `DerivedOmega.error`.
STENCIL_ERRORS = 4.0


@dataclass(frozen=True, eq=False)
class Case:
    """A recording that is to be explained, with the exact motion at its times.

    Attributes
    ----------
    scenario : the scene whose exact motion the recording is compared with
    recording : the numbers of the file
    reading : the samples of the recording, read in one way
    exact : the exact motion at the times of the reading
    recorded : the recorded motion in that reading
    timestep : timestep with which the motion was computed, s; None if unknown
    order : order of accuracy of the method that computed the motion
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,), by noise or coarse rounding
        that was found in the recording before; zeros if none was found
    undone : how many times mistakes in recording have been corrected in the reading
    is_smooth : whether samples have been left out because of a jump; if so, no more jumps are
        looked for
    is_trial : whether the case is only a trial, which is given up as soon as part of the motion
        stays unexplained
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
        """The number of samples on each side of a sample from which its ω is computed.

        It is 0 if ω was recorded.
        """
        return self.recorded.derived.reach if self.recorded.derived else 0

    def of(self, samples: NDArray[np.intp]) -> "Case | None":
        """Return the case with only k of the samples, given by their indices, (k,).

        Returns
        -------
        The case; None if there are too few of these samples, or if ω was not recorded and they are
        too far apart to compute it from the attitudes
        """
        if len(samples) <= FEWEST_INTERVALS:
            return None
        try:
            return self._of_samples(self.reading.rows(samples), samples)
        except RecordingError:
            return None

    def read(self, reading: Reading) -> "Case | None":
        """Return the case of the same recording, read in another way.

        Parameters
        ----------
        reading : another reading, with all samples or with some of them. With all samples it may
            have other times

        Returns
        -------
        The case, or None in three situations: the reading has fewer samples and other times; its
        other times begin before 0 or the exact motion is not known at all of them; ω was not
        recorded and the attitudes are too far apart to compute it
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
        """Return this case with another recording, its reading, and the exact motion at its times.

        Raises
        ------
        RecordingError
            If ω was not recorded and the attitudes are too far apart to compute it.
        """
        recorded = recorded_motion(self.scenario, recording, reading, exact)
        return replace(self, recording=recording, reading=reading, exact=exact, recorded=recorded)

    @cached_property
    def stated(self) -> FloatArray | None:
        """The standard deviations of noise that the file states: attitude, rad, ω, rad/s, (2,).

        Each is at least the bound in `floor`. If the file states only that of attitude, that of ω
        is the noise found in the samples, if any. The property is None if it states neither.
        """
        stated = np.array([float(self.recording.settings.get(name, 0.0)) for name in NOISE])
        if not stated.any():
            return None
        found = None if stated[1] else self.alternates
        if found is not None and found.is_noise[1]:
            stated[1] = found.noise[1]
        return np.asarray(np.maximum(stated, self.floor))

    @cached_property
    def alternates(self) -> Alternation | None:
        """What alternates in the motion from sample to sample; None if nothing does."""
        return alternation(self.scenario, self.motion, self.rounding)

    @cached_property
    def rounding(self) -> FloatArray:
        """Bounds on the errors of attitude, rad, and ω, rad/s, by rounded numbers, (2,).

        They hold for the motion from one sample to the next, which starts from rounded numbers.
        """
        motion = self.motion
        speed, distance = float(norms(motion.omega_body).max()), float(np.median(np.diff(motion.t)))
        # An error of ω about the axis of the largest moment changes ω about that of the smallest
        # one in proportion to the ratio of these moments.
        turns = speed * distance * float(np.linalg.cond(self.scenario.inertia))
        rounding = ROUNDINGS * self.recording.resolution * np.array([1.0, speed or 1.0])
        return np.asarray((1 + turns) * rounding)

    @cached_property
    def floor(self) -> FloatArray:
        """Bounds on the errors of attitude, rad, and ω, rad/s, that need no explanation, (2,).

        They are those in `rounding`. If ω was not recorded, they include the error of computing it
        from attitudes.
        """
        derived, of_attitude = self.recorded.derived, self.rounding[0]
        if derived is None:
            return self.rounding
        distances = np.diff(self.motion.t)
        # The rate between two attitudes has the errors of both, over the time between them.
        of_rounding = 2 * max(of_attitude, FITS) / float(distances.min())
        omega_error = STENCIL_ERRORS * derived.error + of_rounding
        return np.array([of_attitude + float(distances.max()) * omega_error, omega_error])

    @cached_property
    def of_intervals(self) -> FloatArray:
        """Standard deviations of the noise of attitude, rad, and ω, rad/s, in an interval, (2,).

        An interval between two samples has the noise of both, hence √2 times that of one sample.
        """
        least = self.floor if self.stated is None else np.sqrt(2) * self.stated
        return np.asarray(np.maximum(least, np.sqrt(2) * self.noise))

    @cached_property
    def physics(self) -> Physics:
        """The search for other equations, an integrator or a bound on ω that explain the motion."""
        of_method = self.timestep, self.order, self.of_intervals
        return Physics(self.scenario, self.motion, self.exact, *of_method, self.reach)

    @cached_property
    def numbers(self) -> Numbers:
        """The columns of the recording, together with those of the exact motion."""
        return numbers_of(self.recording, self.reading, self.exact)

    def jumps(self, base: Hypothesis | None = None) -> list[Jump]:
        """Return the jumps of the motion: the few intervals in which it disobeys the equations.

        The list is empty if there is none, if the motion disobeys the equations in too many
        intervals, or if its samples are too few, or too far apart, to be compared with them.

        Parameters
        ----------
        base : the equations that the motion should obey; the scene's if None
        """
        of_method = self.timestep, self.order, self.of_intervals
        intervals = intervals_of(self.scenario, self.motion, *of_method, near=FAR)
        if intervals is None:
            return []
        intervals = replace(intervals, noise=self.physics.least)
        if base is not None:
            # Deviations far smaller than those that `base` explains are residuals of its fit, and
            # no jumps of the motion.
            noise = np.maximum(intervals.noise, LEFT**2 * self.physics.off)
            intervals = replace(intervals, base=base, noise=noise)
        return jumps(intervals, self.reach)

    def as_it_begins(self) -> "Case | None":
        """Return the case in which the scene starts with the first recorded state.

        Returns
        -------
        The case; None if ω was not recorded, if the first sample is later than the scene's start,
        if the first recorded state is no valid start of a scene, or if the exact motion from that
        state is not known at all times of the recording
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
