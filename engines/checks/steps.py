"""Single steps from exact states, and what they gain beyond the exact motion."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import numpy as np

from ...scenarios import FloatArray, Scenario
from ...scenarios.fastest_rate import decay_rate
from ...scenarios.rotation import matrices, rotation_vectors, turned
from ...scenarios.scenario import started_at
from ..session import Session
from .equations import Equations
from .read_back import EngineError, State

Open = Callable[[Scenario, float], AbstractContextManager[Session]]
#: The exact states a time after each of n states, s, (n,).
After = Callable[[State, FloatArray], State]


@dataclass(frozen=True, eq=False)
class Steps:
    """States before and after a step, and where the exact motion goes from those before.

    Each column has J R K rows: K states R times with the first timestep, then with the next.

    Attributes
    ----------
    timesteps : (J,) s
    repeats : R, of each state with small changes
    """

    timesteps: FloatArray
    before: State
    after: State
    exact: State
    repeats: int = 1

    @property
    def spans(self) -> FloatArray:
        """The timestep of each row, s, (J K,)."""
        return np.repeat(self.timesteps, len(self.before.omega_body) // len(self.timesteps))

    def part(self, first: int, beyond: int) -> "Steps":
        """The steps with some of the timesteps."""
        count = len(self.before.omega_body) // len(self.timesteps)
        rows = slice(first * count, beyond * count)
        before, after, exact = (each.rows(rows) for each in (self.before, self.after, self.exact))
        return Steps(self.timesteps[first:beyond], before, after, exact, self.repeats)


def single_steps(
    open_at: Open,
    scenario: Scenario,
    states: State,
    timesteps: FloatArray,
    after: After,
    settle: int = 0,
    repeats: int = 1,
) -> Steps:
    """Take one step from each of K states, or R K if repeated, with each of J timesteps.

    Parameters
    ----------
    settle : steps before that one, from where the exact motion was so long before each state

    Raises
    ------
    EngineError
        If a state is not finite, as where an engine's numbers overflow.
    """
    equations = Equations(scenario)
    before, later = [], []

    def take(session: Session) -> None:
        if settle:
            session.advance(settle)
        before.append(session.snapshot())
        session.advance(1)
        later.append(session.snapshot())

    with open_at(scenario, float(timesteps[0])) as first:
        for timestep in map(float, timesteps):
            earlier = _earlier(equations, states, after, settle * timestep)
            for k in range(_count(states)):
                if first.can_restart:
                    first.restart(earlier.rows(k), timestep)
                    take(first)
                    continue
                with open_at(started_at(scenario, **vars(earlier.rows(k))), timestep) as session:
                    take(session)
        befores, ends = first.states(before), first.states(later)
    if not all(np.isfinite(column).all() for column in (*befores.columns, *ends.columns)):
        raise EngineError("a step from an exact state ends in numbers that are not finite")
    exact = after(befores, np.repeat(timesteps, _count(states)))
    return Steps(timesteps, befores, ends, exact, repeats)


def _earlier(equations: Equations, states: State, after: After, span: float) -> State:
    """Where the exact motion was a time before each of n states, so that a run gets there.

    Runs with all timesteps then end in states that differ by the error of their steps alone. A
    motion that is slowed came from beyond all bounds, and is followed back for a time of decay at
    most; from where nothing can hold the body a run does not start.
    """
    decay = decay_rate(equations.scenario)
    span = min(span, 1 / decay) if decay else span
    if not span:
        return states
    earlier = after(states, np.full(_count(states), -span))
    bears = equations.bears(earlier)[:, None]
    pairs = zip(vars(earlier).values(), vars(states).values(), strict=True)
    return State(*(np.where(bears, came, column) for came, column in pairs))


def step_gains(equations: Equations, steps: Steps) -> FloatArray:
    """What each step gains beyond the exact motion, a second, (J, K, 4, 3)."""
    spans, after, exact = steps.spans[:, None], steps.after, steps.exact
    shape = (len(steps.timesteps), -1, 4, 3)
    attitude = rotation_vectors(exact.q_world_body_wxyz, after.q_world_body_wxyz) / spans
    torque = (after.omega_body - exact.omega_body) @ equations.inertia.T / spans
    if equations.scenario.constraint.is_pivot:
        velocity, place = off_the_constraint(equations, after)
    else:
        # A contact lets a body sink in: that is not a step's doing, and the exact motion has none.
        off_velocity, off_place = off_the_constraint(equations, steps.before)
        velocity = (after.velocity_world - exact.velocity_world - off_velocity) / spans
        place = (after.com_world - exact.com_world - off_place) / spans
    return np.stack([attitude, torque, velocity, place], axis=1).reshape(shape)


def off_the_constraint(equations: Equations, states: State) -> tuple[FloatArray, FloatArray]:
    """How far velocity, m/s, and com, m, are from where ω and attitude put them, (n, 3) each."""
    constraint = equations.scenario.constraint
    R_world_body = matrices(states.q_world_body_wxyz)
    swing_world = turned(R_world_body, np.cross(states.omega_body, constraint.lever))
    lever_world = R_world_body @ constraint.lever
    return (
        states.velocity_world - constraint.velocity_world(swing_world, states.velocity_world),
        states.com_world - constraint.com_world(lever_world, states.com_world),
    )


def _count(states: State) -> int:
    return len(states.omega_body)
