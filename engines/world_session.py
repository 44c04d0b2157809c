"""A scene in a world of an adapter's stand-alone module, which scripts contain whole."""

import ast
import inspect
import re
from abc import abstractmethod
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
from spincheck.engine import Batch, BodyReading, EngineError, FloatArray, Scenario, Session, State

from ..scenarios.effects.push import is_pushed, push
from .scene_record import ABOUT, RecordFrame, WorldBody, scene_record
from .world_parts import matrix

#: Effects whose torques act on a body at rest.
TORQUES = frozenset({"torque_body", "torque_world"})
#: Bound on the relative rounding error of a torque that was rotated twice.
SLACK = 16 * float(np.finfo(float).eps)
#: Path of the module with the functions that worlds share.
PARTS = Path(__file__).with_name("world_parts.py")
_STATE = """\
motion = np.array(world.motion())
q = product(motion[:4] / np.linalg.norm(motion[:4]), conjugate(np.array(SCENE["axes"])))
return q, turned(conjugate(q), motion[4:7])"""
_RELATIVE_IMPORT = re.compile(r"^from \.[\w.]* import .+\n", re.MULTILINE)


class WorldSession(Session):
    """A session of one body in a world; adapters implement `world_body` and `active`.

    Parameters
    ----------
    module : name of the adapter's stand-alone module, which imports the engine. It defines a class
        `World(scene, method, timestep)`, which takes the scene as a record. Its method
        `advance(steps)` steps; `motion()` returns `q`, `omega`, `com`, `velocity` and `spins` of a
        record as one array, (13 + rotors,); and `restart(motion, timestep)` sets a motion, a dict
        with these names
    method : name of the method
    timestep : length of the steps, s
    """

    def __init__(self, module: str, scenario: Scenario, method: str, timestep: float) -> None:
        self.module = import_module(module)
        self.scenario, self.timestep = scenario, timestep
        self.scene, self.frame = scene_record(scenario), RecordFrame.of(scenario)
        self.world: Any = self.module.World(self.scene, method, timestep)

    @abstractmethod
    def world_body(self) -> WorldBody:
        """Return the body as the engine holds it, with vectors along the scene record's axes."""

    @property
    def can_restart(self) -> bool:
        """True: a world can be set to any motion."""
        return True

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and the timestep, s, if one is given (`Session.restart`)."""
        self.timestep = self.timestep if timestep is None else timestep
        self.world.restart(self.frame.motion(state), self.timestep)

    def damped_by(self, damping: Sequence[float]) -> dict[str, bool]:
        """Return a dict with one entry: a name of a joint's damping, and whether it is not zero.

        The name is "drag" if the damping is the scene's drag, else it states the coefficients.

        Parameters
        ----------
        damping : the damping coefficients of the joint's coordinates, N m s: three of rotations,
            then any of translations, which should be zero
        """
        wanted = [self.scene["drag"]] * 3 + [0.0] * (len(damping) - 3)
        name = "drag" if list(damping) == wanted else f"a joint damping of {damping} N m s"
        return {name: any(damping)}

    def gravity_by(self, vector: FloatArray) -> dict[str, bool]:
        """Return the audit's entry for gravity: its name, and whether it is not zero.

        The name is "gravity" if the gravity is that of the scene, else it states the vector.

        Parameters
        ----------
        vector : the gravity that the engine applies, m/s², world axes, (3,)
        """
        right = np.array_equal(vector, self.scenario.gravity_world)
        return {"gravity" if right else f"a gravity of {vector.tolist()} m/s²": bool(vector.any())}

    def pushed_by(self, torque: FloatArray) -> dict[str, bool]:
        """Return names of torques, each with whether it acts on the body at its present attitude.

        The names are those of the scene's torques, which all count as acting if `torque` is not
        zero. One more name states `torque`, and counts as acting if `torque` is not their sum.

        Parameters
        ----------
        torque : the torque that the engine would apply to the body at rest, N m, world axes, (3,)
        """
        wanted = push(self.scene, matrix(self.world.motion()[:4]), np.zeros(3))
        pushes = np.linalg.norm(torque - wanted) <= SLACK * np.linalg.norm(wanted)
        acting = dict.fromkeys(self.scenario.called_for & TORQUES, bool(torque.any()))
        return acting | {f"a torque of {torque.tolist()} N m": not bool(pushes)}

    def read_body(self) -> BodyReading:
        """Return the body as the engine holds it, in the axes and origin of the scene's body."""
        return self.frame.body(self.world_body())

    def read_state(self) -> State:
        """Return the state after the last step, in the scene's body axes."""
        return self.states([self.snapshot()]).rows(0)

    def snapshot(self) -> Sequence[float]:
        """Return `q`, `omega`, `com`, `velocity` and `spins` in one array, (13 + rotors,).

        They are entries of a scene record for the present state: `q` is the attitude of the
        record's axes, and vectors are along world axes. `EngineError` is raised if the engine
        reports trouble, or if a number is not finite.
        """
        self.check()
        motion: Sequence[float] = self.world.motion()
        if not np.isfinite(motion).all():
            raise EngineError("the state is no longer finite", "not-finite")
        return motion

    def states(self, snapshots: Sequence[Any]) -> State:
        """Return the states of n snapshots, in the scene's body axes."""
        return self.frame.states(np.array(snapshots, dtype=float))

    def advance(self, steps: int) -> None:
        """Let the world take `steps` steps."""
        self.world.advance(steps)

    def check(self) -> None:
        """Do nothing: only a state that is not finite is an error, and `snapshot` raises it."""

    def close(self) -> None:
        """Drop the world."""
        del self.world


class WorldBatch(Batch):
    """A batch of worlds that a stand-alone module steps together.

    Parameters
    ----------
    worlds : an object of the module that holds the worlds. Its method `advance(steps)` steps all of
        them; `motions(places)` returns a row for each world whose index is in `places`, with the
        numbers that a session's `snapshot` has
    device : name of the device that steps the worlds: "CPU", or the name of a GPU
    """

    def __init__(self, worlds: Any, device: str = Batch.device) -> None:
        self._worlds, self.device = worlds, device

    def advance(self, steps: int) -> None:
        """Let each world take `steps` steps."""
        self._worlds.advance(steps)

    def snapshots(self, places: Sequence[int]) -> Sequence[Any]:
        """Return a snapshot of each world whose index is in `places`, in that order."""
        motions: Sequence[Any] = self._worlds.motions(list(places))
        return motions

    def close(self) -> None:
        """Drop the worlds."""
        del self._worlds


class RecordBatch(WorldBatch):
    """A batch of worlds that one `World` of an adapter's stand-alone module holds and steps.

    Parameters
    ----------
    module : the module's name. Its class `World(scene, method, timestep, others)` takes the record
        of the first scene, and the records of the others as a list; its method `restart` takes a
        list with a motion for each scene
    scenarios : the scene of each world
    method : name of the method
    timestep : length of the steps, s
    device : name of the device that steps the worlds: "CPU", or the name of a GPU
    """

    def __init__(
        self,
        module: str,
        scenarios: Sequence[Scenario],
        method: str,
        timestep: float,
        device: str = Batch.device,
    ) -> None:
        different = dict.fromkeys(scenarios)
        records = {scenario: scene_record(scenario) for scenario in different}
        frames = {scenario: RecordFrame.of(scenario) for scenario in different}
        self._frames = [frames[scenario] for scenario in scenarios]
        first, *others = (records[scenario] for scenario in scenarios)
        super().__init__(import_module(module).World(first, method, timestep, others), device)

    def restart(self, states: State, timestep: float) -> None:
        """Set each world to its row of `states`, and the timestep, s (`Batch.restart`)."""
        motions = [frame.motion(states.rows(k)) for k, frame in enumerate(self._frames)]
        self._worlds.restart(motions, timestep)


def world_script(path: Path, scenario: Scenario, method: str) -> str:
    """Return a Python script of a run: a stand-alone module, the scene's record and the steps.

    Parameters
    ----------
    path : file of the stand-alone module, which defines `World`
    method : name of the method
    """
    record = scene_record(scenario)
    entries = "\n".join(f'    "{key}": {record[key]!r},  # {ABOUT[key]}' for key in record)
    pushing = "\n\n".join(inspect.getsource(function) for function in (is_pushed, push))
    made = f"SCENE = {{\n{entries}\n}}\nworld = World(SCENE, {method!r}, TIMESTEP)"
    return f"{stand_alone(PARTS)}\n\n{pushing}\n\n{run_script(path, made, _STATE)}"


def run_script(path: Path, made: str, state: str, step: str = "world.advance(count)") -> str:
    """Return a Python script of a run: a stand-alone module, a world, and the steps.

    Parameters
    ----------
    path : file of the stand-alone module
    made : lines that make the world
    state : lines that return the attitude, w x y z, and ω in body axes
    step : the line that takes `count` steps
    """
    return f"""{stand_alone(path)}

{made}


def step(count):
    {step}


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
{indent(state, "    ")}
"""


def stand_alone(path: Path) -> str:
    """Return the text of a Python module without its docstring and its relative imports."""
    text = path.read_text(encoding="utf-8")
    docstring = ast.parse(text).body[0].end_lineno or 0
    return _RELATIVE_IMPORT.sub("", "\n".join(text.splitlines()[docstring:])).strip() + "\n"
