"""Whether an engine's single steps are consistent with a scene's equations of motion.

From each of many states one step is taken with each of a row of halved timesteps, and compared with
the exact flow from the same state. What a step gains beyond it, per second, is a power series of
the timestep that begins with h^p for a method of order p (Hairer, Nørsett & Wanner I, §II.3). It is
extrapolated to h → 0 by Neville's rule: what is left there is the difference between the engine's
equations of motion and the scene's, known far better than one step's error.

In single precision rounding hides that: a step's is 1e-7 and counts as 1e-5 a radian. It differs
from state to state, a fault does not. So each state is repeated with small changes, and the mean
of what is extrapolated is judged, by its standard error.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray
from ...scenarios.rotation import norms
from .equations import Equations
from .extrapolation import ABOVE, COARSER, Gains, extrapolated, margins, noise_of, surprises
from .steps import Steps, off_the_constraint, step_gains
from .terms import rates, roundings, term_sizes, weakest_effects

#: Roundings of a step's gain, in ulp of the state.
ROUNDINGS = 16.0
#: Fraction of the largest terms that is as good as nothing.
NEGLIGIBLE = 2e-6
#: Timesteps, at most, that the limit of the finest alone is extrapolated from.
FINEST = 5
#: Smallest size that is divided by.
NO_SIZE = 1e-300


@dataclass(frozen=True, eq=False)
class Excess:
    """What a step gains a second beyond the exact motion.

    The quantities are: of the attitude rad/s and of I ω N m, body axes; of a free body's velocity
    m/s² and place m/s, world axes; of a body on a pivot how far velocity (m/s) and com (m) are from
    where ω and attitude put them.

    Attributes
    ----------
    limit : at vanishing timesteps, (K, 4, 3)
    known_to : the uncertainty of that, (K, 4)
    tolerance : the largest that the limit may be, (K, 4)
    sizes : the largest terms that the gains are sums of, (4,)
    weakest : the least of them that an effect adds at most, infinite where none does, (4,)
    by_timestep : the largest gain before extrapolation, relative to these sizes, (J, 4)
    unsmooth : how far the gain with each timestep is from what the others predict of it, likewise,
        in units of what reading a state explains, (J, 4)
    unsmooth_others : of further timesteps, likewise
    branched : the largest change of a gain as steps of another length are computed otherwise, of
        the timesteps and the further ones, relative to the sizes, (J + …, 4)
    slack : relative, what the body as it is held leaves
    is_idle : where next to nothing acts, so that next to nothing is asked, (K, 4)
    is_constrained : whether a constraint holds the body: its com is off the pivot, by as much as
        the timestep makes it
    """

    limit: FloatArray
    known_to: FloatArray
    tolerance: FloatArray
    sizes: FloatArray
    weakest: FloatArray
    by_timestep: FloatArray
    unsmooth: FloatArray
    unsmooth_others: FloatArray
    branched: FloatArray
    slack: float
    is_idle: NDArray[np.bool_]
    is_constrained: bool

    @property
    def by_tolerance(self) -> FloatArray:
        """The limits, in tolerances, (K, 4)."""
        return np.asarray(self.off / self.tolerance)

    @property
    def off(self) -> FloatArray:
        """The sizes of the limits, (K, 4)."""
        return np.asarray(np.abs(self.limit).max(axis=2))

    @property
    def at_most(self) -> float:
        """The largest of `most`, relative to the sizes."""
        return float((self.most / np.maximum(self.sizes, NO_SIZE)).max())

    @property
    def of_an_effect(self) -> float:
        """The same, relative to the weakest effect of the scene."""
        return float((self.most / self.weakest).max())

    @property
    def most(self) -> FloatArray:
        """What steps may gain in the limit, all uncertainties included, (K, 4)."""
        return np.asarray(self.off + self.known_to + self.slack * self.sizes)

    @property
    def is_open(self) -> bool:
        """Whether what is left where next to nothing acts would be inconsistent elsewhere.

        Over a long time it may add up.
        """
        elsewhere = self.tolerance - NEGLIGIBLE * self.sizes
        return bool((self.off > elsewhere)[self.is_idle].any())


def excess(
    equations: Equations,
    steps: Steps,
    others: Steps,
    epsilon: float,
    slack: float,
    least_turn: float = 0.0,
) -> Excess:
    """Extrapolate what the steps gain to vanishing timesteps.

    Parameters
    ----------
    others : with timesteps of their own, coarse to fine, which the first are to predict
    epsilon : relative rounding of the engine's floating-point numbers
    slack : relative to the largest terms, what a body that an engine holds so exactly leaves
    least_turn : rad, turns that a constraint's solver leaves out
    """
    sizes = np.maximum(term_sizes(equations, steps.before).max(axis=0), NO_SIZE)
    is_averaged = steps.repeats > 1
    # Of a mean, what a reading is off by always; else by chance as well.
    read = (ROUNDINGS * epsilon if is_averaged else ABOVE * slack) * rates(equations, sizes)
    noise = np.minimum(noise_of(steps.timesteps, step_gains(equations, steps)), read)
    nodes, added = (_gains(equations, one, epsilon, noise, least_turn) for one in (steps, others))
    slack_of_terms = _slack_of_terms(equations, steps, sizes, epsilon, slack)
    off = norms(off_the_constraint(equations, steps.after)[1]).reshape(len(steps.timesteps), -1)
    both = (nodes, COARSER), (added, 1)
    found = [surprises(nodes, at, least, NEGLIGIBLE * sizes) for at, least in both]
    unsmooth, unsmooth_others = (
        apart / (slack_of_terms + read / at.timesteps[:, None, None])
        for (apart, *_), at in zip(found, (nodes, added), strict=True)
    )
    branched = np.concatenate([one for _, one, _ in found])
    # A limit that is extrapolated across such a change is known no better than that. Nor is one of
    # a constraint in single precision, whose solver may leave off small corrections.
    # By how much the com is off: a body that is another keeps that, a constraint does not.
    is_constrained = bool(np.ptp(off, axis=0).max() > ABOVE * slack * equations.reach)
    surprise = found[0][0].max(axis=0).clip(0) * (is_constrained and is_averaged)
    across = ABOVE * (branched.max(axis=(0, 1)) + surprise)
    limit, known_to = _limits(nodes, slack_of_terms, across, found[0][2])
    return Excess(
        limit,
        known_to,
        known_to + slack_of_terms,
        sizes,
        weakest_effects(equations, steps.before, NEGLIGIBLE * sizes),
        (np.abs(nodes.values.mean(axis=1)).max(axis=3) / sizes).max(axis=1),
        unsmooth.max(axis=1),
        unsmooth_others.max(axis=1),
        branched.max(axis=1) / sizes,
        slack,
        _is_idle(equations, steps, sizes),
        is_constrained,
    )


def _gains(
    equations: Equations, steps: Steps, epsilon: float, noise: FloatArray, least_turn: float
) -> Gains:
    """What steps gain, and what rounding and noise may make of it."""
    shape = len(steps.timesteps), steps.repeats, -1, 4
    values = step_gains(equations, steps).reshape(*shape, 3)
    ulps = roundings(equations, steps.before, steps.after, steps.spans)
    rounded = epsilon * ulps.reshape(shape).max(axis=1)
    if steps.repeats == 1:
        rounded = ROUNDINGS * rounded + noise / steps.timesteps[:, None, None]
    rounded[:, :, 0] += least_turn / steps.timesteps[:, None]
    return Gains(steps.timesteps, values, rounded)


def _limits(
    nodes: Gains, slack_of_terms: FloatArray, across: FloatArray, is_last: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Limits of the gains, (K, 4, 3), and what they are known to, (K, 4).

    Coarse steps may tell the limit best, and finer ones do something else: where only the finest
    tend to what cannot be right, that counts.

    Parameters
    ----------
    across : how much worse a limit is known that is extrapolated across a change, (4,) or (K, 4)
    is_last : where such a change comes after a timestep, (J, K, 4)
    """
    limit, known_to = extrapolated(nodes)
    known_to = known_to + across
    for count in range(2, FINEST + 1):
        last = slice(-count, None)
        finest = Gains(nodes.timesteps[last], nodes.values[last], nodes.rounding[last])
        other, other_to = extrapolated(finest)
        off, other_off = (np.abs(one).max(axis=2) for one in (limit, other))
        tolerance = other_to + slack_of_terms
        least = margins(other_off > tolerance) * tolerance
        is_wrong = (off <= known_to + slack_of_terms) & (other_off > least)
        is_wrong &= ~is_last[last].any(axis=0)
        limit = np.where(is_wrong[..., None], other, limit)
        known_to = np.where(is_wrong, other_to, known_to)
    return limit, known_to


def _is_idle(equations: Equations, steps: Steps, sizes: FloatArray) -> NDArray[np.bool_]:
    """Where next to nothing acts, as on a body at rest, (K, 4)."""
    terms = _of_states(term_sizes(equations, steps.before), steps)
    return np.asarray(terms < NEGLIGIBLE * sizes)


def _of_states(rows: FloatArray, steps: Steps) -> FloatArray:
    """The largest of each state's repeats, with the coarsest timestep, (K, …)."""
    table = rows.reshape(len(steps.timesteps), steps.repeats, -1, *rows.shape[1:])
    return np.asarray(table[0].max(axis=0))


def _slack_of_terms(
    equations: Equations, steps: Steps, sizes: FloatArray, epsilon: float, slack: float
) -> FloatArray:
    """What the body as it is held, and rounding, may always add to the gains, (K, 4)."""
    body, constraint = equations.scenario.body, equations.scenario.constraint
    # Where next to nothing acts, next to nothing is asked.
    idle = _is_idle(equations, steps, sizes)
    slack_of_terms = (ABOVE * slack + np.where(idle, NEGLIGIBLE, 0.0)) * sizes
    if not constraint.is_pivot:
        # Engines may solve for rotation and flight together, with terms m v² that cancel.
        speeds = _of_states(norms(steps.before.velocity_world), steps)
        slack_of_terms[:, 1] += ROUNDINGS * epsilon * body.mass * speeds**2
    if steps.before.spins.size and constraint.is_free:
        force, _ = equations.scenario.cancelling(_of_states(np.abs(steps.before.spins), steps))
        rounded = ROUNDINGS * epsilon * force / body.mass
        slack_of_terms[:, 2] += rounded
        slack_of_terms[:, 3] += rounded * steps.timesteps[0]
    return slack_of_terms
