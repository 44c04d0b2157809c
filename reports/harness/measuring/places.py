"""Exact states along a motion from which a method is tested, one step at a time."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....engines.checks.equations import Equations
from ....engines.checks.read_back import State, stacked
from ....scenarios import FloatArray, Scenario, Trajectory, angular_momentum_world
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.rotation import norms, times, turned_back
from ..timesteps.ladder import COARSEST_TURN

#: Number of states spread evenly over the window, besides those in which a quantity is extreme.
SPREAD = 12
#: Directions of ω in the body in two further states. They are along none of the coordinate axes, so
#: that no torque vanishes by symmetry if these are the principal axes.
ASKEW = ((0.62, 0.55, 0.56), (-0.48, 0.71, 0.52))
#: Number of timesteps, each half of the one before, with which single steps are taken.
HALVINGS = 10
#: Number of times that timesteps are halved where shorter ones are needed, for example if a method
#: refuses the longest.
FINER = 3


@dataclass(frozen=True, eq=False)
class Places:
    """Exact states of a scene, and the timesteps of the steps that are taken from them.

    Attributes
    ----------
    states : K states
    times : times of the states, s; nan where a state is not on the motion, (K,)
    timesteps : s, each half of the one before, (J,)
    condition : the factor by which a relative error of rounding grows in the angular acceleration.
        It is the sum of the condition number of the tensor of inertia about the fixed point and of
        two contributions: that of a free body's com that is not at its origin, and that of rotors
    are_apart : whether the states are so far apart that their gains are independent
    gives_way : whether it is known that a constraint must settle before steps are judged
    """

    states: State
    times: FloatArray
    timesteps: FloatArray
    condition: float
    are_apart: bool = True
    gives_way: bool = False

    def changed(self, scenario: Scenario, size: float, repeats: int = 1) -> State:
        """Return all K states, repeated R times, (R K), with one random change for each repeat.

        Parameters
        ----------
        size : standard deviation of the change, in rad for the attitude, and relative for vectors
        repeats : R
        """
        chance = np.random.default_rng(repeats)
        copies = [changed_at_random(scenario, self.states, size, chance) for _ in range(repeats)]
        return stacked(copies)

    def thinned(self, most: int) -> "Places":
        """Return at most `most` of the states, spread evenly, with the same timesteps."""
        kept = np.unique(np.linspace(0, len(self.times) - 1, most).astype(int))
        return replace(self, states=self.states.rows(kept), times=self.times[kept])

    def milder(self) -> "Places":
        """Return only the states that are on the motion, with shorter timesteps.

        They are used if a method refuses some of the original states or timesteps.
        """
        along = ~np.isnan(self.times)
        timesteps = self.timesteps / 2.0**FINER
        states, of_motion = self.states.rows(along), self.times[along]
        return replace(self, states=states, times=of_motion, timesteps=timesteps)


def places(scenario: Scenario, motion: Trajectory, coarsest: float | None) -> Places:
    """Choose timesteps, states of the exact motion, and two more with ω along no coordinate axis.

    States in which a one-sided constraint would have to pull are left out.

    Parameters
    ----------
    motion : the exact motion at the samples of the window
    coarsest : the ladder's coarsest timestep, s, which becomes the longest timestep of the steps.
        If None, that is computed from the motion's fastest rate
    """
    equations, along = Equations(scenario), motion.at(_chosen_samples(scenario, motion))
    rate = fastest_rate(scenario, motion.omega_body) or 1 / scenario.window.duration
    speed = float(norms(motion.omega_body).max()) or rate
    first = states_of(along).rows(np.zeros(len(ASKEW), dtype=int))
    askew = equations.on_constraint(replace(first, omega_body=speed * np.array(ASKEW)))
    states = stacked([states_of(along), askew])
    bears = equations.bears(states)
    when = np.append(along.t, [np.nan] * len(ASKEW))
    timesteps = (coarsest or COARSEST_TURN / rate) / 2.0 ** np.arange(HALVINGS)
    condition = float(np.linalg.cond(scenario.inertia))
    condition += _condition_of_rotors(scenario, motion) + _condition_of_flight(scenario)
    return Places(states.rows(bears), when[bears], np.asarray(timesteps), condition)


def states_of(motion: Trajectory) -> State:
    """Return the states of a motion at its n samples."""
    return State(*(getattr(motion, name) for name in State.__dataclass_fields__))


def _chosen_samples(scenario: Scenario, motion: Trajectory) -> NDArray[np.intp]:
    """Return indices of samples spread over the window, and of those with extreme ω, tilt or speed.

    The array is sorted, and each sample is in it once.
    """
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
    """Return the given states, all with the same random relative change.

    A state stays as it is if, after the change, a one-sided constraint would have to pull.

    Parameters
    ----------
    size : standard deviation of each component of the change: in rad for the attitude, and relative
        to their norms for vectors
    chance : the generator of random numbers from which the change is drawn
    """
    turn, omega_change, velocity_change, com_change = size * chance.standard_normal((4, 3))
    q = states.q_world_body_wxyz @ times(np.append(1.0, turn / 2) / np.sqrt(1 + turn @ turn / 4))
    other = State(
        q,
        _changed_by(states.omega_body, omega_change),
        _changed_by(states.com_world, com_change),
        _changed_by(states.velocity_world, velocity_change),
        states.spins,
    )
    equations = Equations(scenario)
    return equations.bearable(equations.on_constraint(other), states)


def _changed_by(vectors: FloatArray, change: FloatArray) -> FloatArray:
    """Return n vectors v, (n, 3), all with one relative change c, (3,), that is, v + ‖v‖ c."""
    return np.asarray(vectors + norms(vectors)[:, None] * change)


def _condition_of_flight(scenario: Scenario) -> float:
    """Return how much a free body's com away from the origin adds to `Places.condition`.

    Engines that solve for rotation and translation together compute the moment of inertia about the
    com as that about the body's origin less m r², with r the distance between the two points.
    Digits cancel in this difference. The result is m r² divided by the smallest principal moment
    about the com; on a pivot it is 0.
    """
    if scenario.constraint.is_pivot:
        return 0.0
    body = scenario.body
    return float(body.mass * (body.com @ body.com) / body.principal_moments[0])


def _condition_of_rotors(scenario: Scenario, motion: Trajectory) -> float:
    """Return the contribution of rotors to `Places.condition`.

    It is the size of the torques that cancel in coordinates that turn with the rotors, divided by
    that of the gyroscopic torque.
    """
    _, torque = scenario.cancelling(motion.spins)
    L_world, speed = angular_momentum_world(scenario, motion), norms(motion.omega_body).max()
    gyroscopic = float(norms(L_world).max() * speed)
    return float(torque.max()) / gyroscopic if gyroscopic else 0.0
