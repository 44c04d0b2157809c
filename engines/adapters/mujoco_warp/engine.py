"""MuJoCo Warp: the scene is MJCF, and MuJoCo's integrators are Warp's kernels."""

from collections.abc import Sequence
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import mujoco
from spincheck.engine import COMMON_EFFECTS, Batch, Engine, Method, Scenario, Session

from ...models.mjcf import mjcf
from ...warp_kernels import kernels_kept, use_warp_device, warp_device
from ..mujoco.engine import setup
from ..mujoco.port import PortBatch, PortSession, left_in, port_script, starts
from ..mujoco.session import check_not_too_small, compiled

#: MuJoCo's names of flags that MuJoCo Warp does not accept, because it has no such passes.
ALWAYS_ON = ("midphase", "autoreset")
EFFECTS = COMMON_EFFECTS | {"rotors", "table"}
_MADE = """\
model = mujoco.MjModel.from_xml_string(MJCF)
world = World([model], [0], TIMESTEP, {qpos}, {qvel})"""


def _method(name: str, order: int, summary: str) -> Method:
    """Return the method that uses MuJoCo's integrator `name` (MJCF's name).

    `order` is its declared order of accuracy, of ω and of the attitude; `summary` describes it in a
    few words.
    """
    return Method(name, order, order, summary, EFFECTS, setup=setup(name))


@final
class MuJoCoWarp(Engine):
    """The engine MuJoCo Warp, which computes in single precision only."""

    interface = 2
    name = "mujoco-warp"
    package = "mujoco_warp"
    stock_timestep = 0.002
    single_precision = True
    has_batches = restarts_batches = True
    methods = (
        _method("Euler", 1, "semi-implicit Euler, joint damping implicit"),
        _method("implicitfast", 1, "implicit in velocity, without gyroscopic terms"),
        _method("RK4", 4, "Runge-Kutta of fourth order"),
        _method("discrete", 1, "implicit in velocity and position"),
        Method("default", 1, 1, "as shipped: Euler, every pass on", EFFECTS, as_shipped=True),
    )

    @property
    def version(self) -> str:
        """The version of the package `mujoco-warp`, and of the MuJoCo that compiles its models."""
        return f"{version('mujoco-warp')} (MuJoCo {mujoco.mj_versionString()})"

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Compile the scene's MJCF by MuJoCo, and load it in MuJoCo Warp; return the session."""
        world = self._world([scenario], method, timestep)
        return PortSession(scenario, world.model, world, ALWAYS_ON)

    def use_device(self, name: str) -> None:
        """Make the device with Warp's name `name` step all scenes that are opened from now on."""
        use_warp_device(f"{__package__}.world", name)

    def open_batch(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Batch:
        """Open a batch with a world for each scene; the MJCF of equal scenes is compiled once."""
        world = self._world(scenarios, method, timestep)
        session = PortSession(scenarios[0], world.model, world, ALWAYS_ON)
        return PortBatch(session, world, warp_device())

    def _world(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Any:
        """Return a `World` of the adapter's `world.py` that holds a world for each scene.

        `UnsupportedError` is raised if a body is too small for MuJoCo, `EngineError` if MuJoCo's
        compiler refuses a model.
        """
        different = list(dict.fromkeys(scenarios))
        for scenario in different:
            check_not_too_small(scenario)
        texts = [self._text(scenario, method) for scenario in different]
        models = [compiled(partial(mujoco.MjModel.from_xml_string, text)) for text in texts]
        worlds = [different.index(scenario) for scenario in scenarios]
        with kernels_kept():
            module = import_module(f"{__package__}.world")
            return module.World(models, worlds, timestep, *starts(scenarios))

    def _text(self, scenario: Scenario, method: Method) -> str:
        """Return the MJCF of a scene for a method."""
        integrator = None if method.as_shipped else method.name
        passes = left_in(scenario, integrator, ALWAYS_ON)
        return mjcf(scenario, self.stock_timestep, integrator, passes)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """Return a Python script with the scene's MJCF and the few calls that step it."""
        world = Path(__file__).with_name("world.py")
        return port_script(world, scenario, self._text(scenario, method), _MADE)
