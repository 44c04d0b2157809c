"""Exact states along a motion that a method is tested from, one step and short pieces at a time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engines.checks.equation_residuals import ASKEW
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import State, stacked
from ....reference import Solution, flow
from ....scenarios import (
    Errors,
    FloatArray,
    Scenario,
    Trajectory,
    angular_momentum_world,
    signals_of,
)
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.rotation import (
    cross,
    matrices,
    matrix,
    norms,
    rotation_vectors,
    times,
    turned,
    turned_back,
)
from ..ladder import COARSEST_TURN

#: States spread over the window, beside those where something is largest or least.
SPREAD = 12
#: Timesteps of single steps, each half of the one before.
HALVINGS = 10
#: Pieces, and the coarsest steps of each: two radians at the ladder's coarsest timestep.
PIECES, PIECE_STEPS, SAMPLE_EVERY = 8, 10, 2
#: rad, and relative to the spin, by which the repeats of a state differ: of a step's change of
#: state they alter many ulps in single precision, and little of the step's error.
NUDGE = 2.0**-7
#: Relative rounding of the exact flow.
FLOW_ROUNDING = 64 * float(np.finfo(float).eps)
#: Ulps of a step: what its rounding is taken to be at most, in a body whose moments are alike.
ULPS_A_STEP = 16
#: What an ulp in the start grows to over a piece, in ulp, for a body whose moments are alike.
PIECE_GROWTH = 16


@dataclass(frozen=True, eq=False)
class Places:
    """Exact states of a scene, and pieces of its motion.

    Attributes
    ----------
    states : K of them
    times : s, of the states; nan where a state is not of the motion, (K,)
    timesteps : s, of single steps, (HALVINGS,)
    pieces : the exact motion of all pieces, one after the other
    starts : which state each piece starts from
    condition : of the tensor of inertia about the fixed point: what relative rounding grows by in
        angular acceleration
    finer : halvings of the timesteps after the pieces were chosen
    """

    states: State
    times: FloatArray
    timesteps: FloatArray
    pieces: Solution
    starts: NDArray[np.intp]
    condition: float
    finer: int = 0

    def repeated(self, scenario: Scenario, repeats: int) -> State:
        """All states so many times over, each time with every number a little otherwise."""
        if repeats == 1:
            return self.states
        chance = np.random.default_rng(repeats)
        copies = [_nudged(scenario, self.states, chance) for _ in range(repeats)]
        return stacked(copies)


def places(scenario: Scenario, motion: Trajectory, coarsest: float | None) -> Places:
    """Choose them along the exact motion.

    Parameters
    ----------
    coarsest : s, the ladder's coarsest timestep; None if the motion has no ladder
    """
    chosen = _chosen(scenario, motion)
    rate = fastest_rate(scenario, motion.omega_body) or 1 / scenario.window.duration
    timestep = coarsest or COARSEST_TURN / rate
    along = motion.at(chosen)
    speed = float(norms(motion.omega_body).max()) or rate
    parts = [states_of(along), *(_askew(scenario, along, speed * np.array(d)) for d in ASKEW)]
    states = stacked(parts)
    bears = Equations(scenario).bears(states)
    states, times = states.rows(bears), np.append(along.t, [np.nan] * len(ASKEW))[bears]
    starts = np.unique(np.linspace(0, len(chosen) - 1, PIECES).astype(int))
    condition = float(np.linalg.cond(scenario.inertia)) + _of_parts(scenario, motion)
    spans = np.asarray(timestep * np.arange(0, PIECE_STEPS + 1, SAMPLE_EVERY), dtype=float)
    followed = _followed(scenario, states.rows(starts), spans)
    is_borne = np.all(Equations(scenario).bears(followed).reshape(len(starts), -1), axis=1)
    # The window has as many steps: from its start a piece ends before the body leaves its table.
    is_borne |= starts == starts[0]
    borne = followed.rows(np.repeat(is_borne, len(spans)))
    pieces = _pieces(scenario, borne, timestep, condition)
    starts = starts[is_borne]
    timesteps = timestep / 2.0 ** np.arange(HALVINGS)
    return Places(states, times, np.asarray(timesteps), pieces, starts, condition)


def _nudged(scenario: Scenario, states: State, chance: np.random.Generator) -> State:
    """The states, each number a little otherwise, where what holds the body can hold it."""
    turn, spin, thrown, put = NUDGE * chance.standard_normal((4, 3))
    q = states.q_world_body_wxyz @ times(np.append(1.0, turn / 2) / np.sqrt(1 + turn @ turn / 4))
    omega_body = _changed(states.omega_body, spin)
    constraint, R_world_body = scenario.constraint, matrices(q)
    swing_world = turned(R_world_body, cross(omega_body, np.array(constraint.lever)))
    nudged = State(
        q,
        omega_body,
        constraint.com_world(R_world_body @ constraint.lever, _changed(states.com_world, put)),
        constraint.velocity_world(swing_world, _changed(states.velocity_world, thrown)),
        states.spins,
    )
    bears = Equations(scenario).bears(nudged)[:, None]
    pairs = zip(nudged.columns, states.columns, strict=True)
    return State(*(np.where(bears, changed, column) for changed, column in pairs))


def _changed(vectors: FloatArray, by: FloatArray) -> FloatArray:
    """Rows, changed by so much relative to their norms."""
    return np.asarray(vectors + norms(vectors)[:, None] * by)


def _of_parts(scenario: Scenario, motion: Trajectory) -> float:
    """Torques that cancel in coordinates which turn with parts, over the gyroscopic one."""
    _, torque = scenario.cancelling(motion.spins)
    L_world, speed = angular_momentum_world(scenario, motion), norms(motion.omega_body).max()
    gyroscopic = float(norms(L_world).max() * speed)
    return float(torque.max()) / gyroscopic if gyroscopic else 0.0


def rounding_of_body(condition: float, ulp: float = float(np.finfo(float).eps)) -> float:
    """What rounding of its moments changes of a body's angular acceleration, relative."""
    return ULPS_A_STEP * ulp * condition


def flowed(scenario: Scenario, states: State, spans: FloatArray) -> State:
    """The exact states a time after each of n states, s, (n,)."""
    lengths = norms(states.q_world_body_wxyz)[:, None]
    q = states.q_world_body_wxyz / lengths
    start = Trajectory(np.arange(float(len(spans))), q, *states.columns[1:])
    return states_of(flow(scenario, start, spans))


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


def _askew(scenario: Scenario, along: Trajectory, omega_body: FloatArray) -> State:
    """The first state, with another ω."""
    q, com_world = along.q_world_body_wxyz[0], along.com_world[0]
    constraint = scenario.constraint
    swing_world = matrix(q) @ cross(omega_body, constraint.lever)
    velocity_world = constraint.velocity_world(swing_world, along.velocity_world[0])
    rows = q, omega_body, com_world, velocity_world, along.spins[0]
    return State(*(row[None] for row in rows))


def _followed(scenario: Scenario, starts: State, spans: FloatArray) -> State:
    """The exact states of all pieces, one after the other, a time after each start, s, (n,)."""
    from_starts = State(*(np.repeat(column, len(spans), axis=0) for column in starts.columns))
    return flowed(scenario, from_starts, np.tile(spans, len(starts.omega_body)))


def _pieces(scenario: Scenario, states: State, timestep: float, condition: float) -> Solution:
    """The exact motion of all pieces, sampled at every few coarsest steps."""
    count = len(states.omega_body)
    times = np.asarray(np.arange(count) * (timestep * SAMPLE_EVERY), dtype=float)
    names = [signal.name for signal in signals_of(scenario)]
    growth = PIECE_GROWTH * condition * float(np.finfo(float).eps)
    return Solution(
        Trajectory(times, *states.columns),
        "the exact flow",
        uncertainty=Errors(**dict.fromkeys(names, FLOW_ROUNDING)),
        conditioning=Errors(**dict.fromkeys(names, growth)),
    )


def states_of(motion: Trajectory) -> State:
    """The states of a motion's samples."""
    return State(*(getattr(motion, name) for name in State.__dataclass_fields__))


def apart(states: State, others: State) -> FloatArray:
    """The larger of the distances in ω, relative, and in attitude, rad, (n,)."""
    speed = float(norms(others.omega_body).max()) or 1.0
    omega = norms(states.omega_body - others.omega_body) / speed
    turns = rotation_vectors(states.q_world_body_wxyz, others.q_world_body_wxyz)
    return np.maximum(omega, norms(turns))
