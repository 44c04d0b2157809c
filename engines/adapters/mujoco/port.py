"""What the adapters of MuJoCo's ports, MJX and MuJoCo Warp, share: session, batch and scripts.

The ports run models that MuJoCo compiles. Their models and data have MuJoCo's field names, so that
the functions in `audit.py` read them.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

import numpy as np
from spincheck.engine import FloatArray, Scenario, State

from ...models.mjcf import start_coordinates, switched_off
from ...models.text import python_text
from ...world_session import WorldBatch, run_script
from .audit import FLAG_WORDS, acting
from .coordinates import CoordinateSession

#: Lines that return a port's state; attitude and ω begin at index {0} of qpos and of qvel.
_STATE = """\
data = world.data()
q, omega = data.qpos[{0} : {0} + 4], data.qvel[{0} : {0} + 3]
return np.array(q, dtype=float), np.array(omega, dtype=float)"""


class PortSession(CoordinateSession):
    """A session of one body and its rotors in a port of MuJoCo.

    Parameters
    ----------
    model : a compiled model of the scene, with MuJoCo's field names
    world : an object with the port's present `model` and `data()`, both with MuJoCo's field names.
        Its other methods are `advance(steps)`, `restart(qpos, qvel)`, `set_timestep(timestep)`, and
        `motions(places)`, which returns qpos and qvel, a row for each world whose index is in
        `places`
    always_on : MuJoCo's names of passes (parts of a step) that the port cannot switch off
    """

    def __init__(
        self, scenario: Scenario, model: Any, world: Any, always_on: Sequence[str]
    ) -> None:
        super().__init__(scenario, model)
        self._world, self._always_on = world, always_on

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and the timestep, s, if one is given (`Session.restart`)."""
        if timestep is not None:
            self._world.set_timestep(timestep)
        self._world.restart(*self.coordinates(state))

    def snapshot(self) -> FloatArray:
        """Return the present coordinates qpos and velocities qvel in one array, (nq + nv,)."""
        (numbers,) = self._world.motions([0])
        return np.asarray(numbers)

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        """Return the states of n snapshots, computed from qpos and qvel alone."""
        rows = np.array(snapshots, dtype=float)
        return self.states_at(*np.split(rows, [self._world.model.nq], axis=1))

    def advance(self, steps: int) -> None:
        """Let the world take `steps` steps."""
        self._world.advance(steps)

    def check(self) -> None:
        """Do nothing: MuJoCo's ports neither warn nor reset the state."""

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the port. Passes (parts of a step) that the port cannot switch off are
        left out: they do nothing in a scene that does not need them.
        """
        names_acting = acting(self._world.model, self._world.data(), self._scenario)
        return names_acting - {FLAG_WORDS[name] for name in self._always_on}

    def close(self) -> None:
        """Drop model and data."""
        del self._world


@final
class PortBatch(WorldBatch):
    """A batch, in a port of MuJoCo, of worlds with the same body; it can be restarted.

    Parameters
    ----------
    session : a session of the first world, which converts states to coordinates
    worlds : an object with the methods of `world` in `PortSession`; its `restart` takes qpos and
        qvel with a row for each world
    device : name of the device that steps the worlds: "CPU", or the name of a GPU
    """

    def __init__(self, session: PortSession, worlds: Any, device: str) -> None:
        super().__init__(worlds, device)
        self._session = session

    def restart(self, states: State, timestep: float) -> None:
        """Set each world to its row of `states`, and the timestep, s (`Batch.restart`)."""
        count = len(states.omega_body)
        rows = [self._session.coordinates(states.rows(k)) for k in range(count)]
        self._worlds.set_timestep(timestep)
        self._worlds.restart(*map(np.array, zip(*rows, strict=True)))

    def close(self) -> None:
        """Drop model and data."""
        self._session.close()
        super().close()


def left_in(
    scenario: Scenario, integrator: str | None, always_on: tuple[str, ...]
) -> tuple[str, ...]:
    """Return MuJoCo's names of the parts of a step that stay on though the scene needs none.

    Parameters
    ----------
    integrator : MuJoCo's name of the integrator; None for a port as shipped, in which all parts
        stay on
    always_on : parts that the port cannot switch off, which stay on in any other method
    """
    return switched_off(scenario) if integrator is None else always_on


def starts(scenarios: Sequence[Scenario]) -> tuple[FloatArray, FloatArray]:
    """Return the starts of n worlds: coordinates qpos, (n, nq), and velocities qvel, (n, nv)."""
    at_start = {scenario: start_coordinates(scenario) for scenario in scenarios}
    qpos, qvel = zip(*(at_start[scenario] for scenario in scenarios), strict=True)
    return np.array(qpos), np.array(qvel)


def port_script(world: Path, scenario: Scenario, text: str, made: str) -> str:
    """Return a Python script of a run: the stand-alone module, the MJCF and the steps.

    Parameters
    ----------
    world : path of the stand-alone module
    text : the MJCF
    made : lines of Python that make `world` from `MJCF` and `TIMESTEP`; `{qpos}` and `{qvel}` in
        them are replaced by the coordinates and velocities of the start
    """
    qpos, qvel = start_coordinates(scenario)
    made = f"{python_text('MJCF', text)}\n{made.format(qpos=qpos, qvel=qvel)}"
    return run_script(world, made, _STATE.format(3 - sum(scenario.constraint.is_held)))
