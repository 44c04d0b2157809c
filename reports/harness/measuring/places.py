"""Exact states along a motion that a method is tested from, one step at a time."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....engines.checks.equations import Equations
from ....engines.checks.read_back import State, stacked
from ....scenarios import FloatArray, Scenario, Trajectory, angular_momentum_world
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.rotation import norms, times, turned_back
from ..timesteps.ladder import COARSEST_TURN

#: States spread evenly over the window, beside those in which some quantity is largest or least.
SPREAD = 12
#: Directions of ω in the body of two further states: along no axis of a body whose principal axes
#: are the coordinate axes, so that no torque vanishes by symmetry.
ASKEW = ((0.62, 0.55, 0.56), (-0.48, 0.71, 0.52))
#: Timesteps of single steps, each half of the one before.
HALVINGS = 10
#: By how many halvings all timesteps are shorter if a method refuses the longest.
FINER = 3


@dataclass(frozen=True, eq=False)
class Places:
    """Exact states of a scene, and the timesteps of the steps that are taken from them.

    Attributes
    ----------
    states : K of them
    times : s, of the states; nan where a state is not of the motion, (K,)
    timesteps : s, each half of the one before, (J,)
    condition : the factor by which relative rounding grows in the angular acceleration: of the
        tensor of inertia about the fixed point, of flight, and of parts that turn
    are_apart : whether the states are so far apart that their gains are independent
    gives_way : whether a constraint is known to have to settle before steps are judged
    """

    states: State
    times: FloatArray
    timesteps: FloatArray
    condition: float
    are_apart: bool = True
    gives_way: bool = False

    def changed(self, scenario: Scenario, size: float, repeats: int = 1) -> State:
        """All states, repeated, with each number changed at random by about `size` of it."""
        chance = np.random.default_rng(repeats)
        copies = [changed_at_random(scenario, self.states, size, chance) for _ in range(repeats)]
        return stacked(copies)

    def thinned(self, most: int) -> "Places":
        """The same with at most so many of the states, evenly chosen."""
        kept = np.unique(np.linspace(0, len(self.times) - 1, most).astype(int))
        return replace(self, states=self.states.rows(kept), times=self.times[kept])

    def milder(self) -> "Places":
        """The same with shorter timesteps, and with states of the motion alone.

        They are used if a method refuses some of these states or timesteps.
        """
        along = ~np.isnan(self.times)
        timesteps = self.timesteps / 2.0**FINER
        states, of_motion = self.states.rows(along), self.times[along]
        return replace(self, states=states, times=of_motion, timesteps=timesteps)


def places(scenario: Scenario, motion: Trajectory, coarsest: float | None) -> Places:
    """Choose states along the exact motion, and two with ω along no principal axis.

    Parameters
    ----------
    coarsest : s, the ladder's coarsest timestep; None if the motion has no ladder
    """
    equations, along = Equations(scenario), motion.at(_chosen(scenario, motion))
    rate = fastest_rate(scenario, motion.omega_body) or 1 / scenario.window.duration
    speed = float(norms(motion.omega_body).max()) or rate
    first = states_of(along).rows(np.zeros(len(ASKEW), dtype=int))
    askew = equations.on_constraint(replace(first, omega_body=speed * np.array(ASKEW)))
    states = stacked([states_of(along), askew])
    bears = equations.bears(states)
    when = np.append(along.t, [np.nan] * len(ASKEW))
    timesteps = (coarsest or COARSEST_TURN / rate) / 2.0 ** np.arange(HALVINGS)
    condition = float(np.linalg.cond(scenario.inertia))
    condition += _of_parts(scenario, motion) + _of_flight(scenario)
    return Places(states.rows(bears), when[bears], np.asarray(timesteps), condition)


def states_of(motion: Trajectory) -> State:
    """The states of a motion's samples."""
    return State(*(getattr(motion, name) for name in State.__dataclass_fields__))


def _chosen(scenario: Scenario, motion: Trajectory) -> NDArray[np.intp]:
    """Samples spread over the window, and those of the largest and least ω, tilt and speed."""
    spread = np.linspace(0, len(motion.t) - 1, SPREAD).astype(int)
    omega = motion.omega_body
    down = scenario.gravity_world if scenario.gravity_world.any() else np.array([0.0, 0.0, 1.0])
    R = motion.R_world_body.as_matrix()
    columns = [
        norms(omega),
        *np.abs(omega).T,
        turned_back(R, np.broadcast_to(down, omega.shape)) @ scenario.constraint.lever,
        norms(motion.velocity_world),
    ]
    extremes = [find(column) for column in columns for find in (np.argmax, np.argmin)]
    return np.unique([*spread, *extremes])


def changed_at_random(
    scenario: Scenario, states: State, size: float, chance: np.random.Generator
) -> State:
    """The states with each number changed at random, where the body can be held there.

    Parameters
    ----------
    size : standard deviation of the change: of the attitude in rad, of vectors relative to their
        norms
    """
    turn, spin, thrown, put = size * chance.standard_normal((4, 3))
    q = states.q_world_body_wxyz @ times(np.append(1.0, turn / 2) / np.sqrt(1 + turn @ turn / 4))
    other = State(
        q,
        _by(states.omega_body, spin),
        _by(states.com_world, put),
        _by(states.velocity_world, thrown),
        states.spins,
    )
    equations = Equations(scenario)
    return equations.bearable(equations.on_constraint(other), states)


def _by(vectors: FloatArray, share: FloatArray) -> FloatArray:
    """Vectors (n, 3), each changed by its norm times `share`, (3,)."""
    return np.asarray(vectors + norms(vectors)[:, None] * share)


def _of_flight(scenario: Scenario) -> float:
    """What a com off the body's origin adds to the condition of its mass matrix, if it can fly.

    Engines that solve for rotation and flight together divide by what m arm² leaves of the moment
    about the origin.
    """
    if scenario.constraint.is_pivot:
        return 0.0
    body = scenario.body
    return float(body.mass * (body.com @ body.com) / body.principal_moments[0])


def _of_parts(scenario: Scenario, motion: Trajectory) -> float:
    """The ratio of torques that cancel in coordinates turning with parts to the gyroscopic one."""
    _, torque = scenario.cancelling(motion.spins)
    L_world, speed = angular_momentum_world(scenario, motion), norms(motion.omega_body).max()
    gyroscopic = float(norms(L_world).max() * speed)
    return float(torque.max()) / gyroscopic if gyroscopic else 0.0
