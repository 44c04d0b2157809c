"""A measured motion: its noise, and the start, tensor and mistakes of a gyroscope that fit it best.

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

from ....reference.following import follow
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import norms
from ...results.change_words import KINDS
from ..explaining.changes import FITTED_TENSORS, is_scaled, tensor
from ..explaining.effect_changes import (
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
from ..explaining.fit import Fit, Trial, race
from ..explaining.hypothesis import Change, Hypothesis
from ..explaining.search import LEFT, LEVEL, Search
from .clamps import TINY
from .columns import EACH, SATURATES
from .digits import where
from .intervals import apart
from .log import Log
from .missing import KINEMATICS
from .motion_changes import TIMES, changes_of_motion
from .sensors import CROSS_AXIS, OF_LOGS, READINGS, of_sensor
from .starts import started_elsewhere

#: Part of the distance of samples by which a state is followed to see where it leads.
SMALL = 1e-3
#: Largest number of changes that are fitted at once, and of numbers of a special change.
MOST, MOST_NUMBERS = 4, 3
#: Largest turn of the body, rad, in the time by which all states are late.
LATEST = 30.0
#: How much more than the best the first samples may leave, as a sum of squares, for a change to be
#: fitted to more of them: by chance it is more of one in 10⁹.
KEEPS_UP = 50.0
#: Factor by which neighbouring fourth differences, which share noise, count as fewer independent
#: numbers, Σ (8 over 4+k)² / (8 over 4)².
SHARED = 2.63

#: Standard deviations of noise that the rates differ by, at most, which a gyroscope saturates at.
SATURATED = 2.0
#: That attitudes, or ω, alone are the scene's.
ATTITUDE_ALONE = "the attitudes are those of the scene, but the recorded ω is not"
OMEGA_ALONE = "ω is that of the scene, but the attitudes are not"

START = Change("start", lambda h, n: h._replace(start=h.start + n), np.ones(6))


@dataclass(frozen=True, eq=False)
class Measured:
    """A measured motion, and what fits it best.

    Attributes
    ----------
    given : its samples, with noise as it is stated or was estimated before any fit
    """

    scenario: Scenario
    given: Log

    @cached_property
    def tensor(self) -> Change:
        """The change of the scene's tensor that is fitted."""
        return tensor(self.given.base.equations)

    @cached_property
    def by_attitude(self) -> Change:
        """The change in which torques act that depend on the attitude."""
        return by_attitude(usual_torque(self.scenario, self.given.base.equations))

    @cached_property
    def axes(self) -> Change:
        """The change in which attitude and ω are those of axes that are turned in the body."""
        omega = self.given.scene_start[4:]

        def turned(h: Hypothesis, turn: FloatArray) -> Hypothesis:
            R, e = Rotation.from_rotvec(turn).as_matrix(), h.equations
            of_body = {name: R.T @ getattr(e, name) for name in ("pull", "torque", "kept")}
            start = np.concatenate([turn, R.T @ omega - omega])
            return h.of_tensor(R.T @ e.inertia @ R).of(**of_body)._replace(start=start)

        return Change("axes of the body", turned, np.ones(3))

    @cached_property
    def late(self) -> Change:
        """The change in which each state is that of a time, so many seconds before its own."""
        start = self.given.scene_start[None]
        rate = max(float(norms(start[:, 4:])[0]), self.given.base.equations.rate) or 1.0
        most = LATEST / rate

        def shifted(h: Hypothesis, time: FloatArray) -> Hypothesis:
            before = follow(h.equations, start, -np.clip(time, -most, most)[None])[:, 0]
            return h._replace(start=apart(start, before)[0])

        return Change("late", shifted, np.array([1 / rate]))

    @cached_property
    def search(self) -> Search:
        """The search for changes that the samples require, given the noise before any fit."""
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
        # It has numbers enough to explain a part of anything.
        torque = Trial(self.given, (self.by_attitude,)).fit()
        single += [] if self._is_beyond(torque) else [torque]
        found = max(single, key=search.gain)
        if not found.is_hopeless:
            found = search.stepwise(found.changes, MOST)
        if self._is_beyond(found):
            # Of changes that are needed together each may explain nothing by itself.
            found = max(found, search.stepwise(both, MOST), key=search.gain)
        if self._is_beyond(found) and not self.right_by_itself:
            # What is wrong besides leaves far more than noise at first.
            first = max(self._raced([(), (START,)], 1 / LEFT), key=search.gain, default=found)
            every = replace(search, changes=[*search.changes, CROSS_AXIS])
            other = every.stepwise(first.changes, len(first.changes) + 1)
            found = found if self._is_beyond(other) else other
        narrower = (one for one in self._narrower(found) if search.beyond(one, found) <= 0)
        found = max(narrower, key=search.gain, default=found)
        return self._special(found) or found

    def _special(self, found: Fit) -> Fit | None:
        """Return a fit with a special change of the equations in place of general ones.

        Tensors and torques that are fitted explain, in part, what is wrong otherwise, too. None is
        returned if no such fit explains as much, or more is left than noise.
        """
        general = [one for one in found.changes if one is not START and one not in OF_LOGS]
        if not general or self._is_beyond(found):
            return None
        # Of more than two they are no more than what fits.
        fewer = [*combinations(general, 2), *((one,) for one in general)]
        for replaced in fewer if len(general) <= 2 else [general]:
            kept = tuple(one for one in found.changes if one not in replaced)
            fits = [one for one in self._raced([kept]) if self.search.beyond(one, found) <= 0]
            fits = [one for one in fits if len(one.numbers) < len(found.numbers)]
            if fits:
                return min(fits, key=lambda fit: len(fit.numbers))
        return None

    def _raced(self, besides: Sequence[tuple[Change, ...]], factor: float = 1.0) -> list[Fit]:
        """Return the best fits of each change of the equations, beside some other changes."""
        # That a tensor has special axes is not said where noise hides that it has others.
        others = [one for one in changes_of_motion(self.scenario) if one not in READINGS]
        others = [one for one in others if one.kind not in FITTED_TENSORS]
        special = [one for one in others if len(one.sizes) <= MOST_NUMBERS]
        trials = [Trial(self.given, (one, *more)) for more in besides for one in special]
        return [fit for fit in race(trials, KEEPS_UP, factor) if fit.is_possible]

    def _narrower(self, found: Fit) -> Iterator[Fit]:
        """Yield fits in which changes with many numbers are special ones with fewer."""
        both = START, self.tensor
        if START in found.changes:
            others = [one for one in found.changes if one is not START]
            yield Trial(self.given, (*others, self.late)).fit(found)
        if set(both) <= set(found.changes):
            others = [one for one in found.changes if one not in both]
            # Along other axes the same body starts elsewhere, and has another tensor.
            yield Trial(self.given, (self.axes, *others)).fit()
        if self.by_attitude in found.changes:
            of_dipole = dipole(found.numbers_of(self.by_attitude).reshape(3, 3))
            others = [one for one in found.changes if one is not self.by_attitude]
            yield Trial(self.given, (of_dipole, *others)).fit(found)

    def alternatives(self, change: Change) -> list[tuple[float, Change, Fit]]:
        """Return the mistakes of a gyroscope that explain about as much as the named one.

        Each comes with its likelihood relative to the named one and its fit, the likeliest first.
        If ω hardly changes, a bias and a scale are alike. Mistakes less likely than `LEVEL` are
        left out.
        """
        fits = []
        for other in OF_LOGS:
            # With more numbers it explains as much by itself.
            if other not in self.found.changes and len(other.sizes) <= len(change.sizes):
                changes = (other if one is change else one for one in self.found.changes)
                fit = Trial(self.given, tuple(changes)).fit(self.found)
                gain = self.search.gain(fit) - self.search.gain(self.found)
                fits.append((float(np.exp(min(gain, 0.0) / 2)), other, fit))
        return sorted((one for one in fits if one[0] > LEVEL), key=lambda one: -one[0])

    @cached_property
    def log(self) -> Log:
        """The samples with noise as stated, or else as the best fit leaves it."""
        is_noise = self.given.is_stated or self.is_beyond
        return self.given if is_noise else self.given.with_noise_of(self.found)

    @cached_property
    def fit(self) -> Fit:
        """The best fit, given that noise."""
        return Trial(self.log, self.found.changes).fit(self.found)

    @cached_property
    def with_tensor(self) -> Fit:
        """The best fit, with start and tensor added even if the samples do not require them."""
        more = [one for one in (START, self.tensor) if one not in self.found.changes]
        trial = Trial(self.log, (*self.found.changes, *more))
        fit = trial.fit(self.found)
        # A tensor that takes the place of what was found begins anew.
        return trial.fit() if self._is_beyond(fit) else fit

    @cached_property
    def freedom(self) -> int:
        """Number of measured numbers less the number of fitted ones."""
        return self.found.rest.size - len(self.found.numbers)

    @cached_property
    def is_beyond(self) -> bool:
        """Whether more is left than noise explains."""
        return self._is_beyond(self.found)

    def _is_beyond(self, fit: Fit) -> bool:
        """Whether a fit leaves more than noise explains."""
        squares, freedom = self.given.squares(fit.rest), fit.rest.size - len(fit.numbers)
        if self.given.is_stated:
            return float(chdtrc(freedom, squares.sum())) < LEVEL
        each = freedom / len(squares)
        ratios = squares / each
        return float(fdtrc(each, 3 * len(self.given.t) / SHARED, ratios.max())) < LEVEL

    @property
    def is_far(self) -> bool:
        """Whether so much more than noise is left that its standard errors say nothing."""
        return self.is_beyond and self.chi2 > self.freedom / LEFT

    @property
    def verdict(self) -> str:
        """A sentence on whether what is left is noise."""
        of, in_omega = np.degrees(self.log.noise[0]), self.log.noise[1]
        noise = f"a noise of {of:.3g}° in attitude"
        noise += f" and {in_omega:.3g} rad/s in ω" if self.log.has_omega else ""
        known = "stated" if self.log.is_stated else "estimated"
        ends = "beyond" if self.is_beyond else "within"
        return (
            f"{ends} {noise}, which is {known}: χ² is {self.chi2:.0f}, of {self.freedom} degrees "
            "of freedom"
        )

    @property
    def chi2(self) -> float:
        """The sum of squares of what is left, in units of the noise."""
        return float(np.sum(self.fit.rest**2))

    def tensor_in_words(self) -> str:
        """Return a sentence with the tensor that fits best, and standard errors."""
        if self.is_far:
            return "No tensor is given: what is left is far beyond noise."
        if not self.shows_tensor:
            return "No tensor is given: the motion does not show it beside what explains it."
        free = "" if is_scaled(self.log.base.equations) else ", up to a factor"
        entries = _plus_minus(*self.tensor_entries())
        return f"The tensor Ixx, Iyy, Izz, Ixy, Ixz, Iyz that fits best is {entries} kg m²{free}."

    @property
    def shows_tensor(self) -> bool:
        """Whether any entry of the tensor is known, beside what the samples require.

        A tensor that is fitted may take the place of what explains the samples.
        """
        if self._is_beyond(self.with_tensor) and not self.is_beyond:
            return False
        entries, errors = self.tensor_entries()
        return bool(errors.max() <= np.abs(entries).max())

    def as_record(self) -> dict[str, object]:
        """Return noise, χ² and tensor for JSON, without a tensor where none is given in words."""
        is_given = not self.is_far and self.shows_tensor
        of_tensor = [one.tolist() for one in self.tensor_entries()] if is_given else [None, None]
        attitude, omega = map(float, self.log.noise)
        return {
            "noise": {"attitude": attitude, "omega": omega},
            "noise_is_stated": self.log.is_stated,
            "chi2": self.chi2,
            "degrees_of_freedom": self.freedom,
            "tensor": of_tensor[0],
            "tensor_standard_error": of_tensor[1],
        }

    def explained(self, but: Change | None = None) -> list[str]:
        """Return in words what the samples require, one change left out.

        If that leaves far more than noise: whether attitudes, or ω, are those of the scene.
        """
        if self.is_far:
            return self.right_by_itself
        if not self.given.is_stated and self.uneven_times:
            return self.uneven_times
        required = [one for one in self.fit.changes if one is not but and self._is_required(one)]
        return [self._in_words(change) for change in required]

    @cached_property
    def uneven_times(self) -> list[str]:
        """The sentence that each state is the scene's at another time, within noise; none if not.

        By how much each is late is fitted, as if the motion were straight for so long. Noise that
        is not stated is no noise if nearly all of it is along the motion.
        """
        log, unchanged = self.given, self.search.unchanged.rest
        (made,) = log.made([log.base], log.t)
        small = SMALL * float(np.median(np.diff(log.t)))
        later = follow(log.base.equations, made, np.full((len(made), 1), small))[:, 0]
        slopes = (apart(made, later) / np.repeat(log.noise, 3))[:, : log.measured] / small
        rest = unchanged.reshape(len(made), -1)
        late = np.sum(slopes * rest, axis=1) / np.maximum(np.sum(slopes**2, axis=1), TINY)
        left = rest - late[:, None] * slopes
        before, after = float(np.sum(rest**2)), float(np.sum(left**2))
        # Where all are late alike, it is no matter of each time.
        is_even = abs(float(np.mean(late))) > float(np.std(late))
        is_noise = is_even or bool(chdtrc(rest.size, before) > LEVEL)
        is_along = bool(chdtrc(rest.size - len(late), after) > LEVEL)
        if not log.is_stated:
            is_noise, is_along = is_even, after < LEFT**2 * before
        if is_noise or not is_along:
            return []
        return [
            f"the times are off by {float(np.std(late)):.2g} s, standard deviation, and by "
            f"{float(np.abs(late).max()):.2g} s at most: each state is the scene's of such a time"
        ]

    @cached_property
    def right_by_itself(self) -> list[str]:
        """The sentence that either attitude or ω is the scene's, within noise; none if not so.

        Or that each state is, at another time.
        If less than half of the samples of the other are off, it says which.
        """
        log, unchanged = self.given, self.search.unchanged.rest
        if not log.has_omega or self.uneven_times:
            return self.uneven_times
        squares = log.squares(unchanged)
        is_right = chdtrc(3 * len(log.t), squares) > LEVEL
        if is_right.all() or not is_right.any():
            return []
        words, wrong = (ATTITUDE_ALONE, 1) if is_right[0] else (OMEGA_ALONE, 0)
        each = norms(unchanged.reshape(-1, 3)).reshape(-1, 2)[:, wrong]
        samples = np.flatnonzero(each**2 > chdtri(3, LEVEL / len(each)))
        if bound := self._saturates_at if is_right[0] else 0.0:
            words += f": {SATURATES.format(EACH, bound, np.degrees(bound))}"
        if 0 < 2 * len(samples) < len(each):
            off = float(log.noise[wrong] * each.max())
            size = f"{off:.3g} rad/s" if wrong else f"{np.degrees(off):.3g}°"
            words += f" {where(log.t, samples)}, by up to {size}"
        return [words]

    @property
    def _saturates_at(self) -> float:
        """The rate, rad/s, that is recorded where the exact ω is faster than that; 0 if none is."""
        omega, noise = self.given.states[:, 4:], self.given.noise[1]
        rest = self.search.unchanged.rest.reshape(-1, 2, 3)[:, 1]
        is_off = rest**2 > chdtri(1, LEVEL / rest.size)
        speeds, is_slower = np.abs(omega[is_off]), rest[is_off] * omega[is_off] < 0
        is_cut = len(speeds) > 1 and is_slower.all() and np.std(speeds) < SATURATED * noise
        return float(np.mean(speeds)) if is_cut else 0.0

    @property
    def inflation(self) -> float:
        """Factor of standard errors by what is left beyond noise, √(χ² / degrees of freedom).

        So do the Particle Data Group where measurements differ by more than their errors (R. L.
        Workman et al., Prog. Theor. Exp. Phys. 2022, 083C01, §5.2.2).
        """
        return float(np.sqrt(self.chi2 / self.freedom)) if self.is_beyond else 1.0

    def _is_required(self, change: Change) -> bool:
        """Whether a change is significant beside what is left."""
        if not len(change.sizes):
            return True
        rows, numbers = self.fit.rows(change), self.fit.numbers_of(change)
        errors = self.fit.errors[rows] * self.inflation
        in_errors = numbers / errors
        # Numbers that are known together only have a correlation that is nearly singular.
        correlation = self.fit.covariance[rows, rows] * self.inflation**2 / np.outer(errors, errors)
        squares = in_errors @ np.linalg.lstsq(correlation, in_errors, rcond=None)[0]
        return bool(squares > chdtri(len(numbers), LEVEL))

    def _in_words(self, change: Change) -> str:
        rows = self.fit.rows(change)
        numbers, errors = self.fit.numbers[rows], self.fit.errors[rows] * self.inflation
        if change in (*OF_LOGS, CROSS_AXIS):
            others = (
                f", or {self._of_sensor(other, fit)} ({likely:.2g} times as likely)"
                for likely, other, fit in self.alternatives(change)
            )
            return self._of_sensor(change, self.fit) + "".join(others)
        if change is START:
            return started_elsewhere(self.log.t[0], norms(numbers.reshape(2, 3)))
        if change is self.late:
            when = "before" if numbers[0] > 0 else "after"
            late = _plus_minus(np.abs(numbers), errors)
            return f"each state is that of {late} s {when} its time"
        if change.kind == "tilt":
            return f"{self.fit.explanation(change).words} (± {np.degrees(errors.max()):.2g}°)"
        if change is self.axes:
            turn = _plus_minus(np.degrees(numbers), np.degrees(errors))
            return f"attitude and ω are those of axes that are turned by {turn}° in the body"
        if change.kind == self.by_attitude.kind:
            # Angles of a dipole's field have another size.
            of_torque = errors[change.sizes == change.sizes[0]]
            listed = f"{norms(of_torque[None])[0]:.2g} N m"
        else:
            listed = ", ".join(f"{error:.2g}" for error in errors)
        listed = f" (± {listed})" if listed else ""
        before = "" if KINDS[change.kind].is_kinematic else "it moves as if "
        if change not in self.search.changes and not before:
            before = f"{KINEMATICS}: "
        return f"{before}{self.fit.explanation(change).words}{listed}"

    def tensor_entries(self) -> tuple[FloatArray, FloatArray]:
        """Return the entries Ixx, Iyy, Izz, Ixy, Ixz, Iyz, kg m², and their standard errors."""
        fit, entries = self.with_tensor, self.tensor.shown
        rows, count = fit.rows(self.tensor), len(self.tensor.sizes)
        usual = np.asarray(entries(np.zeros(count)))
        slopes = np.array([entries(unit) for unit in np.eye(count)]) - usual
        covariance = slopes.T @ fit.covariance[rows, rows] @ slopes
        errors = np.sqrt(np.diag(covariance)) * self.inflation
        return np.asarray(entries(fit.numbers[rows])), errors

    def _of_sensor(self, change: Change, fit: Fit) -> str:
        """Return a mistake of a gyroscope in words, with its numbers in a fit."""
        rows = fit.rows(change)
        numbers, errors = fit.numbers[rows], fit.errors[rows] * self.inflation
        return of_sensor(change, numbers, lambda n, unit: _plus_minus(n, unit * errors))


def _plus_minus(numbers: FloatArray, errors: FloatArray) -> str:
    """Return numbers with their standard errors, as text."""
    each = [f"{n:.5g} ± {e:.2g}" for n, e in zip(numbers, errors, strict=True)]
    return each[0] if len(each) == 1 else f"[{', '.join(each)}]"
