"""The fit of a measured motion: the start, tensor and mistakes that its samples require.

The exact motion is fitted to all samples at once by maximum likelihood, with normal and independent
noise.
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

#: Most changes that are fitted at once, and most parameters of a change that is not among those
#: that measured motions usually require.
MOST_CHANGES, MOST_PARAMETERS = 4, 3
#: Largest turn of the body, rad, in the time by which all states are late.
LATEST = 30.0
#: Factor by which the degrees of freedom of neighbouring fourth differences, which share noise, are
#: fewer than the differences: Σ (8 over 4+k)² / (8 over 4)².
SHARED = 2.63

#: The change of the first state: a rotation vector, rad, and a difference of ω, rad/s, body axes.
START = Change("start", lambda h, n: h.of(start=h.start + n), np.ones(6))


@dataclass(frozen=True, eq=False)
class LogFit:
    """The fit of a measured motion, with all the changes that its samples require.

    Attributes
    ----------
    given : the samples, with the noise that is stated, or was estimated before any fit
    """

    scenario: Scenario
    given: Log

    @cached_property
    def tensor(self) -> Change:
        """The change that fits the tensor of inertia, by its deviation from the scene's tensor."""
        return tensor(self.given.base)

    @cached_property
    def by_attitude(self) -> Change:
        """The change that adds torques that depend on the attitude."""
        return by_attitude(usual_torque(self.scenario, self.given.base))

    @cached_property
    def axes(self) -> Change:
        """The change in which attitude and ω are recorded along other axes than the body's.

        Its parameters are the rotation vector, rad, that turns the body's axes to the other axes.
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
        """The change in which each recorded state is the motion's at an earlier time.

        Its parameter is how much earlier that time is, s; a negative one means a later time.
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
        """The changes that measured motions most often require."""
        equations = self.given.base
        scene = self.scenario, equations
        found = [START, self.tensor, TIMES, *resistance(*scene), *com(*scene)]
        found += [*tilt(equations), *of_momentum(equations), *torques(*scene)]
        found += [momentum(*scene), *drags_of_other_powers(*scene)]
        return [*found, *OF_LOGS, world_turning(1.0)] if self.given.has_omega else found

    @cached_property
    def search(self) -> Stepwise:
        """The search for changes that the samples require, with the noise known before any fit.

        Changes that fit only the moments about given axes are left out, as noise may hide that the
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
    def found(self) -> Fit:
        """The best fit, with all the changes that the samples require."""
        search = self.search
        found = search.from_first_samples(MOST_CHANGES)
        if self._is_beyond(found) or len(found.changes) > 1:
            # Most measured bodies have another start and tensor, whatever else.
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
        # The start of most measured bodies is not known well, so that no simpler change needs to
        # explain it.
        return found if self._is_beyond(found) else search.simplified(found, but=START)

    def alternatives(self, change: Change) -> list[tuple[float, Change, Fit]]:
        """Return the mistakes of a gyroscope that explain about as much as a given one.

        If ω hardly changes, a bias and a scale are alike. Mistakes less likely than `SIGNIFICANCE`
        are left out.

        Parameters
        ----------
        change : one of the changes of `found`

        Returns
        -------
        For each mistake, the likeliest first: the likelihood relative to that with the given
        change, the change that the mistake is, and the fit with it
        """
        fits = []
        for other in OF_LOGS:
            # A mistake with more parameters explains as much in any case.
            if other not in self.found.changes and len(other.scales) <= len(change.scales):
                changes = (other if one is change else one for one in self.found.changes)
                fit = Trial(self.given, tuple(changes)).fit(self.found)
                difference = self.search.score(fit) - self.search.score(self.found)
                fits.append((float(np.exp(min(difference, 0.0) / 2)), other, fit))
        return sorted((one for one in fits if one[0] > SIGNIFICANCE), key=lambda one: -one[0])

    @cached_property
    def uneven_times(self) -> list[str]:
        """The sentence that each state is, within noise, the scene's at another time; or none."""
        return uneven_times(self.given, self.search.unchanged.residuals)

    @cached_property
    def right_by_itself(self) -> list[str]:
        """The sentence that attitude alone, ω alone, or each state at another time is the scene's.

        The list is empty if none of these is so.
        """
        return self.uneven_times or right_by_itself(self.given, self.search.unchanged.residuals)

    @cached_property
    def log(self) -> Log:
        """The samples, with the noise that later fits assume.

        The noise is estimated from the residuals of the best fit. It stays as in `given` if it was
        stated, or if the residuals are larger than noise explains.
        """
        is_noise = self.given.is_stated or self.is_beyond
        return self.given if is_noise else self.given.with_noise_of(self.found)

    @cached_property
    def fit(self) -> Fit:
        """The best fit with the noise of `log`."""
        return Trial(self.log, self.found.changes).fit(self.found)

    @cached_property
    def with_tensor(self) -> Fit:
        """The best fit, with start and tensor added even if the samples do not require them."""
        more = [one for one in (START, self.tensor) if one not in self.found.changes]
        trial = Trial(self.log, (*self.found.changes, *more))
        fit = trial.fit(self.found)
        # A tensor that takes the place of changes that were found is fitted from zero.
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
        """Whether the residuals of a fit exceed noise.

        The test is a χ² test if the noise is stated. Otherwise the noise was estimated itself, and
        the test is an F test.
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
        """Whether the residuals exceed noise so far that standard errors mean nothing."""
        return self.is_beyond and self.chi2 > self.freedom / LEFT

    @property
    def chi2(self) -> float:
        """The sum of squares of the residuals, in standard deviations of noise."""
        return float(np.sum(self.fit.residuals**2))

    @property
    def inflation(self) -> float:
        """The factor of standard errors, √(χ² / degrees of freedom), where residuals exceed noise.

        It is 1 if the residuals do not exceed noise. The Particle Data Group scale errors so where
        measurements differ by more than their errors (R. L. Workman et al., Prog. Theor. Exp. Phys.
        2022, 083C01, §5.2.2).
        """
        return float(np.sqrt(self.chi2 / self.freedom)) if self.is_beyond else 1.0

    def is_required(self, change: Change) -> bool:
        """Whether the parameters of a change differ significantly from zero.

        A change without parameters always counts as required.
        """
        if not len(change.scales):
            return True
        indices, estimates = self.fit.columns(change), self.fit.parameters_of(change)
        errors = self.fit.errors[indices] * self.inflation
        in_errors = estimates / errors
        # Parameters that are known in combination only have a nearly singular correlation matrix.
        correlation = (
            self.fit.covariance[indices, indices] * self.inflation**2 / np.outer(errors, errors)
        )
        squares = in_errors @ np.linalg.lstsq(correlation, in_errors, rcond=None)[0]
        return bool(squares > chdtri(len(estimates), SIGNIFICANCE))

    @property
    def shows_tensor(self) -> bool:
        """Whether no standard error of the tensor's entries exceeds the largest entry.

        It is also false if the fit with start and tensor added leaves residuals beyond noise and
        the best fit does not: then the tensor only takes the place of changes that are required.
        """
        if self._is_beyond(self.with_tensor) and not self.is_beyond:
            return False
        entries, errors = self.tensor_entries()
        return bool(errors.max() <= np.abs(entries).max())

    def tensor_entries(self) -> tuple[FloatArray, FloatArray]:
        """Return the entries Ixx, Iyy, Izz, Ixy, Ixz, Iyz, kg m², and their standard errors."""
        fit, entries = self.with_tensor, self.tensor.shown
        indices, count = fit.columns(self.tensor), len(self.tensor.scales)
        usual = np.asarray(entries(np.zeros(count)))
        slopes = np.array([entries(unit) for unit in np.eye(count)]) - usual
        covariance = slopes.T @ fit.covariance[indices, indices] @ slopes
        errors = np.sqrt(np.diag(covariance)) * self.inflation
        return np.asarray(entries(fit.parameters[indices])), errors
