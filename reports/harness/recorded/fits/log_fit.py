"""Fits the exact motion to the samples of a measured one, with the changes that these require.

A change (`Change`) is one of the start, the tensor, another term of the equations, or how a sensor
reads. All samples are fitted at once by maximum likelihood, with normal and independent noise.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import chdtrc, chdtri, fdtrc

from .....reference.deviations import apart
from .....reference.following import follow_each
from .....scenarios import FloatArray, Scenario
from .....scenarios.rotation import norms
from ...explaining.changes import has_tensor, tensor
from ...explaining.effect_changes import (
    com,
    drags_of_other_powers,
    of_momentum,
    resistance,
    torques,
    usual_torque,
)
from ...explaining.fit import Fit, Trial
from ...explaining.hypothesis import Change, Hypothesis
from ...explaining.search import LEFT, SIGNIFICANCE
from ..samples.alternation import SHARED
from ..samples.sensors import CROSS_AXIS, OF_LOGS, READINGS
from .log import Log
from .motion_changes import TIMES, changes_of_motion
from .motion_effects import (
    by_attitude,
    dipole,
    momentum,
    tilt,
    world_turning,
)
from .right_by_itself import right_by_itself, uneven_times
from .stepwise import Stepwise

#: The most changes that are fitted together. The most parameters of a change that is not in
#: `LogFit.general`.
MOST_CHANGES, MOST_PARAMETERS = 4, 3
#: Largest time by which all states may be late: the body turns by this angle in it, rad.
LATEST = 30.0

#: The change of the first state: a rotation vector, rad, and a difference of ω, rad/s, body axes.
START = Change("start", lambda h, n: h.of(start=h.start + n), np.ones(6))


@dataclass(frozen=True, eq=False)
class LogFit:
    """The fit of a measured motion, with all changes of equations or sensors that it requires.

    Attributes
    ----------
    scenario : the scene whose exact motion is fitted
    given : the samples, with the noise that was stated, or estimated before any fit
    """

    scenario: Scenario
    given: Log

    @cached_property
    def tensor(self) -> Change:
        """The change of the tensor of inertia; its parameters are deviations from the scene's."""
        return tensor(self.given.base)

    @cached_property
    def by_attitude(self) -> Change:
        """The change of the equations that adds a torque which depends on the attitude."""
        return by_attitude(usual_torque(self.scenario, self.given.base))

    @cached_property
    def axes(self) -> Change:
        """The change in which attitude and ω are recorded along other axes than the body's.

        Its parameters are the rotation vector, rad, that turns the body's axes to the others.
        """
        omega = self.given.scene_start[4:]

        def turn_axes(h: Hypothesis, turn: FloatArray) -> Hypothesis:
            turns = Rotation.from_rotvec(turn)
            R, back = turns.as_matrix(), turns.inv()
            of_body = {name: back.apply(getattr(h, name)) for name in ("pull", "torque", "kept")}
            start = np.hstack([turn, back.apply(omega) - omega])
            inertia = np.swapaxes(R, 1, 2) @ h.inertia @ R
            return h.with_inertia(inertia).of(**of_body, start=start)

        return Change("axes of the body", turn_axes, np.ones(3))

    @cached_property
    def late(self) -> Change:
        """The change in which each recorded state is that of an earlier time.

        Its parameter is how much earlier that time is, s. If it is negative, the time is later.
        """
        start = self.given.scene_start[None]
        rate = max(float(norms(start[:, 4:])[0]), float(self.given.base.rate)) or 1.0
        most = LATEST / rate

        def shift_time(h: Hypothesis, time: FloatArray) -> Hypothesis:
            starts = np.repeat(start[None], len(time), axis=0)
            before = follow_each(h, starts, -np.clip(time, -most, most)[:, None])[:, 0, 0]
            return h.of(start=apart(starts[:, 0], before))

        return Change("late", shift_time, np.array([1 / rate]))

    @cached_property
    def general(self) -> list[Change]:
        """The changes, of equations or sensors, that measured motions most often require."""
        equations = self.given.base
        scene = self.scenario, equations
        found = [START, self.tensor, TIMES, *resistance(*scene), *com(*scene)]
        found += [*tilt(equations), *of_momentum(equations), *torques(*scene)]
        found += [momentum(*scene), *drags_of_other_powers(*scene)]
        return [*found, *OF_LOGS, world_turning(1.0)] if self.given.has_omega else found

    @cached_property
    def search(self) -> Stepwise:
        """The search for the changes of equations or sensors that the samples in `given` require.

        Changes of a tensor's moments about given axes are not tried, as noise may hide that the
        tensor has other axes.
        """
        special = [one for one in changes_of_motion(self.scenario) if one not in READINGS]
        special = [one for one in special if len(one.scales) <= MOST_PARAMETERS]
        usual = [*self.general, self.late, self.axes]
        forms = {one.form for one in usual}
        special = [one for one in special if one.form not in forms]
        special = [one for one in special if one.is_possible is not has_tensor]
        return Stepwise(self.given, [*usual, *special], usual=usual)

    @cached_property
    def requires_nothing(self) -> bool:
        """Whether the samples are those of the scene within noise, and no change improves the fit.

        All changes are tried, linearised, on all samples at once.
        """
        if self._is_beyond(self.search.unchanged):
            return False
        every = replace(self.search, changes=[*self.search.changes, self.by_attitude])
        return every.stepwise(self.search.unchanged, MOST_CHANGES) is self.search.unchanged

    @cached_property
    def found(self) -> Fit:
        """The best fit, with all changes of equations or sensors that the samples require."""
        search = self.search
        if self.requires_nothing:
            return search.unchanged
        # A fit from the first samples of a sensitive motion may go astray.
        first = search.from_first_samples(MOST_CHANGES)
        found = max(search.unchanged, first, key=search.score)
        if self._is_beyond(found) or len(found.changes) > 1:
            # Most measured bodies have another start and tensor than the scene, whatever else.
            other = search.from_first_samples(MOST_CHANGES, (START, self.tensor))
            found = max(found, other, key=search.score)
        if self._is_beyond(found) and self.given.has_omega and not self.right_by_itself:
            every = replace(search, changes=[*search.changes, CROSS_AXIS])
            found = max(found, every.stepwise(found, MOST_CHANGES), key=search.score)
        # A torque that depends on the attitude has so many parameters that it explains a part of
        # any motion. It counts only if nothing beyond noise is left.
        torque = Trial(self.given, (self.by_attitude,)).fit()
        if not self._is_beyond(torque):
            found = max(found, torque, key=search.score)
        if found is torque:
            of_dipole = Trial(self.given, (dipole(torque.parameters.reshape(3, 3)),)).fit()
            if search.improvement(of_dipole, torque) <= 0:
                return of_dipole
        # The start of most measured bodies is not known well: its change is not to be replaced by a
        # simpler one.
        return found if self._is_beyond(found) else search.simplified(found, but=START)

    def alternatives(self, change: Change) -> list[tuple[float, Change, Fit]]:
        """Return the sensor errors that explain the samples about as well as a given one.

        If ω hardly changes, for instance, a bias and a scale factor have the same effect.

        Parameters
        ----------
        change : a sensor error, which is one of the changes of `found`

        Returns
        -------
        For each other error, the likeliest first: its likelihood relative to that of the given one,
        the other error, and the fit with it in place of the given one. Errors with a relative
        likelihood of `SIGNIFICANCE` or less are left out
        """
        fits = []
        for other in OF_LOGS:
            # An error with more parameters explains the samples as well in any case.
            if other not in self.found.changes and len(other.scales) <= len(change.scales):
                changes = (other if one is change else one for one in self.found.changes)
                fit = Trial(self.given, tuple(changes)).fit(self.found)
                difference = self.search.score(fit) - self.search.score(self.found)
                fits.append((float(np.exp(min(difference, 0.0) / 2)), other, fit))
        return sorted((one for one in fits if one[0] > SIGNIFICANCE), key=lambda one: -one[0])

    @cached_property
    def uneven_times(self) -> list[str]:
        """A list of the sentence that each state is, within noise, the exact one at another time.

        The list is empty if the states are not, or if all are late by about the same time.
        """
        return uneven_times(self.given, self.search.unchanged.residuals)

    @cached_property
    def right_by_itself(self) -> list[str]:
        """A list of the sentence on which part of the recording is exact, but for noise.

        The part may be all but the times, the attitude alone, or ω alone. The list is empty if none
        of these agrees with the exact motion, or if both attitude and ω do.
        """
        return self.uneven_times or right_by_itself(self.given, self.search.unchanged.residuals)

    @cached_property
    def log(self) -> Log:
        """The samples, with the noise that is assumed once `found` is known.

        The noise is estimated anew from the residuals of the best fit. It stays as in `given` if it
        was stated, or if these residuals exceed noise.
        """
        is_noise = self.given.is_stated or self.is_beyond
        return self.given if is_noise else self.given.with_noise_of(self.found)

    @cached_property
    def fit(self) -> Fit:
        """The fit of the changes in `found`, repeated with the noise of `log` as weights."""
        return Trial(self.log, self.found.changes).fit(self.found)

    @cached_property
    def with_tensor(self) -> Fit:
        """The best fit, with changes of start and tensor added if it does not have them."""
        more = [one for one in (START, self.tensor) if one not in self.found.changes]
        trial = Trial(self.log, (*self.found.changes, *more))
        fit = trial.fit(self.found)
        # Where a tensor imitates changes that were found, parameters of zero are a better start.
        return trial.fit() if self._is_beyond(fit) else fit

    @cached_property
    def freedom(self) -> int:
        """The degrees of freedom: the number of residuals less the number of fitted parameters."""
        return self.found.residuals.size - len(self.found.parameters)

    @cached_property
    def is_beyond(self) -> bool:
        """Whether the residuals of the best fit exceed noise."""
        return self._is_beyond(self.found)

    def _is_beyond(self, fit: Fit) -> bool:
        """Return whether the residuals of a fit exceed noise, by a χ² test or an F-test.

        The F-test is used if the noise is not stated, as it was then estimated from samples, too.
        """
        (squares,) = self.given.squares(fit.residuals[None])
        freedom = fit.residuals.size - len(fit.parameters)
        if self.given.is_stated:
            return float(chdtrc(freedom, squares.sum())) < SIGNIFICANCE
        each = freedom / len(squares)
        ratios = squares / each
        return float(fdtrc(each, 3 * len(self.given.t) / SHARED, ratios.max())) < SIGNIFICANCE

    @property
    def is_far(self) -> bool:
        """Whether the residuals exceed noise by so much that standard errors mean nothing."""
        return self.is_beyond and self.chi2 > self.freedom / LEFT

    @property
    def chi2(self) -> float:
        """The sum of squares of the residuals of `fit`, in standard deviations of noise."""
        return float(np.sum(self.fit.residuals**2))

    @property
    def inflation(self) -> float:
        """The factor by which standard errors are multiplied.

        It is √(χ² / degrees of freedom) if the residuals exceed noise, else 1. The Particle Data
        Group scales errors in this way if measurements differ by more than their errors (R. L.
        Workman et al., Prog. Theor. Exp. Phys. 2022, 083C01, §5.2.2).
        """
        return float(np.sqrt(self.chi2 / self.freedom)) if self.is_beyond else 1.0

    def is_required(self, change: Change) -> bool:
        """Return whether samples require a change: its parameters differ significantly from zero.

        A change without parameters always counts as required.

        Parameters
        ----------
        change : one of the changes of `fit`
        """
        if not len(change.scales):
            return True
        indices, estimates = self.fit.columns(change), self.fit.parameters_of(change)
        errors = self.fit.errors[indices] * self.inflation
        in_errors = estimates / errors
        # The correlation matrix is nearly singular if only a combination of parameters is known.
        correlation = (
            self.fit.covariance[indices, indices] * self.inflation**2 / np.outer(errors, errors)
        )
        squares = in_errors @ np.linalg.lstsq(correlation, in_errors, rcond=None)[0]
        return bool(squares > chdtri(len(estimates), SIGNIFICANCE))

    @property
    def shows_tensor(self) -> bool:
        """Whether the samples determine the tensor of inertia.

        They do if no standard error of an entry exceeds the largest entry. They do not if the
        residuals of `with_tensor` exceed noise and those of `found` do not: then the tensor only
        imitates changes that the samples require.
        """
        if self._is_beyond(self.with_tensor) and not self.is_beyond:
            return False
        entries, errors = self.tensor_entries()
        return bool(errors.max() <= np.abs(entries).max())

    def tensor_entries(self) -> tuple[FloatArray, FloatArray]:
        """Return the entries of the fitted tensor, kg m², and their standard errors, (6,) each.

        The entries are Ixx, Iyy, Izz, Ixy, Ixz, Iyz. Their errors are multiplied by `inflation`.
        """
        fit, entries = self.with_tensor, self.tensor.shown
        indices, count = fit.columns(self.tensor), len(self.tensor.scales)
        usual = np.asarray(entries(np.zeros(count)))
        slopes = np.array([entries(unit) for unit in np.eye(count)]) - usual
        covariance = slopes.T @ fit.covariance[indices, indices] @ slopes
        errors = np.sqrt(np.diag(covariance)) * self.inflation
        return np.asarray(entries(fit.parameters[indices])), errors
