"""Jacobians, with respect to attitude and ω, of an engine's steps and of the exact motion.

Rows and columns are three components of attitude, rad, and three of ω, rad/s, in body axes:
docs/explanation/sensitivities.md. "In units" means divided by the units of `Units`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....engines import Engine, State
from ....reference import sensitivity, solve_cheaply
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import cross, matrices, rotation_vectors, times, turned
from ....scenarios.scenario import started_at
from ..measuring.noise import ULPS
from ..measuring.steps import Sessions, flowed

#: Order of the central differences that are taken.
ORDER = 4
#: Offsets of a central difference of that order, in multiples of ε, and weights of the results
#: (Fornberg, Math. Comp. 51 (1988) 699, table 1).
CHANGES, WEIGHTS = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12
#: Number of components of a state in the chart; the first three are the attitude's.
CHART = 6


@dataclass(frozen=True)
class Units:
    """The units of changes of the six components in the chart.

    Attributes
    ----------
    rate : unit of ω, rad/s; the unit of the attitude is 1 rad
    ulp : relative spacing of the numbers in an engine's state
    """

    rate: float
    ulp: float

    @property
    def each(self) -> FloatArray:
        """The unit of each of the six components in the chart, rad and rad/s, (6,)."""
        return np.repeat([1.0, self.rate], 3)

    @property
    def change(self) -> float:
        """The best change ε of a component, in units, for central differences of order 4.

        With it, the error by rounding is as large as the truncation error.
        """
        return float(self.ulp ** (1 / (ORDER + 1)))

    def of(self, jacobians: FloatArray) -> FloatArray:
        """Return `jacobians`, (..., 6, 6), which are in rad and rad/s, converted to these units."""
        return np.asarray(jacobians / self.each[:, None] * self.each)


def units_of(engine: Engine, rate: float) -> Units:
    """Return the units of attitude and ω for an engine and a motion's fastest rate, rad/s."""
    return Units(rate, engine.ulp)


def exact_jacobians(scenario: Scenario, states: State, timesteps: FloatArray) -> FloatArray:
    """Return the Jacobians of the exact motion from K states over J timesteps, (J, K, 6, 6).

    Parameters
    ----------
    timesteps : s, long to short, (J,)
    """
    ascending = np.sort(timesteps)
    found = []
    for k in range(len(states.omega_body)):
        scene = started_at(scenario, **vars(states.rows(k)))
        (solution,) = solve_cheaply(scene, [ascending])
        derived = sensitivity(scene, solution.trajectory, of_start_alone=True)
        found.append(derived.state_transition[:, :, :CHART])
    return np.stack(found, axis=1)[::-1]


def own_jacobian(
    sessions: Sessions,
    state: State,
    timestep: float,
    units: Units,
    counts: Sequence[int],
    share: float = 1.0,
) -> FloatArray:
    """Return n Jacobians of an engine's own steps from a state, by central differences, (n, 6, 6).

    Their rows and columns are in rad and rad/s.

    Parameters
    ----------
    timestep : s
    units : units of the changes by which the differences are taken
    counts : numbers of steps, ascending, one for each Jacobian, (n,)
    share : size of these changes relative to `Units.change`, which is best if the derivatives are
        about one in `units`
    """
    sizes = share * units.change * units.each
    offsets = (CHANGES[:, None, None] * np.diag(sizes)).reshape(-1, CHART)
    begun = changed(sessions.scenario, state, np.vstack([np.zeros(CHART), offsets]))
    ended = []
    for k in range(len(begun.omega_body)):
        with sessions.at(begun.rows(k), timestep) as session:
            for more in np.diff(counts, prepend=0):
                if more:
                    session.advance(int(more))
                ended.append(session.snapshot())
    states, found = sessions.first.states(ended), []
    for n in range(len(counts)):
        q, omega_body = (
            column[n :: len(counts)] for column in (states.q_world_body_wxyz, states.omega_body)
        )
        turns = rotation_vectors(np.broadcast_to(q[0], q[1:].shape), q[1:])
        ends = np.hstack([turns, omega_body[1:] - omega_body[0]])
        summed = np.tensordot(WEIGHTS, ends.reshape(len(CHANGES), CHART, CHART), axes=1)
        found.append(summed.T / sizes)
    return np.array(found)


def changed(scenario: Scenario, state: State, offsets: FloatArray) -> State:
    """Return the n states that differ from a given state by offsets of attitude and ω.

    Com and velocity follow from the constraint. Those of a free body, and the spins, do not change.

    Parameters
    ----------
    offsets : changes of attitude and ω, rad and rad/s, (n, 6)
    """
    half = np.linalg.norm(offsets[:, :3], axis=1, keepdims=True) / 2
    turn = np.hstack([np.cos(half), np.sinc(half / np.pi) * offsets[:, :3] / 2])
    q = np.array([state.q_world_body_wxyz @ times(one) for one in turn])
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    constraint, R_world_body = scenario.constraint, matrices(q)
    omega_body = state.omega_body + offsets[:, 3:]
    swing_world = turned(R_world_body, cross(omega_body, np.array(constraint.lever)))
    count = len(offsets)
    com, velocity, spins = (
        np.tile(column, (count, 1))
        for column in (state.com_world, state.velocity_world, state.spins)
    )
    return State(
        q,
        omega_body,
        constraint.com_world(R_world_body @ constraint.lever, com),
        constraint.velocity_world(swing_world, velocity),
        spins,
    )


@dataclass(frozen=True, eq=False)
class Own:
    """Jacobians of an engine's own steps, by finite differences.

    Attributes
    ----------
    jacobians : from K states with J timesteps, (J, K, 6, 6)
    known_to : bound on the error of the Jacobians, in `Units`, for each timestep, (J,). It is the
        error by rounding, or, if that is larger, the difference from Jacobians for which the state
        is changed by another amount
    """

    jacobians: FloatArray
    known_to: FloatArray


def own_jacobians(
    sessions: Sessions, states: State, timesteps: FloatArray, units: Units, steps: int
) -> Own:
    """Return Jacobians from K states with J timesteps, by differences of an engine's own steps.

    Parameters
    ----------
    states : K states
    timesteps : s, (J,)
    units : units of the changes by which the differences are taken
    steps : number of steps that each Jacobian covers
    """
    found, finer = (
        np.array(
            [
                [
                    own_jacobian(sessions, states.rows(k), float(h), units, [steps], share)[0]
                    for k in range(len(states.omega_body))
                ]
                for h in timesteps
            ]
        )
        for share in (1.0, 0.5)
    )
    return Own(found, _error_bound(units, found, finer))


def settled_jacobians(
    sessions: Sessions, states: State, timesteps: FloatArray, units: Units, settling: Sequence[int]
) -> tuple[Own, FloatArray]:
    """Return Jacobians of a step after a constraint has settled, and the exact ones, (J, K, 6, 6).

    A run begins some steps earlier, in the exact state from which the motion leads to the given
    one. That earlier state is changed, as the constraint allows. The Jacobian of the step is the
    Jacobian of all steps times the inverse of the Jacobian of the earlier steps. Com and velocity
    must follow from attitude and ω.

    Parameters
    ----------
    states : K states
    timesteps : J timesteps, s, (J,)
    units : units of the changes by which the differences are taken
    settling : two numbers of earlier steps, ascending; the Jacobians with the second are returned,
        and their difference from those with the first bounds their error
    """
    found = np.empty((len(settling), len(timesteps), len(states.omega_body), CHART, CHART))
    exact = np.empty(found.shape[1:])
    for j, h in enumerate(map(float, timesteps)):
        for which, (count, share) in enumerate(zip(settling, (0.5, 1.0), strict=True)):
            spans = np.full(found.shape[2], -count * h)
            begun = flowed(sessions.scenario, states, spans)
            for k in range(found.shape[2]):
                pair = own_jacobian(sessions, begun.rows(k), h, units, [count, count + 1], share)
                found[which, j, k] = pair[1] @ np.linalg.inv(pair[0])
                with sessions.at(begun.rows(k), h) as session:
                    session.advance(count)
                    there = session.read_state()
                one = State(*(column[None] for column in there.columns))
                exact[j, k] = exact_jacobians(sessions.scenario, one, np.array([h]))[0, 0]
    # The longer one of the two runs is used; the exact Jacobians are from states that it reaches.
    return Own(found[-1], _error_bound(units, *found)), exact


def _error_bound(units: Units, found: FloatArray, other: FloatArray) -> FloatArray:
    """Return a bound on the error of Jacobians, in `units`, for each of J timesteps, (J,).

    The bound is their largest difference from others, but not less than the error by rounding.

    Parameters
    ----------
    found, other : the Jacobians from K states, and others with another error, (J, K, 6, 6)
    """
    apart = np.abs(units.of(found - other)).max(axis=(1, 2, 3))
    return np.asarray(np.maximum(apart, ULPS * units.ulp / units.change))


def stepped_by_rate(rate: FloatArray, omega_body: FloatArray, timestep: float) -> FloatArray:
    """Return the Jacobian of an explicit Euler step, (6, 6), given the derivative of dω/dt.

    A change δθ of the attitude, together with a change δω of ω, obeys δθ' = δω − ω × δθ.

    Parameters
    ----------
    rate : derivative of dω/dt by attitude and ω, (3, 6)
    omega_body : rad/s, (3,)
    timestep : s
    """
    x, y, z = omega_body
    spin = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(CHART) + timestep * np.vstack([np.hstack([-spin, np.eye(3)]), rate])
