"""Jacobians of single steps by attitude and ω: the exact motion's, and an engine's steps'.

Rows and columns: attitude (3, rad), ω (3, rad/s), body axes: docs/explanation/sensitivities.md.
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

#: Changes that a central difference of fourth order is taken with, and the weights of what they
#: make (Fornberg, Math. Comp. 51 (1988) 699, table 1).
CHANGES, WEIGHTS = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12
#: Numbers of a state in the chart, of which the first three are the attitude's.
CHART = 6


@dataclass(frozen=True)
class Units:
    """What a change of each number of the chart is measured in.

    Attributes
    ----------
    rate : rad/s, of ω; of the attitude it is 1 rad
    ulp : of the numbers of an engine's state, relative
    """

    rate: float
    ulp: float

    @property
    def each(self) -> FloatArray:
        """The unit of each number, (6,)."""
        return np.repeat([1.0, self.rate], 3)

    @property
    def change(self) -> float:
        """The step of fourth-order differences at which rounding and truncation are equal."""
        return float(self.ulp**0.2)

    def of(self, jacobians: FloatArray) -> FloatArray:
        """Jacobians, (..., 6, 6), in these units."""
        return np.asarray(jacobians / self.each[:, None] * self.each)


def units_of(engine: Engine, rate: float) -> Units:
    """The units of an engine and a motion whose fastest rate is given, rad/s."""
    return Units(rate, engine.ulp)


def exact_jacobians(scenario: Scenario, states: State, timesteps: FloatArray) -> FloatArray:
    """Jacobians of the exact motion from K states over J timesteps, (J, K, 6, 6)."""
    ascending = np.sort(timesteps)
    found = []
    for k in range(len(states.omega_body)):
        scene = started_at(scenario, **vars(states.rows(k)))
        (solution,) = solve_cheaply(scene, [ascending])
        found.append(sensitivity(scene, solution.trajectory).state_transition[:, :, :CHART])
    return np.stack(found, axis=1)[::-1]


def own_jacobian(
    sessions: Sessions,
    state: State,
    timestep: float,
    units: Units,
    counts: Sequence[int],
    share: float = 1.0,
) -> FloatArray:
    """Jacobians of an engine's own steps from a state, by central differences, (n, 6, 6).

    Parameters
    ----------
    counts : of steps, ascending, one a Jacobian
    share : of the change that is best where derivatives are of the size of the units
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
    """States that are off one by so much in attitude and ω, (n, 6), as what holds the body has it.

    Of a body that is free com and velocity stay.
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
    """Jacobians of an engine's own steps, by differences of them.

    Attributes
    ----------
    jacobians : from K states with J timesteps, (J, K, 6, 6)
    known_to : in units, for each timestep, (J,): what rounding makes, or half the change does
    """

    jacobians: FloatArray
    known_to: FloatArray


def own_jacobians(
    sessions: Sessions, states: State, timesteps: FloatArray, units: Units, steps: int
) -> Own:
    """Jacobians of an engine's own steps from K states, by differences of two step sizes."""
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
    return Own(found, _apart(units, found, finer))


def settled_jacobians(
    sessions: Sessions, states: State, timesteps: FloatArray, units: Units, settling: Sequence[int]
) -> tuple[Own, FloatArray]:
    """Jacobians of a step after a constraint has settled, and the exact ones, (J, K, 6, 6).

    A run begins where the exact motion was so many steps before. Its states are changed there, as
    the constraint allows, so that what the step makes of a change is what it and all steps before
    make, divided by what these do. Only attitude and ω may be free; all else follows them.

    Parameters
    ----------
    settling : two numbers of steps, which what is left of settling is the difference of
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
    # The last ones settled longest; the exact ones are from where these did.
    return Own(found[-1], _apart(units, *found)), exact


def _apart(units: Units, found: FloatArray, other: FloatArray) -> FloatArray:
    """What Jacobians are known to by their distance from others, (J,)."""
    apart = np.abs(units.of(found - other)).max(axis=(1, 2, 3))
    return np.asarray(np.maximum(apart, ULPS * units.ulp / units.change))


def stepped_by_rate(rate: FloatArray, omega_body: FloatArray, timestep: float) -> FloatArray:
    """The Jacobian of an explicit Euler step, (6, 6), from that of dω/dt, (3, 6).

    The turn obeys δθ' = δω − ω × δθ.
    """
    x, y, z = omega_body
    spin = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(CHART) + timestep * np.vstack([np.hstack([-spin, np.eye(3)]), rate])
