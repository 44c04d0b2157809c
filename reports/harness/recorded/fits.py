"""The likelihood of a recording under equations of motion, and the change that it calls for.

From each of many samples the equations are followed to the next; what is left, in units of what
noise and a method's error make of it, is squared and summed. A change of the equations is preferred
to a simpler one if the sum falls by more than chance makes it fall with so many more numbers, among
so many changes (S. S. Wilks, Ann. Math. Statist. 9 (1938) 60). What an integrator does wrong is the
same all along, and counts as one number, however many samples show it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import chi2

from ....reference.other_equations import EXACT, Integrator, OtherEquations, follow
from ....scenarios import FloatArray
from ....scenarios.rotation import rotation_vectors
from .changes import Change

#: The probability that a change is named where noise alone made the recording another one.
LEVEL = 1e-6
#: A change explains what noise and a method's error do not if no more than this fraction is left.
LEFT = 0.1
#: What is left where numbers are nan: no motion is that far off.
NOWHERE = 1e150
#: Numbers that are seen less than this, relative to those seen best, do not count.
RANK = 1e-6
#: Evaluations of a fit at most, and a step of a scaled number from which a slope is taken.
EVALUATIONS, SMALL = 20, 1e-5
#: Changes are fitted that leave no more than this fraction where they are taken as linear, and of
#: pairs of changes so many that leave least.
PROMISING, PAIRS = 0.5, 12


@dataclass(frozen=True, eq=False)
class Intervals:
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
        """How many of the numbers left count as one: all, where a method's error is larger."""
        of_method = float(np.mean(self.method**2 / (self.noise**2 + self.method**2)))
        return 1 + (6 * len(self.spans) - 1) * of_method

    def spread(self, most: int) -> "Intervals":
        """Return so many of them at most, spread over all."""
        kept = np.unique(np.linspace(0, len(self.spans) - 1, most).astype(int))
        starts, spans, ends = self.starts[kept], self.spans[kept], self.ends[kept]
        return Intervals(starts, spans, ends, self.noise, self.method[kept])

    def off(
        self, equations: OtherEquations, integrator: Integrator = EXACT, timestep: float = 0.0
    ) -> FloatArray:
        """How far the recording is from where equations lead, rad and rad/s, (S, 6)."""
        made = follow(equations, self.starts, self.spans, integrator, timestep)[:, 0]
        off = np.hstack(
            [rotation_vectors(made[:, :4], self.ends[:, :4]), self.ends[:, 4:] - made[:, 4:]]
        )
        return np.nan_to_num(off, nan=NOWHERE, posinf=NOWHERE, neginf=-NOWHERE)


@dataclass(frozen=True, eq=False)
class Fit:
    """Changes at once, with the numbers that explain a recording best.

    Attributes
    ----------
    equations : with the changes
    numbers : of each change
    left : mean square of what is left, in units of its scale
    count : of numbers that the recording shows
    """

    changes: tuple[Change, ...]
    equations: OtherEquations
    numbers: tuple[FloatArray, ...]
    left: float
    count: int

    @property
    def words(self) -> list[str]:
        """The changes with their numbers."""
        return [
            change.words(numbers)
            for change, numbers in zip(self.changes, self.numbers, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class Trial:
    """Changes of equations whose numbers are to be fitted, as one function of scaled numbers."""

    intervals: Intervals
    base: OtherEquations
    changes: tuple[Change, ...]

    @cached_property
    def none(self) -> FloatArray:
        """The numbers that change nothing, of all changes, (k,)."""
        return np.concatenate([np.empty(0), *(change.none for change in self.changes)])

    @cached_property
    def sizes(self) -> FloatArray:
        """(k,)."""
        return np.concatenate([np.empty(0), *(change.sizes for change in self.changes)])

    def numbers(self, x: FloatArray) -> list[FloatArray]:
        """Return the numbers of each change, from scaled ones."""
        numbers, ends = self.none + self.sizes * x, np.cumsum([len(c.none) for c in self.changes])
        return [numbers[end - len(c.none) : end] for c, end in zip(self.changes, ends, strict=True)]

    def equations(self, x: FloatArray) -> OtherEquations:
        """Return the equations with all changes."""
        equations = self.base
        for change, numbers in zip(self.changes, self.numbers(x), strict=True):
            equations = change.apply(equations, numbers)
        return equations

    def left(self, x: FloatArray) -> FloatArray:
        """What is left, in units of its scale, (6 S,)."""
        off = self.intervals.off(self.equations(x)) / self.intervals.scale
        return np.clip(off, -NOWHERE, NOWHERE).ravel()

    @cached_property
    def at_none(self) -> FloatArray:
        """What is left without fitting, (6 S,)."""
        return self.left(np.zeros(len(self.none)))

    @cached_property
    def slopes(self) -> FloatArray:
        """What small numbers change in it, (6 S, k)."""
        steps = SMALL * np.eye(len(self.none))
        columns = [(self.left(step) - self.at_none) / SMALL for step in steps]
        return np.reshape(columns, (len(columns), len(self.at_none))).T

    def fit(self) -> "Fit":
        """The numbers that leave least."""
        x, count, left = np.zeros(len(self.none)), 0, self.at_none
        if len(x):
            found = least_squares(self.left, x, xtol=1e-9, max_nfev=EVALUATIONS)
            seen = np.linalg.svd(np.asarray(found.jac), compute_uv=False)
            x, count = found.x, int(np.count_nonzero(seen > RANK * seen[0]))
            left = found.fun
        numbers = tuple(self.numbers(x))
        return Fit(self.changes, self.equations(x), numbers, float(np.mean(left**2)), count)


def is_possible(equations: OtherEquations) -> bool:
    """Whether a motion may have been computed with such a tensor: no body need have it."""
    return bool(np.linalg.eigvalsh(equations.inertia)[0] > 0)


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the change that a recording calls for.

    Attributes
    ----------
    base : the scene's equations
    changes : that are looked for
    """

    intervals: Intervals
    base: OtherEquations
    changes: Sequence[Change]

    @cached_property
    def unchanged(self) -> Fit:
        """What the scene's own equations leave."""
        return Trial(self.intervals, self.base, ()).fit()

    @property
    def is_called_for(self) -> bool:
        """Whether what they leave is more than noise and a method's error."""
        return self._falls(self.unchanged.left, 0.0) > self._by_chance(1)

    def found(self) -> Fit | None:
        """The change, or the two at once, that explain the recording; None if none do."""
        if not self.is_called_for:
            return None
        trials = [Trial(self.intervals, self.base, (change,)) for change in self.changes]
        enough = PROMISING**2 * self.unchanged.left
        single = [trial.fit() for trial in trials if _left_if_linear(trial) <= enough]
        best = self._chosen(single)
        if best is not None and best.left <= 1:
            return best
        return self._chosen([*single, *self._pairs(trials)])

    def _pairs(self, trials: Sequence[Trial]) -> list[Fit]:
        """Two changes at once, of which those are fitted that promise to leave least."""
        unchanged = np.ravel(self.intervals.off(self.base) / self.intervals.scale)
        pairs = list(combinations(trials, 2))
        left = [
            _left(one.at_none + other.at_none - unchanged, np.hstack([one.slopes, other.slopes]))
            for one, other in pairs
        ]
        # Of those that promise to explain it, the simplest.
        enough = LEFT**2 * self.unchanged.left
        counts = [len(one.none) + len(other.none) for one, other in pairs]
        order = sorted(
            range(len(pairs)),
            key=lambda k: (left[k] > enough, counts[k] * (left[k] <= enough), left[k]),
        )
        best = [pairs[k] for k in order[:PAIRS]]
        return [
            Trial(self.intervals, self.base, one.changes + other.changes).fit()
            for one, other in best
        ]

    def _chosen(self, fits: Sequence[Fit]) -> Fit | None:
        """The simplest fit that none with more numbers beats by more than chance."""
        left = self.unchanged.left
        explaining = [
            fit
            for fit in fits
            if fit.left <= max(1.0, LEFT**2 * left)
            and self._falls(left, fit.left) > self._by_chance(fit.count)
            and is_possible(fit.equations)
        ]
        best = None
        # Of those alike the first is named.
        for fit in sorted(explaining, key=lambda fit: fit.count):
            more = fit.count - best.count if best else 1
            if best is None or self._falls(best.left, fit.left) > self._by_chance(more):
                best = fit
        return best

    def _falls(self, before: float, after: float) -> float:
        numbers = self.intervals.scale.size
        return (before - after) * numbers / self.intervals.at_once

    def _by_chance(self, numbers: int) -> float:
        return float(chi2.isf(LEVEL / len(self.changes), max(1, numbers)))


def _left_if_linear(trial: Trial) -> float:
    return _left(trial.at_none, trial.slopes)


def _left(at_none: FloatArray, slopes: FloatArray) -> float:
    """The mean square of what the best numbers leave, if it is linear in them."""
    if slopes.shape[1]:
        best = np.linalg.lstsq(slopes, at_none, rcond=RANK)[0]
        at_none = at_none - slopes @ best
    return float(np.mean(at_none**2))
