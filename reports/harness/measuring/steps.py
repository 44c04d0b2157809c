"""Single steps of a method from given states, and their gains."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....engines import Batch, Engine, EngineError, Method, Session, State
from ....engines.checks.equations import Equations
from ....reference import flow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import decay_rate
from ....scenarios.rotation import norms, rotation_vectors
from ....scenarios.scenario import started_at
from ...results.records import LARGEST
from .places import states_of

#: The most states or intervals that are used where each takes long. Also the number of steps for
#: which a method, or the solver of a constraint, may remember an earlier state.
FEW = 8


@dataclass(frozen=True, eq=False)
class Sessions:
    """Sessions of a method on a scene, which can be set to any state and timestep.

    One session is kept and restarted, as opening a session takes as long as some hundred steps. If
    it cannot be restarted, another session is opened for each state.

    Attributes
    ----------
    first : the session that is kept
    batches : open batches, each of several copies of the scene, by the number of copies
    """

    engine: Engine
    method: Method
    scenario: Scenario
    first: Session
    batches: dict[int, Batch] = field(default_factory=dict)

    def open_at(self, scenario: Scenario, timestep: float) -> Session:
        """Open a further session of the method on a scene, with a timestep, s, and return it."""
        return self.engine.open(scenario, self.method, timestep)

    @contextmanager
    def at(self, state: State, timestep: float) -> Iterator[Session]:
        """Yield a session in a given state, with a timestep, s."""
        if self.first.can_restart:
            self.first.restart(state, timestep)
            yield self.first
            return
        with self.open_at(started_at(self.scenario, **vars(state)), timestep) as own:
            yield own

    def single_steps(
        self, states: State, timestep: float, settle: int
    ) -> tuple[Sequence[Any], Sequence[Any]]:
        """Return snapshots of an engine's state before and after a step from each of n states.

        Where an engine can, the steps are taken in one batch, which takes less time.

        Parameters
        ----------
        states : n states
        timestep : s
        settle : number of steps that are taken from each state before its first snapshot
        """
        count = len(states.omega_body)
        if not self.engine.restarts_batches or count == 1:
            pairs = [self._single_step(states.rows(k), timestep, settle) for k in range(count)]
            return [before for before, _ in pairs], [after for _, after in pairs]
        if count not in self.batches:
            scenes = [self.scenario] * count
            self.batches[count] = self.engine.open_batch(scenes, self.method, timestep)
        batch, places = self.batches[count], range(count)
        batch.restart(states, timestep)
        if settle:
            batch.advance(settle)
        before = batch.snapshots(places)
        batch.advance(1)
        return before, batch.snapshots(places)

    def _single_step(self, state: State, timestep: float, settle: int) -> tuple[Any, Any]:
        """Return snapshots of the engine's state before and after a step from a given state.

        Parameters
        ----------
        timestep : s
        settle : number of steps that are taken before the first snapshot
        """
        with self.at(state, timestep) as session:
            if settle:
                session.advance(settle)
            before = session.snapshot()
            session.advance(1)
            return before, session.snapshot()


@contextmanager
def sessions_of(
    engine: Engine, method: Method, scenario: Scenario, timestep: float
) -> Iterator[Sessions]:
    """Yield sessions of a method on a scene, and close them in the end.

    Parameters
    ----------
    timestep : timestep of the session that is opened first, s
    """
    with engine.open(scenario, method, timestep) as first:
        sessions = Sessions(engine, method, scenario, first)
        try:
            yield sessions
        finally:
            for batch in sessions.batches.values():
                batch.close()


@dataclass(frozen=True, eq=False)
class Steps:
    """States before and after steps, and the exact states that should be reached.

    The states have J R K rows: K states, repeated R times, with the first timestep; then the same
    with the next timestep, and so on.

    Attributes
    ----------
    timesteps : s, (J,)
    spans : time from before to after, s, (J R K,); for a single step the timestep
    before, after : the states before and after each step, as the engine gives them
    exact : the states to which the exact motion leads from those in `before`
    repeats : R, how often each state is repeated, with small changes
    """

    timesteps: FloatArray
    spans: FloatArray
    before: State
    after: State
    exact: State
    repeats: int = 1

    def by_timestep(self, rows: FloatArray) -> FloatArray:
        """Return the array `rows`, (J R K, …), with a row for each step, as (J, R, K, …).

        The new axes are those of J timesteps, R repeats and K states.
        """
        return rows.reshape(len(self.timesteps), self.repeats, -1, *rows.shape[1:])


def steps_from(
    sessions: Sessions, states: State, timesteps: FloatArray, settle: int = 0, repeats: int = 1
) -> Steps:
    """Take one step from each of R K states with each of J timesteps, and return these steps.

    Parameters
    ----------
    states : R K states
    timesteps : s, (J,)
    settle : number of steps, in which a constraint settles, before the step that counts. The first
        of them begins in an earlier exact state, from which the motion leads to the given state in
        the duration of these steps
    repeats : R

    Raises
    ------
    EngineError
        If the square of a component of a state is not finite, because of overflow.
    """
    scenario, count = sessions.scenario, len(states.omega_body)
    before, after = list[Any](), list[Any]()
    for timestep in map(float, timesteps):
        starts = _earlier(scenario, states, settle * timestep) if settle else states
        begun, ended = sessions.single_steps(starts, timestep, settle)
        before.extend(begun)
        after.extend(ended)
    befores, ends = sessions.first.states(before), sessions.first.states(after)
    if not np.abs(np.hstack([*befores.columns, *ends.columns])).max() <= LARGEST:
        raise EngineError("a step from an exact state ends in numbers whose squares overflow")
    spans = np.repeat(timesteps, count)
    return Steps(timesteps, spans, befores, ends, flowed(scenario, befores, spans), repeats)


def flowed(scenario: Scenario, states: State, spans: FloatArray) -> State:
    """Return the n states to which the exact motion leads from given states.

    Parameters
    ----------
    states : n states; their quaternions are normalised first
    spans : duration of each motion, s, (n,); it may be negative
    """
    lengths = norms(states.q_world_body_wxyz)[:, None]
    q = states.q_world_body_wxyz / lengths
    start = Trajectory(np.arange(float(len(spans))), q, *states.columns[1:])
    return states_of(flow(scenario, start, spans))


def _earlier(scenario: Scenario, states: State, span: float) -> State:
    """Return the n exact states from which the motion leads to given states in a given time.

    Runs that start there end in the given states whatever the timestep, up to the error of their
    steps. As a damped motion grows without bounds backwards in time, it is followed back for one
    time constant at most. A state is returned as it is if, in the earlier state, a one-sided
    constraint would have to pull.

    Parameters
    ----------
    span : s
    """
    decay = decay_rate(scenario)
    span = min(span, 1 / decay) if decay else span
    earlier = flowed(scenario, states, np.full(len(states.omega_body), -span))
    return Equations(scenario).bearable(earlier, states)


def step_gains(equations: Equations, steps: Steps) -> FloatArray:
    """Return the gains of steps: differences from the exact motion, per second.

    The shape is (J, R, K, Q, 3), for J timesteps, R repeats of K states, and Q quantities:
    attitude, rad/s, and I ω, N m, in body axes; velocity, m/s², and position of the com, m/s, in
    world axes; and, if there are rotors, their constant angular momenta about their axles, N m, or
    three projections of these if there are more than three rotors. For a body on a pivot, velocity
    and position are not gains: they are the differences of velocity, m/s, and com, m, from the
    values that ω and attitude demand.
    """
    spans, after, exact = steps.spans[:, None], steps.after, steps.exact
    attitude = rotation_vectors(exact.q_world_body_wxyz, after.q_world_body_wxyz) / spans
    torque = (after.omega_body - exact.omega_body) @ equations.scenario.inertia.T / spans
    if equations.scenario.constraint.is_pivot:
        velocity, position = off_the_constraint(equations, after)
    else:
        # The body may have sunk into a contact before the step, which is not part of the gain.
        off_velocity, off_position = off_the_constraint(equations, steps.before)
        velocity = (after.velocity_world - exact.velocity_world - off_velocity) / spans
        position = (after.com_world - exact.com_world - off_position) / spans
    gains = [attitude, torque, velocity, position]
    if after.spins.size:
        kept, wanted = (
            equations.scenario.kept(state.omega_body, state.spins) for state in (after, exact)
        )
        gains.append((kept - wanted) @ _directions(after.spins.shape[1]) / spans)
    return steps.by_timestep(np.stack(gains, axis=1))


def _directions(count: int) -> FloatArray:
    """Return a matrix, (count, 3), that projects momenta of rotors, (n, count), to three, (n, 3).

    For more than three rotors its columns are orthonormal. For three or fewer, each rotor has a
    column of its own, and the columns that remain are zero.
    """
    if count <= 3:
        return np.eye(count, 3)
    return np.linalg.qr(np.random.default_rng(count).standard_normal((count, 3)))[0]


def off_the_constraint(equations: Equations, states: State) -> tuple[FloatArray, FloatArray]:
    """Return by how much velocity, m/s, and com, m, of n states are off what a constraint demands.

    Both are along world axes, (n, 3). The constraint demands values that follow from attitude and
    ω, but only along the axes that it holds; along other axes the differences are 0.
    """
    on = equations.on_constraint(states)
    return states.velocity_world - on.velocity_world, states.com_world - on.com_world


def state_differences(
    states: State, others: State, reach: float, among: State | None = None
) -> FloatArray:
    """Return the differences of n states from n other states, (n, 5, 3).

    The five quantities are attitude, rad; ω, the com's velocity and the com's position, relative to
    their sizes; and spins, relative to their size, with the norm of the differences of all spins as
    the only component. A difference that is not a number is infinite.

    Parameters
    ----------
    reach : `Equations.reach`, m: a length that is added to the size of positions and, times the
        largest ‖ω‖, to the size of velocities
    among : states whose largest ω, velocity, position and spins are the sizes; the others if None
    """
    among = among or others
    speed = float(norms(among.omega_body).max()) or 1.0
    fast = float(norms(among.velocity_world).max()) + reach * speed
    far = float(norms(among.com_world).max()) + reach
    off = (
        rotation_vectors(others.q_world_body_wxyz, states.q_world_body_wxyz),
        (states.omega_body - others.omega_body) / speed,
        (states.velocity_world - others.velocity_world) / fast,
        (states.com_world - others.com_world) / far,
    )
    spins = np.zeros_like(states.omega_body)
    if states.spins.size:
        fastest = speed + float(np.abs(among.spins).max())
        spins[:, 0] = norms(states.spins - others.spins) / fastest
    return np.nan_to_num(np.stack([*off, spins], axis=1), nan=np.inf)
