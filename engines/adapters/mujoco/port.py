"""What ports of MuJoCo share: they take its compiled models, and its functions audit them."""

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
    model : at rest, with MuJoCo's names for its fields
    world : with `model` and `data()` as it holds them now, by MuJoCo's names, and `advance(steps)`,
        `motions(places)`: qpos and qvel of worlds, `restart(qpos, qvel)`, `set_timestep(timestep)`
    always_on : passes that cannot be switched off, by MuJoCo's names
    """

    def __init__(
        self, scenario: Scenario, model: Any, world: Any, always_on: Sequence[str]
    ) -> None:
        self._scenario, self._world, self._always_on = scenario, world, always_on
        self._coordinates = Coordinates(model, scenario)

    @property
    def can_restart(self) -> bool:
        """Always."""
        return True

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Whether a restart reproduces a run to the last bit.

        It does where MuJoCo moves the com, and not another point of the body.
        """
        return self._coordinates.restarts_to_the_last_bit

    def restart(self, state: State, timestep: float | None = None) -> None:
        """The data of the start with the coordinates of the state; nothing is compiled again."""
        if timestep is not None:
            self._world.set_timestep(timestep)
        self._world.restart(*self._coordinates.of(state))

    def read_body(self) -> BodyReading:
        """The body in the port's model."""
        return self._coordinates.read_body()

    def read_state(self) -> State:
        """The state now."""
        return self.states([self.snapshot()]).rows(0)

    def snapshot(self) -> FloatArray:
        """Coordinates qpos and velocities qvel now."""
        (numbers,) = self._world.motions([0])
        return np.asarray(numbers)

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        """The states, read from qpos and qvel alone."""
        rows = np.array(snapshots, dtype=float)
        return self._coordinates.states(*np.split(rows, [self._world.model.nq], axis=1))

    def advance(self, steps: int) -> None:
        """As the world does."""
        self._world.advance(steps)

    def check(self) -> None:
        """Nothing to do: no port warns or resets."""

    def active(self) -> frozenset[str]:
        """What acts, from the port's model and data; its passes that are always on do nothing."""
        names_acting = acting(self._world.model, self._world.data(), self._scenario)
        return names_acting - {FLAG_WORDS[name] for name in self._always_on}

    def close(self) -> None:
        """Drop model and data."""
        del self._world


def left_in(
    scenario: Scenario, integrator: str | None, always_on: tuple[str, ...]
) -> tuple[str, ...]:
    """The passes that stay on; all as shipped, where there is no integrator."""
    return switched_off(scenario) if integrator is None else always_on


def starts(scenarios: Sequence[Scenario]) -> tuple[FloatArray, FloatArray]:
    """qpos and qvel of many worlds, one a row."""
    at_start = {scenario: start_coordinates(scenario) for scenario in scenarios}
    qpos, qvel = zip(*(at_start[scenario] for scenario in scenarios), strict=True)
    return np.array(qpos), np.array(qvel)


def port_script(world: Path, scenario: Scenario, text: str, made: str) -> str:
    """A run as Python: the stand-alone module, the MJCF, and its steps.

    Parameters
    ----------
    made : lines that make `world` from `MJCF`, at `TIMESTEP` and `{qpos}` and `{qvel}`
    """
    qpos, qvel = start_coordinates(scenario)
    return _SCRIPT.format(
        world=stand_alone(world),
        lines=python_lines(text),
        made=made.format(qpos=qpos, qvel=qvel),
        moving=3 - sum(scenario.constraint.is_held),
    )
