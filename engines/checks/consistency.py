"""Whether an engine's single steps are consistent with a scene's equations of motion.

From each of many states one step is taken with each of a row of halved timesteps, and compared with
the exact flow from the same state. What a step gains beyond it, per second, is a power series of
the timestep that begins with h^p for a method of order p (Hairer, Nørsett & Wanner I, §II.3). It is
extrapolated to h → 0 by Neville's rule: what is left there is the difference between the engine's
equations of motion and the scene's, known far better than one step's error.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray, Scenario, push
from ...scenarios.rotation import matrices, norms, rotation_vectors, turned
from ...scenarios.scenario import started_at
from ..session import Session
from .equations import Equations
from .extrapolation import ABOVE, COARSER, Gains, extrapolated, noise_of, surprises
from .read_back import State

#: Roundings of a step's gain, in ulp of the state.
ROUNDINGS = 16.0
#: Fraction of the largest terms that is as good as nothing.
NEGLIGIBLE = 2e-6
#: Smallest size that is divided by.
NO_SIZE = 1e-300

Open = Callable[[Scenario, float], AbstractContextManager[Session]]
#: The exact states a time after each of n states, s, (n,).
After = Callable[[State, FloatArray], State]


@dataclass(frozen=True, eq=False)
class Steps:
    """States before and after a step, and where the exact motion goes from those before.

    Each column has J K rows: K states with the first timestep, then with the next.

    Attributes
    ----------
    timesteps : (J,) s
    """

    timesteps: FloatArray
    before: State
    after: State
    exact: State

    @property
    def spans(self) -> FloatArray:
        """The timestep of each row, s, (J K,)."""
        return np.repeat(self.timesteps, len(self.before.omega_body) // len(self.timesteps))

    def part(self, first: int, beyond: int) -> "Steps":
        """The steps with some of the timesteps."""
        count = len(self.before.omega_body) // len(self.timesteps)
        rows = slice(first * count, beyond * count)
        states = (states.rows(rows) for states in (self.before, self.after, self.exact))
        return Steps(self.timesteps[first:beyond], *states)


@dataclass(frozen=True, eq=False)
class Excess:
    """What a step gains a second beyond the exact motion.

    The quantities are: of the attitude rad/s and of I ω N m, body axes; of a free body's velocity
    m/s² and place m/s, world axes; of a body on a pivot how far velocity (m/s) and com (m) are from
    where ω and attitude put them.

    Attributes
    ----------
    limit : at vanishing timesteps, (K, 4, 3)
    tolerance : the largest that this may be, (K, 4)
    sizes : the largest terms that the gains are sums of, (4,)
    by_timestep : the largest gain before extrapolation, relative to these sizes, (J, 4)
    unsmooth : how far the gain with each timestep is from what the others predict of it, likewise,
        in units of what reading a state explains, (J, 4)
    unsmooth_others : of further timesteps, likewise
    is_idle : where next to nothing acts, so that next to nothing is asked, (K, 4)
    is_constrained : whether a constraint holds the body: its com is off the pivot, by as much as
        the timestep makes it
    """

    limit: FloatArray
    tolerance: FloatArray
    sizes: FloatArray
    by_timestep: FloatArray
    unsmooth: FloatArray
    unsmooth_others: FloatArray
    is_idle: NDArray[np.bool_]
    is_constrained: bool

    @property
    def by_tolerance(self) -> FloatArray:
        """The limits, in tolerances, (K, 4)."""
        return np.asarray(np.abs(self.limit).max(axis=2) / self.tolerance)

    @property
    def is_open(self) -> bool:
        """Whether what is left where next to nothing acts would be inconsistent elsewhere.

        Over a long time it may add up.
        """
        elsewhere = self.tolerance - NEGLIGIBLE * self.sizes
        return bool((np.abs(self.limit).max(axis=2) > elsewhere)[self.is_idle].any())


def single_steps(
    open_at: Open,
    scenario: Scenario,
    states: State,
    timesteps: FloatArray,
    after: After,
    settle: int = 0,
) -> Steps:
    """Take one step from each of K states with each of J timesteps.

    Parameters
    ----------
    settle : steps before that one, from each state
    """
    before, later = [], []

    def take(session: Session) -> None:
        if settle:
            session.advance(settle)
        before.append(session.snapshot())
        session.advance(1)
        later.append(session.snapshot())

    with open_at(scenario, float(timesteps[0])) as first:
        each = [states.rows(k) for k in range(_count(states))]
        starts = [] if first.can_restart else [started_at(scenario, **vars(one)) for one in each]
        for timestep in map(float, timesteps):
            for state in each if first.can_restart else ():
                first.restart(state, timestep)
                take(first)
            for start in starts:
                with open_at(start, timestep) as session:
                    take(session)
        befores, ends = first.states(before), first.states(later)
    return Steps(timesteps, befores, ends, after(befores, np.repeat(timesteps, _count(states))))


def excess(
    equations: Equations, steps: Steps, others: Steps, epsilon: float, slack: float
) -> Excess:
    """Extrapolate what the steps gain to vanishing timesteps.

    Parameters
    ----------
    others : with timesteps of their own, coarse to fine, which the first are to predict
    epsilon : relative rounding of the engine's floating-point numbers
    slack : relative to the largest terms, what a body that an engine holds so exactly leaves
    """
    gains = step_gains(equations, steps)
    sizes = np.maximum(term_sizes(equations, steps.before).max(axis=0), NO_SIZE)
    read = ABOVE * slack * _rates(equations, sizes)
    noise = np.minimum(noise_of(steps.timesteps, gains), read)

    def rounding(steps: Steps) -> FloatArray:
        ulps = _roundings(equations, steps).reshape(len(steps.timesteps), -1, 4)
        return np.asarray(ROUNDINGS * epsilon * ulps + noise / steps.timesteps[:, None, None])

    limit, known_to = extrapolated(steps.timesteps, gains, rounding(steps))
    # Where next to nothing acts, as on a body at rest, next to nothing is asked.
    local = term_sizes(equations, steps.before).reshape(gains.shape[:3])[0]
    is_idle = local < NEGLIGIBLE * sizes
    slack_of_terms = (ABOVE * slack + np.where(is_idle, NEGLIGIBLE, 0.0)) * sizes
    if not equations.scenario.constraint.is_pivot:
        # Engines may solve for rotation and flight together, with terms m v² that cancel.
        speeds = norms(steps.before.velocity_world).reshape(gains.shape[:2])[0]
        slack_of_terms[:, 1] += ROUNDINGS * epsilon * equations.scenario.body.mass * speeds**2
    if equations.scenario.rotors and equations.scenario.constraint.is_free:
        spins = steps.before.spins.reshape(*gains.shape[:2], -1)[0]
        body = equations.scenario.body
        force, _ = equations.scenario.rotors.cancelling(spins, body.com)
        rounded = ROUNDINGS * epsilon * force / body.mass
        slack_of_terms[:, 2] += rounded
        slack_of_terms[:, 3] += rounded * steps.timesteps[0]
    off = norms(_off_the_constraint(equations, steps.after)[1])
    nodes = Gains(steps.timesteps, gains, rounding(steps))
    added = Gains(others.timesteps, step_gains(equations, others), rounding(others))
    unsmooth, unsmooth_others = (
        surprises(nodes, at, least) / (slack_of_terms + read / at.timesteps[:, None, None])
        for at, least in ((nodes, COARSER), (added, 1))
    )
    return Excess(
        limit,
        known_to + slack_of_terms,
        sizes,
        (np.abs(gains).max(axis=3) / sizes).max(axis=1),
        unsmooth.max(axis=1),
        unsmooth_others.max(axis=1),
        is_idle,
        # By how much the com is off: a body that is another keeps that, a constraint does not.
        bool(np.ptp(off.reshape(gains.shape[:2]), axis=0).max() > ABOVE * slack * equations.reach),
    )


def step_gains(equations: Equations, steps: Steps) -> FloatArray:
    """What each step gains beyond the exact motion, a second, (J, K, 4, 3)."""
    spans, after, exact = steps.spans[:, None], steps.after, steps.exact
    shape = (len(steps.timesteps), -1, 4, 3)
    attitude = rotation_vectors(exact.q_world_body_wxyz, after.q_world_body_wxyz) / spans
    torque = (after.omega_body - exact.omega_body) @ equations.inertia.T / spans
    if equations.scenario.constraint.is_pivot:
        velocity, place = _off_the_constraint(equations, after)
    else:
        # A contact lets a body sink in: that is not a step's doing, and the exact motion has none.
        off_velocity, off_place = _off_the_constraint(equations, steps.before)
        velocity = (after.velocity_world - exact.velocity_world - off_velocity) / spans
        place = (after.com_world - exact.com_world - off_place) / spans
    return np.stack([attitude, torque, velocity, place], axis=1).reshape(shape)


def _off_the_constraint(equations: Equations, states: State) -> tuple[FloatArray, FloatArray]:
    """How far velocity, m/s, and com, m, are from where ω and attitude put them, (n, 3) each."""
    constraint = equations.scenario.constraint
    R_world_body = matrices(states.q_world_body_wxyz)
    swing_world = turned(R_world_body, np.cross(states.omega_body, constraint.lever))
    lever_world = R_world_body @ constraint.lever
    return (
        states.velocity_world - constraint.velocity_world(swing_world, states.velocity_world),
        states.com_world - constraint.com_world(lever_world, states.com_world),
    )


def term_sizes(equations: Equations, states: State) -> FloatArray:
    """Sizes of the terms that gains are sums of, (n, 4)."""
    scenario, reach = equations.scenario, equations.reach
    speeds = norms(states.omega_body)
    g = float(np.linalg.norm(scenario.gravity_world))
    still, pushed = (
        push(scenario.pushed, np.eye(3), omega)
        for omega in (np.zeros(3), np.array(states.omega_body))
    )
    outer = np.linalg.norm(still) + norms(pushed - still)
    if not scenario.constraint.is_free:
        outer = outer + scenario.body.mass * g * equations.arm
    if scenario.constraint.is_pivot:
        velocity, place = speeds * reach, np.full_like(speeds, reach)
    else:
        velocity, place = g + reach * speeds**2, norms(states.velocity_world) + reach * speeds
    torque = _largest_moment(equations) * speeds**2 + norms(equations.kept_body(states)) * speeds
    torque += outer
    return np.stack([speeds, torque, velocity, place], axis=1)


def _roundings(equations: Equations, steps: Steps) -> FloatArray:
    """The change of a gain by one rounding of the states read, in ulp, (n, 4)."""
    states, spans = steps.before, steps.spans
    speeds = np.maximum(norms(states.omega_body), norms(steps.after.omega_body))
    fast = norms(states.velocity_world) + equations.reach * speeds
    far = norms(states.com_world) + equations.reach
    sizes = [1 / spans, _largest_moment(equations) * speeds / spans, fast, far]
    table = np.stack(np.broadcast_arrays(*sizes), axis=1)
    if not equations.scenario.constraint.is_pivot:
        table[:, 2:] /= spans[:, None]
    return table


def _rates(equations: Equations, sizes: FloatArray) -> FloatArray:
    """Sizes of what the gains are gains of, which are read: rad, N m s, and m/s and m, (4,)."""
    speed, reach = float(sizes[0]), equations.reach
    if equations.scenario.constraint.is_pivot:
        return np.array([1.0, _largest_moment(equations) * speed, 0.0, 0.0])
    return np.array([1.0, _largest_moment(equations) * speed, float(sizes[3]), reach])


def _largest_moment(equations: Equations) -> float:
    return float(np.linalg.norm(equations.inertia, 2))


def _count(states: State) -> int:
    return len(states.omega_body)
