"""Single steps of a method from given states, and what they gain beyond the exact motion."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ....engines import Engine, EngineError, Method, Session, State
from ....engines.checks.equations import Equations
from ....reference import flow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import decay_rate
from ....scenarios.rotation import norms, rotation_vectors
from ....scenarios.scenario import started_at
from ...results.records import LARGEST
from .places import states_of

#: A few: states or intervals at most, where each takes long; and steps in which a method, or the
#: solver of a constraint, may still remember a state.
FEW = 8


@dataclass(frozen=True, eq=False)
class Sessions:
    """Sessions of a method on a scene, which are set to a state.

    One is kept and restarted, as opening one takes as long as some hundred steps. Where it cannot
    be restarted one is opened for each state.

    Attributes
    ----------
    first : the one that is kept
    """

    engine: Engine
    method: Method
    scenario: Scenario
    first: Session

    def open_at(self, scenario: Scenario, timestep: float) -> Session:
        """A further session on a scene, with a timestep, s."""
        return self.engine.open(scenario, self.method, timestep)

    @contextmanager
    def at(self, state: State, timestep: float) -> Iterator[Session]:
        """A session that is set to a state, with a timestep, s."""
        if self.first.can_restart:
            self.first.restart(state, timestep)
            yield self.first
            return
        with self.open_at(started_at(self.scenario, **vars(state)), timestep) as own:
            yield own


@contextmanager
def sessions_of(
    engine: Engine, method: Method, scenario: Scenario, timestep: float
) -> Iterator[Sessions]:
    """Sessions of a method, the first of them with a timestep, s."""
    with engine.open(scenario, method, timestep) as first:
        yield Sessions(engine, method, scenario, first)


@dataclass(frozen=True, eq=False)
class Steps:
    """States before and after a step, and where the exact motion goes from those before.

    Each column has J R K rows: K states R times with the first timestep, then with the next.

    Attributes
    ----------
    timesteps : (J,) s
    spans : from before to after, s, (J R K,); of a single step the timestep
    repeats : R, of each state with small changes
    """

    timesteps: FloatArray
    spans: FloatArray
    before: State
    after: State
    exact: State
    repeats: int = 1

    def by_timestep(self, rows: FloatArray) -> FloatArray:
        """Values of all rows, (J R K, …), by timestep, repeat and state, (J, R, K, …)."""
        return rows.reshape(len(self.timesteps), self.repeats, -1, *rows.shape[1:])


def steps_from(
    sessions: Sessions, states: State, timesteps: FloatArray, settle: int = 0, repeats: int = 1
) -> Steps:
    """Take one step from each of R K states with each of J timesteps.

    Parameters
    ----------
    settle : steps before that one, from where the exact motion was so long before each state

    Raises
    ------
    EngineError
        If squares of a state are not finite, as where an engine's numbers overflow.
    """
    scenario, count = sessions.scenario, len(states.omega_body)
    before, after, starts = [], [], [states.rows(k) for k in range(count)]
    for timestep in map(float, timesteps):
        if settle:
            earlier = _earlier(scenario, states, settle * timestep)
            starts = [earlier.rows(k) for k in range(count)]
        for start in starts:
            with sessions.at(start, timestep) as session:
                if settle:
                    session.advance(settle)
                before.append(session.snapshot())
                session.advance(1)
                after.append(session.snapshot())
    befores, ends = sessions.first.states(before), sessions.first.states(after)
    if not np.abs(np.hstack([*befores.columns, *ends.columns])).max() <= LARGEST:
        raise EngineError("a step from an exact state ends in numbers whose squares overflow")
    spans = np.repeat(timesteps, count)
    return Steps(timesteps, spans, befores, ends, flowed(scenario, befores, spans), repeats)


def flowed(scenario: Scenario, states: State, spans: FloatArray) -> State:
    """The exact states that n states move to in given times.

    Parameters
    ----------
    spans : s, (n,)
    """
    lengths = norms(states.q_world_body_wxyz)[:, None]
    q = states.q_world_body_wxyz / lengths
    start = Trajectory(np.arange(float(len(spans))), q, *states.columns[1:])
    return states_of(flow(scenario, start, spans))


def _earlier(scenario: Scenario, states: State, span: float) -> State:
    """The exact states so long before each of n states that a run from there leads to these.

    So runs with different timesteps lead to the same states, up to the error of their steps. As a
    damped motion grows without bounds backwards in time, it is followed back for one time constant
    at most. A state remains as it is if the body could not be held in the earlier one.
    """
    decay = decay_rate(scenario)
    span = min(span, 1 / decay) if decay else span
    earlier = flowed(scenario, states, np.full(len(states.omega_body), -span))
    return Equations(scenario).bearable(earlier, states)


def step_gains(equations: Equations, steps: Steps) -> FloatArray:
    """What each step gains beyond the exact motion, a second, (J, R, K, Q, 3).

    The quantities are: of the attitude rad/s and of I ω N m, body axes; of a free body's velocity
    m/s² and place m/s, world axes; of a body on a pivot how far velocity (m/s) and com (m) are from
    where ω and attitude put them; and of parts that turn in the body the momentum that they keep,
    N m (of more than three parts, in three directions).
    """
    spans, after, exact = steps.spans[:, None], steps.after, steps.exact
    attitude = rotation_vectors(exact.q_world_body_wxyz, after.q_world_body_wxyz) / spans
    torque = (after.omega_body - exact.omega_body) @ equations.scenario.inertia.T / spans
    if equations.scenario.constraint.is_pivot:
        velocity, place = off_the_constraint(equations, after)
    else:
        # The body may have sunk into a contact before the step, which is no gain of the step.
        off_velocity, off_place = off_the_constraint(equations, steps.before)
        velocity = (after.velocity_world - exact.velocity_world - off_velocity) / spans
        place = (after.com_world - exact.com_world - off_place) / spans
    gains = [attitude, torque, velocity, place]
    if after.spins.size:
        kept, wanted = (
            equations.scenario.kept(state.omega_body, state.spins) for state in (after, exact)
        )
        gains.append((kept - wanted) @ _directions(after.spins.shape[1]) / spans)
    return steps.by_timestep(np.stack(gains, axis=1))


def _directions(parts: int) -> FloatArray:
    """Orthonormal directions, (parts, 3), onto which the momenta of all parts are projected.

    Each part has a direction of its own if there are three or fewer.
    """
    if parts <= 3:
        return np.eye(parts, 3)
    return np.linalg.qr(np.random.default_rng(parts).standard_normal((parts, 3)))[0]


def off_the_constraint(equations: Equations, states: State) -> tuple[FloatArray, FloatArray]:
    """How far velocity, m/s, and com, m, are from what ω and attitude demand, (n, 3) each."""
    on = equations.on_constraint(states)
    return states.velocity_world - on.velocity_world, states.com_world - on.com_world


def state_differences(
    states: State, others: State, reach: float, among: State | None = None
) -> FloatArray:
    """How far states are from others, (n, 5, 3).

    The quantities are attitude, rad; ω, the com's velocity and the com, relative to their sizes;
    and in the first component of the last the spins of all parts, relative likewise. They are
    infinite where numbers are not finite.

    Parameters
    ----------
    reach : m, from the point that is held to the com, or the radius of gyration
    among : states that they are relative to the largest sizes of; the others if None
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
