"""Other physics that explain a recorded motion: a clamp, an integrator, changes of the equations.

A hypothesis is tested in each interval between two samples. Its equations are followed from the
recorded state at the start of the interval, and lead to a state that is compared with the recorded
one at the end. Errors from before the interval do not count.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .....reference.following import EXACT
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import norms
from ...explaining.fit import Fit, mean_square
from ...explaining.hypothesis import Change, Hypothesis
from ...explaining.search import LEFT, MOST_OF_ALL, SAME, Search
from ..samples.clamps import Clamp, clamps
from ..samples.intervals import FEWEST_INTERVALS, Intervals, intervals_of, root_mean_squares
from ..samples.missing import dissipated, missing
from ..samples.mistakes import FITS
from ..samples.sensors import READINGS
from .known_integrators import FEW, KnownIntegrators
from .leading_error import left_by_methods
from .motion_changes import TIMES, changes_of_motion, is_of_turning, sentences
from .varying import varying
from .within_error import refitted, within_error

#: The most intervals to which changes are fitted. The most steps that a known integrator takes, in
#: all intervals together, where changes are fitted to its motion.
MOST_INTERVALS, MOST_STEPS = 60, 300
#: The term of a method's error after the leading one, relative to that, is assumed to be
#: `NEXT_TERM` times the fastest rate times the timestep, but at most `LARGEST_NEXT`.
NEXT_TERM, LARGEST_NEXT = 4.0, 0.3
#: A pair of changes that explains the motion exactly is looked for only if ω differs from the exact
#: flow at the ends of intervals by more than this, as a root mean square, relative to the largest
#: ‖ω‖.
LEAST_FOR_TWO = 1e-4
#: A clamp of ω is certain if the scene's equations lead beyond its bound by at least this many
#: standard deviations of noise.
CERTAIN = 6.0
#: The most parameters of a fit whose residuals exceed a method's error.
MOST_PARAMETERS = 3
#: The sentence that a method's order of accuracy is lower than the stated one.
LOWER_ORDER = (
    "its method is of order {}, not {}: {} equations and errors of that order make this "
    "motion; look for a wrong stage or weight, or a rate that is taken at another time"
)
OTHER_TIMESTEP = "its timestep is not the stated {:.4g} s"
LONGER_TIMESTEP = (
    "its timestep is longer than the stated {:.4g} s: the scene's equations and errors of order {} "
    "make this motion, with a timestep of {:.2g} s or more"
)
UNEXPLAINED = (
    "this is most of it: what is left, {:.2g} % of the difference, is beyond the method, and not "
    "explained"
)


@dataclass(frozen=True, eq=False)
class Physics:
    """The search for other physics that led to a recorded motion.

    Other physics are changes (`Change`) of the equations or of how states are read, known
    integrators, and clamps of ω.

    Attributes
    ----------
    scenario : the scene whose equations the motion should obey
    motion, exact : the recorded motion, and the exact one at the same times
    timestep : timestep with which the motion was computed, s; if None, it is unknown, and the time
        between samples is used
    order : order of accuracy of the method that computed the motion
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    reach : the number of samples at either end that are left out because their ω, computed from
        attitudes, has larger errors; 0 if ω was recorded
    base : the equations in which changes are made; the scene's if None
    """

    scenario: Scenario
    motion: Trajectory
    exact: Trajectory
    timestep: float | None
    order: int
    noise: FloatArray
    reach: int = 0
    base: Hypothesis | None = None

    @cached_property
    def intervals(self) -> Intervals | None:
        """The intervals between samples, at most `MOST_INTERVALS`.

        Intervals in which the body turns too far are left out. The property is None if too few
        remain, or if ω is 0 at all samples.
        """
        of_method = self.timestep, self.order, self.noise
        inner = self.motion.at(np.arange(self.reach, len(self.motion.t) - self.reach))
        data = intervals_of(self.scenario, inner, *of_method, most=MOST_INTERVALS)
        if data is None:
            return None
        base = data.base if self.base is None else self.base
        return replace(data, base=base, is_derived=self.reach > 0)

    @cached_property
    def search(self) -> Search | None:
        """The search for changes of equations, or of how states are read, that explain the motion.

        Each change is tested in the intervals between samples. The property is None if `intervals`
        is.
        """
        data = self.intervals
        every = changes_of_motion(self.scenario)
        return None if data is None else Search(data, every, most=MOST_PARAMETERS)

    @property
    def is_beyond(self) -> bool:
        """Whether noise and a method's error are too small to explain the motion with `base`.

        In each interval the recorded state at the end is compared with that to which the exact flow
        of `base` leads from the recorded start. The error is that of a method with the stated order
        and timestep. Differences up to `least` may be rounding in many steps. If `intervals` is
        None, the property is False.
        """
        if self.search is None or self.is_of_noise:
            return False
        return self.search.exceed_noise(self.search.unchanged.residuals)

    @cached_property
    def made_by(self) -> str:
        """The known integrator that computed the motion with the equations of `base`, in words.

        Other timesteps than the stated one are tried, too. The text is empty if no known integrator
        computed the motion, or if `intervals` is None.
        """
        if self.known is None:
            return ""
        base = self.known.intervals.base
        return self.known.that_made(base) or self.known.at_another_timestep(base)

    @property
    def is_at_another_timestep(self) -> bool:
        """Whether a known integrator computed the motion with another timestep than is stated."""
        if self.timestep is None or self.known is None:
            return False
        return bool(self.made_by) and not self.known.that_made(self.known.intervals.base)

    @property
    def next_term(self) -> float:
        """The assumed size of the second term of a method's error, relative to its leading term."""
        if self.intervals is None:
            return LARGEST_NEXT
        data = self.intervals
        fastest = max(float(norms(data.starts[:, 4:]).max()), float(data.base.rate))
        timestep = self.timestep or float(np.median(data.spans))
        return min(LARGEST_NEXT, NEXT_TERM * fastest * timestep)

    @cached_property
    def apparent_order(self) -> int:
        """The order of accuracy that the errors show, if they are not those of the stated method.

        Methods of lower orders are tried, and of the stated order with a longer timestep. The
        leading error of such a method must explain the differences from the exact flow, but for the
        next term of its error. If errors of the stated method explain them as well, they must leave
        far larger residuals. A change of the equations must not leave far smaller ones. The order
        is 0 if no such method is found, if the differences are no more than noise, if a known
        integrator computed the motion, or if no timestep is stated.
        """
        if self.timestep is None or self.intervals is None or self.made_by:
            return 0
        if not self.is_beyond and (self.off <= self.least).all():
            return 0
        data = self.intervals.with_error(self.off)
        of_noise = mean_square(np.repeat(data.noise, 3) / data.scale)

        def residual_square(*orders: int, timestep: float | None = self.timestep) -> float:
            return mean_square(left_by_methods(data, orders, timestep))

        # If errors of the stated order are large enough to explain the motion, another order counts
        # only if it leaves far smaller residuals.
        enough = np.inf if self.is_beyond else LEFT**2 * residual_square(self.order, self.order + 1)
        made = [replace(self, order=n) for n in range(1, self.order)]
        if self.is_beyond:
            made.append(replace(self, timestep=None))
        by_order = {}
        for one in made:
            square = np.inf if one.is_beyond else residual_square(one.order, timestep=one.timestep)
            if square < LARGEST_NEXT**2 + of_noise:
                with_next = residual_square(one.order, one.order + 1, timestep=one.timestep)
                if with_next < min(self.next_term**2 + of_noise, enough):
                    by_order[one.order] = square
        if not by_order:
            return 0
        best = min(by_order, key=by_order.__getitem__)
        # A longer timestep is not called for if the stated method makes the motion with a change.
        if best == self.order and self.found and not self._is_partial(self.found):
            return 0
        by_change = (
            mean_square(data.deviations(self.found.hypothesis[None])) if self.found else np.inf
        )
        return best if by_change > LEFT**2 * by_order[best] else 0

    @property
    def of_other_method(self) -> list[str]:
        """A list of the sentence that the method's order or timestep is not the stated one.

        The list is empty if the motion does not show that.
        """
        if self.is_at_another_timestep:
            return [OTHER_TIMESTEP.format(self.timestep)]
        order = self.apparent_order
        if order == self.order and self.timestep:
            return [LONGER_TIMESTEP.format(self.timestep, order, self.least_timestep)]
        return [LOWER_ORDER.format(order, self.order, "the scene's")] if order else []

    @property
    def least_timestep(self) -> float:
        """The shortest timestep, s, with which errors of the stated order explain the motion.

        It is 0 if no timestep is stated, or if `intervals` is None.
        """
        if self.intervals is None or self.search is None or self.timestep is None:
            return 0.0
        of_method = float(np.mean(self.intervals.of_method))
        ratio = float(np.sqrt(self.search.unchanged.mean_square / of_method))
        return float(self.timestep * max(1.0, ratio ** (1 / self.order)))

    @cached_property
    def known(self) -> KnownIntegrators | None:
        """The comparison of the motion with known integrators; None if `intervals` is."""
        return KnownIntegrators(self.intervals, self.timestep) if self.intervals else None

    def _integrator(self, hypothesis: Hypothesis) -> str:
        """Return in words the integrator that computed the motion from a hypothesis' equations.

        The text is empty if no known integrator did.
        """
        return self.known.that_made(hypothesis) if self.known else ""

    def after(self, found: Fit) -> "Physics":
        """Return the search for further changes; its `base` is the hypothesis that a fit found."""
        return replace(self, base=found.hypothesis)

    @cached_property
    def by_other_equations(self) -> Fit | None:
        """The fit of a change of the equations with which a known integrator computed the motion.

        It is None if there is no such change, or if an integrator computed the motion without any.

        Changes with parameters are tried only if a timestep is stated; besides, `base` must have
        changes already, or the motion must be beyond a method's error. Otherwise the implicit
        damping of an unknown method would look like another tensor of inertia. Nothing is tried if
        samples are many steps apart: the method's error is small then, and `found` shows changes
        without an integrator.
        """
        if self.search is None or self.made_by or self.known is None or not self.known.each:
            return None
        data = self.known.each[0]
        count = min(FEW, int(MOST_STEPS * data.timestep / float(np.median(data.spans))))
        if count < FEWEST_INTERVALS:
            return None
        is_fitted = self.timestep is not None and (self.is_beyond or self.base is not None)
        changes = [one for one in self.search.changes if is_fitted or not len(one.scales)]
        few = [data.spread(count) for data in self.known.each]
        found = [Search(data, changes, most=MOST_PARAMETERS).one() for data in few]
        fits = [fit for fit in found if fit is not None and self._integrator(fit.hypothesis)]
        return min(fits, key=lambda fit: (fit.rank, fit.mean_square), default=None)

    @property
    def is_of_noise(self) -> bool:
        """Whether the recorded ends of intervals are on the exact flow of `base`, but for noise.

        The flow begins at their recorded starts. If `intervals` is None, the property is True.
        """
        return bool((self.off <= self.least).all())

    @property
    def is_of_method(self) -> bool:
        """Whether noise or methods' errors explain the differences from the exact flow of `base`.

        The leading errors of methods are fitted, of all orders up to one above the stated order.
        They must leave less than the next term of a method's error.
        """
        return self._square_beside_methods < self.next_term**2

    @cached_property
    def _square_beside_methods(self) -> float:
        """The mean square that methods' errors leave of the differences from the exact flow.

        The errors are fitted to the differences whose root mean squares are `off`. The mean square
        is relative to the square of `off`, and 0 if the differences are no more than noise.
        """
        if self.intervals is None or self.is_of_noise:
            return 0.0
        data, orders = self.intervals.with_error(self.off), range(1, self.order + 2)
        return mean_square(left_by_methods(data, orders, self.timestep))

    @cached_property
    def off(self) -> FloatArray:
        """The root mean square differences of attitude, rad, and ω, rad/s, in the intervals, (2,).

        They are those of the recorded ends from the exact flow of `base`, followed from the
        recorded starts. They are 0 if `intervals` is None.
        """
        if self.intervals is None:
            return np.zeros(2)
        exact = replace(self.intervals.made_by(EXACT, 0.0), noise=np.ones(2))
        (off,) = exact.deviations(exact.base[None])
        return root_mean_squares(off)

    @cached_property
    def least(self) -> FloatArray:
        """The largest differences of attitude, rad, and ω, rad/s, that count as noise, (2,)."""
        fits = FITS * np.array([1.0, norms(self.motion.omega_body).max()])
        return np.maximum(self.noise, fits)

    @cached_property
    def of_exact_motion(self) -> Fit | None:
        """The fit of a change, or a pair, with which the exact flow leads from sample to sample.

        The changes are those of the equations, or of how states are read. The fit must reduce the
        differences from the exact flow of `base` to the fraction `SAME` or less, or to noise. The
        property is None if no fit does, or if these differences may be a method's error. Changes
        that explain the motion so well may have up to `MOST_OF_ALL` parameters.
        """
        if self.search is None or self.intervals is None or self.is_of_method:
            return None
        noise = np.maximum(self.least, SAME * self.off)
        data = replace(self.intervals.made_by(EXACT, 0.0), noise=noise)
        search = Search(data, self._of_motion, part=SAME)
        found, speed = search.one(), float(norms(self.motion.omega_body).max())
        # No pair is tried if a single change leaves small residuals, which may be a method's error.
        is_much = min((fit.mean_square for fit in search.single), default=np.inf) > LEFT**4 * (
            search.unchanged.mean_square
        )
        if found is None and is_much and self.off[1] > LEAST_FOR_TWO * speed:
            found = Search(data, [TIMES, *READINGS, *self._of_motion], part=SAME).one_or_two()
            # If the body turns about a steady axis, a method's error looks like changes of how ω is
            # read.
            is_of_reading = found is not None and {*found.changes} <= {*READINGS}
            if found and (is_of_reading or found.rank > 2 * MOST_PARAMETERS):
                found = None
        return found if found is not None and found.rank <= MOST_OF_ALL else None

    def explained(self) -> list[str]:
        """Return sentences on what explains the motion; an empty list if nothing does.

        These are tried in turn until one explains the motion: changes of the equations or of how
        states are read; a parameter that varies in time; energy that is lost within the body; a
        missing torque, or a missing angular velocity.
        """
        if self.intervals is None or self.search is None:
            return []
        if self.by_change is not None:
            return self._in_words(self.by_change)
        if not self.is_beyond:
            if self._square_beside_methods < SAME**2:
                return []
            fit = self._within_error
            words = sentences(fit) if fit else []
            words = words or self._varying(self._of_motion)
            return words or ([] if self.is_of_method else self.dissipated)
        return self.unlike_any_change or missing(self.intervals)

    @cached_property
    def unlike_any_change(self) -> list[str]:
        """Sentences on what explains a motion that no change with constant parameters explains.

        They say that a parameter varies in time, or else that energy is lost. The list is empty if
        neither explains the motion.
        """
        changes = self.search.changes if self.search else ()
        of_equations = [one for one in changes if one not in READINGS]
        return self._varying([TIMES, *of_equations]) or self.dissipated

    @property
    def dissipated(self) -> list[str]:
        """A list of the sentence that energy is lost within the body; empty if it is not."""
        return dissipated(self.scenario, self.motion)

    @property
    def by_change(self) -> Fit | None:
        """The fit of one or two changes that explain the motion; None if none do.

        They are changes of the equations, or of how states are read. If the motion is within a
        method's error, they count only if with them the exact flow, or a known integrator, leads
        from sample to sample.
        """
        return self.found if self.is_beyond else self.of_exact_motion or self.by_other_equations

    def _varying(self, changes: Sequence[Change]) -> list[str]:
        """Return sentences on a parameter that varies in time and so explains the motion.

        The list is empty if none does, or if methods' errors explain the motion.

        Parameters
        ----------
        changes : the changes whose parameters are tried
        """
        if self.intervals is None or (self.is_of_method and not self.is_beyond):
            return []
        found = varying(self.intervals, changes, len(changes))
        return [found.words, *self._unexplained(found.rest)] if found else []

    @property
    def _of_motion(self) -> list[Change]:
        """The changes in `search` that do not look like a method's error about a steady axis.

        Changes with parameters are left out if they concern how states are read or how the attitude
        follows from ω; all others are included.
        """
        changes = self.search.changes if self.search else ()
        return [one for one in changes if not (len(one.scales) and is_of_turning(one))]

    @property
    def _within_error(self) -> Fit | None:
        """The fit of one or two changes that, together with methods' errors, explain the motion.

        The property is None if none do, or if `intervals` is None.
        """
        if self.intervals is None or self.search is None:
            return None
        orders, every = range(1, self.order + 1), self._of_motion
        of_method = orders, self.timestep, self.next_term
        return within_error(self.intervals, every, MOST_PARAMETERS, *of_method)

    @cached_property
    def found(self) -> Fit | None:
        """The fit of the change, or of the pair of changes, that explains the motion best.

        Changes of the equations and of how states are read are tried. The property is None if none
        explains the motion.
        """
        if self.search is None or self.intervals is None:
            return None
        found = self.search.one_or_two()
        if found is not None and self._integrator(found.hypothesis):
            return found
        other = self.by_other_equations
        if other is None or self.known is None:
            return found
        residual_square = self.known.left_exactly(found.hypothesis) if found else np.inf
        return other if other.mean_square < SAME**2 * residual_square else found

    def _is_partial(self, found: Fit) -> bool:
        """Return whether a fit explains the motion only in part.

        That is so if neither a method's error nor a known integrator explains its residuals. If
        `intervals` is None, it returns False.
        """
        if self.search is None or self.intervals is None:
            return False
        is_beyond = self.search.exceed_noise(found.residuals)
        return is_beyond and not self._integrator(found.hypothesis)

    @property
    def is_open(self) -> bool:
        """Whether the motion is beyond a method's error, and nothing explains all of it.

        Clamps of ω, known integrators, other methods and the changes in `found` are tried.
        """
        if not self.is_beyond or self.clamps or self.made_by or self.apparent_order:
            return False
        return self.found is None or self._is_partial(self.found)

    @property
    def is_unexplained(self) -> bool:
        """Whether differences from the exact flow are unexplained, be they large or small.

        Differences that are smaller than a method's error are explained if they look like one.
        """
        if self.is_beyond or self.clamps or self.made_by:
            return self.is_open
        return not self.is_of_method and self.by_change is None

    @property
    def is_all(self) -> bool:
        """Whether the changes in `found` explain all of the motion but for noise."""
        return self.found is not None and self.after(self.found).is_of_noise

    @property
    def is_open_or_turning(self) -> bool:
        """Whether correcting a mistake in recording may explain the motion better than `found`.

        It may if `is_open`; or if `found` has two changes, and one is of how states are read, or of
        how the attitude follows from ω: that may be the mistake, and the other all that remains.
        """
        changes = self.found.changes if self.found and not self.made_by else ()
        return self.is_open or (len(changes) > 1 and any(is_of_turning(one) for one in changes))

    @property
    def is_of_equations(self) -> bool:
        """Whether changes explain the motion, none of which concerns how states are read."""
        found = None if self.clamps else self.by_change
        return found is not None and not {*READINGS} & {*found.changes}

    @property
    def is_of_reading(self) -> bool:
        """Whether all changes in `found` concern how states are read or how attitude follows ω."""
        changes = self.found.changes if self.found else ()
        return bool(changes) and all(is_of_turning(one) for one in changes)

    @cached_property
    def clamps(self) -> list[Clamp]:
        """The clamps that explain the motion, in the order of `CLAMPS`; often none.

        A clamp is a bound to which an engine limits ω.
        """
        of_method = float(self.intervals.scale[:, 3:].max()) if self.intervals else np.inf
        of_noise = CERTAIN * float(self.noise[1])
        return list(clamps(self.scenario, self.motion, self.exact, of_method, of_noise))

    def _in_words(self, found: Fit) -> list[str]:
        """Return sentences on the changes that a fit found, and on what explains its residuals.

        A method of lower order may explain the motion together with the changes: then the
        sentences are those of `_of_lower_order`.
        """
        words, rest = sentences(found), self.after(found)
        if rest.is_of_noise:
            return words
        if rest.known and (made := rest.known.that_made(found.hypothesis)):
            return [*words, f"what is left is {made}"]
        if unexplained := self._unexplained(found.residuals):
            return self._of_lower_order(found) or [*words, *unexplained]
        if len(found.changes) > 1:
            return words
        if more := rest.by_other_equations:
            return [*words, *rest._in_words(more)]
        more = rest._within_error
        # A change that was found before only corrects its parameters for a method's error.
        forms = {one.form for one in found.changes}
        if more and not any(one.form in forms for one in more.changes):
            return [*words, *sentences(more)]
        return [*words, *rest._varying(self._of_motion)]

    def _of_lower_order(self, found: Fit) -> list[str]:
        """Return sentences on the changes of a fit, and on a method of lower order than stated.

        The changes are fitted again, together with the errors of methods of each lower order, until
        these together explain the motion. The list is empty if they never do, or if no timestep is
        stated.
        """
        if self.intervals is None or self.timestep is None:
            return []
        for order in range(1, self.order):
            of_method = order, self.timestep, self.next_term
            if fit := refitted(self.intervals, found, *of_method):
                return [*sentences(fit), LOWER_ORDER.format(order, self.order, "these")]
        return []

    def _unexplained(self, rest: FloatArray) -> list[str]:
        """Return a list of the sentence that part of the difference is not explained.

        It is empty if noise and a method's error explain the residuals, or if `intervals` is None.

        Parameters
        ----------
        rest : the residuals that an explanation leaves, in units of `Intervals.scale`, of any shape
        """
        if self.search is None or not self.search.exceed_noise(rest):
            return []
        part = float(np.sqrt(np.mean(rest**2) / self.search.unchanged.mean_square))
        return [UNEXPLAINED.format(100 * part)]
