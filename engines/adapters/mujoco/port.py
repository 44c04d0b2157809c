"""What ports of MuJoCo share: they run its compiled models, and its functions audit them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from spincheck.engine import BodyReading, FloatArray, Scenario, Session, State

from ...models.mjcf import start_coordinates, switched_off
from ...models.text import python_lines
from ...world_session import stand_alone
from .audit import FLAG_WORDS, acting
from .coordinates import Coordinates

_SCRIPT = """\
{world}

MJCF = (
{lines}
)
{made}


def step(count):
    world.advance(count)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    data = world.data()
    q, omega = data.qpos[{moving} : {moving} + 4], data.qvel[{moving} : {moving} + 3]
    return np.array(q, dtype=float), np.array(omega, dtype=float)
"""


class PortSession(Session):
    """One body and its rotors in a port of MuJoCo.

    Parameters
    ----------
    model : MuJoCo's compiled model, at rest
    world : holds `model` and `data()` as the port has them now, under MuJoCo's names, and has
        `advance(steps)`, `motions(places)`, which returns qpos and qvel of worlds,
        `restart(qpos, qvel)` and `set_timestep(timestep)`
    always_on : passes that the port cannot switch off, by MuJoCo's names
    """

    def __init__(
        self, scenario: Scenario, model: Any, world: Any, always_on: Sequence[str]
    ) -> None:
        self._scenario, self._world, self._always_on = scenario, world, always_on
        self._coordinates = Coordinates(model, scenario)

    @property
    def can_restart(self) -> bool:
        """True: a port's coordinates can be set at any time."""
        return True

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Whether a restart rounds nothing: on a pivot, or if the coordinates move the com."""
        return self._coordinates.restarts_to_the_last_bit

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the coordinates of the state in the data of the start; nothing is compiled again."""
        if timestep is not None:
            self._world.set_timestep(timestep)
        self._world.restart(*self._coordinates.of(state))

    def read_body(self) -> BodyReading:
        """Return the body in the port's model."""
        return self._coordinates.read_body()

    def read_state(self) -> State:
        """Return the state now."""
        return self.states([self.snapshot()]).rows(0)

    def snapshot(self) -> FloatArray:
        """Return coordinates qpos and velocities qvel now, in one row."""
        (numbers,) = self._world.motions([0])
        return np.asarray(numbers)

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        """Return the states of n snapshots, computed from qpos and qvel alone."""
        rows = np.array(snapshots, dtype=float)
        return self._coordinates.states(*np.split(rows, [self._world.model.nq], axis=1))

    def advance(self, steps: int) -> None:
        """Take steps as the world does."""
        self._world.advance(steps)

    def check(self) -> None:
        """Nothing to do: no port warns or resets."""

    def active(self) -> frozenset[str]:
        """Return what acts by the port's model and data, without the passes that are always on.

        Those passes do nothing in a scene that does not need them.
        """
        names_acting = acting(self._world.model, self._world.data(), self._scenario)
        return names_acting - {FLAG_WORDS[name] for name in self._always_on}

    def close(self) -> None:
        """Drop model and data."""
        del self._world


def left_in(
    scenario: Scenario, integrator: str | None, always_on: tuple[str, ...]
) -> tuple[str, ...]:
    """Return the passes that stay on without need: as shipped, without integrator, all."""
    return switched_off(scenario) if integrator is None else always_on


def starts(scenarios: Sequence[Scenario]) -> tuple[FloatArray, FloatArray]:
    """Return the starts of many worlds as qpos and as qvel, one a row."""
    at_start = {scenario: start_coordinates(scenario) for scenario in scenarios}
    qpos, qvel = zip(*(at_start[scenario] for scenario in scenarios), strict=True)
    return np.array(qpos), np.array(qvel)


def port_script(world: Path, scenario: Scenario, text: str, made: str) -> str:
    """Return a run as Python: the stand-alone module, the MJCF, and its steps.

    Parameters
    ----------
    world : path of the stand-alone module
    made : lines that make `world` from `MJCF`, at `TIMESTEP` and `{qpos}` and `{qvel}`
    """
    qpos, qvel = start_coordinates(scenario)
    return _SCRIPT.format(
        world=stand_alone(world),
        lines=python_lines(text),
        made=made.format(qpos=qpos, qvel=qvel),
        moving=3 - sum(scenario.constraint.is_held),
    )
