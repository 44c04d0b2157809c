"""The fit of a measured motion: the start, tensor and mistakes that its samples require.

The exact motion is fitted to all samples at once by maximum likelihood, with normal and independent
noise.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import chdtrc, chdtri, fdtrc

from .....reference.following import follow
from .....scenarios import FloatArray, Scenario
from .....scenarios.rotation import norms
from ...explaining.changes import FITTED_TENSORS, tensor
from ...explaining.effect_changes import (
    by_attitude,
    com,
    dipole,
    momentum,
    of_momentum,
    resistance,
    resistance_of_other_powers,
    tilt,
    torques,
    usual_torque,
    world_turning,
)
from ...explaining.fit import Fit, Trial, race
from ...explaining.hypothesis import Change, Hypothesis
from ...explaining.search import LEFT, SIGNIFICANCE, Search
from ..samples.intervals import apart
from ..samples.sensors import CROSS_AXIS, OF_LOGS, READINGS
from .log import Log
from .motion_changes import TIMES, changes_of_motion
from .right_by_itself import right_by_itself, uneven_times

#: Most changes that are fitted at once, and most parameters of a special change.
MOST_CHANGES, MOST_PARAMETERS = 4, 3
#: Largest turn of the body, rad, in the time by which all states are late.
LATEST = 30.0
#: By how much χ² of the first samples may exceed that of the best change, for a change to be fitted
#: to more of them: by chance it exceeds it by more for one change in 10⁹.
MARGIN = 50.0
#: Factor by which the degrees of freedom of neighbouring fourth differences, which share noise, are
#: fewer than the differences: Σ (8 over 4+k)² / (8 over 4)².
SHARED = 2.63

START = Change("start", lambda h, n: h._replace(start=h.start + n), np.ones(6))


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
        """The change that fits the tensor of inertia, with deviations from the scene's."""
        return tensor(self.given.base.equations)

    @cached_property
    def by_attitude(self) -> Change:
        """The change that adds torques that depend on the attitude."""
        return by_attitude(usual_torque(self.scenario, self.given.base.equations))

    @cached_property
    def axes(self) -> Change:
        """The change that turns the axes, in the body, that attitude and ω are stated in."""
        omega = self.given.scene_start[4:]

        def turn_axes(h: Hypothesis, turn: FloatArray) -> Hypothesis:
            R, e = Rotation.from_rotvec(turn).as_matrix(), h.equations
            of_body = {name: R.T @ getattr(e, name) for name in ("pull", "torque", "kept")}
            start = np.concatenate([turn, R.T @ omega - omega])
            return h.of_tensor(R.T @ e.inertia @ R).of(**of_body)._replace(start=start)

        return Change("axes of the body", turn_axes, np.ones(3))

    @cached_property
    def late(self) -> Change:
        """The change that takes each state at a time some seconds before its own."""
        start = self.given.scene_start[None]
        rate = max(float(norms(start[:, 4:])[0]), self.given.base.equations.rate) or 1.0
        most = LATEST / rate

        def shift_time(h: Hypothesis, time: FloatArray) -> Hypothesis:
            before = follow(h.equations, start, -np.clip(time, -most, most)[None])[:, 0]
            return h._replace(start=apart(start, before)[0])

        return Change("late", shift_time, np.array([1 / rate]))

    @cached_property
    def search(self) -> Search:
        """The search for changes that the samples require, with the noise before any fit."""
        equations = self.given.base.equations
        scene = self.scenario, equations
        candidates = [START, self.tensor, TIMES, *resistance(*scene), *com(*scene)]
        candidates += [*tilt(equations), *of_momentum(equations), *torques(*scene)]
        candidates += [momentum(*scene), *resistance_of_other_powers(*scene)]
        if self.given.has_omega:
            candidates += [*OF_LOGS, world_turning(1.0)]
        return Search(self.given, candidates)

    @cached_property
    def found(self) -> Fit:
        """The best fit, with all the changes that the samples require."""
        search, both = self.search, (START, self.tensor)
        single = [one.fit() for one in search.trials]
        # It has so many parameters that it explains a part of any motion.
        torque = Trial(self.given, (self.by_attitude,)).fit()
        single += [] if self._is_beyond(torque) else [torque]
        found = max(single, key=search.score)
        if not found.explains_nothing:
            found = search.stepwise(found.changes, MOST_CHANGES)
        if self._is_beyond(found):
            # Changes that are needed together may each explain nothing alone.
            found = max(found, search.stepwise(both, MOST_CHANGES), key=search.score)
        if self._is_beyond(found) and not self.right_by_itself:
            # Beside a second mistake, a single change has residuals far beyond noise.
            first = max(self._raced([(), (START,)], 1 / LEFT), key=search.score, default=found)
            every = replace(search, changes=[*search.changes, CROSS_AXIS])
            other = every.stepwise(first.changes, len(first.changes) + 1)
            found = found if self._is_beyond(other) else other
        narrower = (one for one in self._narrower(found) if search.improvement(one, found) <= 0)
        found = max(narrower, key=search.score, default=found)
        return self._special(found) or found

    def _special(self, found: Fit) -> Fit | None:
        """Return a fit with a special change of the equations in place of general ones; or None.

        Tensors and torques that are fitted explain, in part, other mistakes, too. None is returned
        if no such fit explains as much, or if the residuals exceed noise.
        """
        general = [one for one in found.changes if one is not START and one not in OF_LOGS]
        if not general or self._is_beyond(found):
            return None
        # More than two general changes merely match the data: they are replaced all at once.
        fewer = [*combinations(general, 2), *((one,) for one in general)]
        for replaced in fewer if len(general) <= 2 else [general]:
            kept = tuple(one for one in found.changes if one not in replaced)
            fits = [one for one in self._raced([kept]) if self.search.improvement(one, found) <= 0]
            fits = [one for one in fits if len(one.parameters) < len(found.parameters)]
            if fits:
                return min(fits, key=lambda fit: len(fit.parameters))
        return None

    def _raced(self, besides: Sequence[tuple[Change, ...]], factor: float = 1.0) -> list[Fit]:
        """Return the best fits of each change of the equations, beside some other changes.

        Parameters
        ----------
        besides : the sets of other changes that each is tried with
        factor : as in `race`
        """
        # Noise may hide that a tensor has other axes than the special ones: these are not tried.
        others = [one for one in changes_of_motion(self.scenario) if one not in READINGS]
        others = [one for one in others if one.kind not in FITTED_TENSORS]
        special = [one for one in others if len(one.scales) <= MOST_PARAMETERS]
        trials = [Trial(self.given, (one, *more)) for more in besides for one in special]
        return [fit for fit in race(trials, MARGIN, factor) if fit.is_physical]

    def _narrower(self, found: Fit) -> Iterator[Fit]:
        """Yield fits in which special changes with fewer parameters replace general ones."""
        both = START, self.tensor
        if START in found.changes:
            others = [one for one in found.changes if one is not START]
            yield Trial(self.given, (*others, self.late)).fit(found)
        if set(both) <= set(found.changes):
            others = [one for one in found.changes if one not in both]
            # The same body has another start and another tensor along other axes.
            yield Trial(self.given, (self.axes, *others)).fit()
        if self.by_attitude in found.changes:
            of_dipole = dipole(found.parameters_of(self.by_attitude).reshape(3, 3))
            others = [one for one in found.changes if one is not self.by_attitude]
            yield Trial(self.given, (of_dipole, *others)).fit(found)

    def alternatives(self, change: Change) -> list[tuple[float, Change, Fit]]:
        """Return the mistakes of a gyroscope that explain about as much as a given one.

        If ω hardly changes, a bias and a scale are alike. Mistakes less likely than `SIGNIFICANCE`
        are left out.

        Parameters
        ----------
        change : one of the changes of `found`

        Returns
        -------
        The likelihood relative to that with the given change, the change, and the fit; the
        likeliest first
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
        """The sentence that each state is the scene's at another time, within noise; often none."""
        return uneven_times(self.given, self.search.unchanged.residuals)

    @cached_property
    def right_by_itself(self) -> list[str]:
        """The sentence that attitude, ω, or each state at another time, is the scene's, if so."""
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
        """The degrees of freedom: the number of residuals less that of parameters."""
        return self.found.residuals.size - len(self.found.parameters)

    @cached_property
    def is_beyond(self) -> bool:
        """Whether the residuals of the best fit exceed noise."""
        return self._is_beyond(self.found)

    def _is_beyond(self, fit: Fit) -> bool:
        """Whether the residuals of a fit exceed noise.

        If the noise is not stated, they are compared with it by an F test, as it was estimated
        itself.
        """
        squares, freedom = (
            self.given.squares(fit.residuals),
            fit.residuals.size - len(fit.parameters),
        )
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
        """The factor of standard errors by residuals beyond noise, √(χ² / degrees of freedom).

        It is 1 if the residuals do not exceed noise. The Particle Data Group scale errors so where
        measurements differ by more than their errors (R. L. Workman et al., Prog. Theor. Exp. Phys.
        2022, 083C01, §5.2.2).
        """
        return float(np.sqrt(self.chi2 / self.freedom)) if self.is_beyond else 1.0

    def is_required(self, change: Change) -> bool:
        """Whether the parameters of a change differ significantly from zero.

        A change without parameters is required.
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
        """Whether any entry of the tensor is known, beside the changes that the samples require.

        A tensor that is fitted may take the place of those changes.
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
