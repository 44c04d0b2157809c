"""MJX in both precisions: the scene is MJCF, and JAX compiles MuJoCo's integrators."""

from collections.abc import Sequence
from importlib.metadata import version
from typing import final

import mujoco
from spincheck.engine import COMMON_EFFECTS, Batch, Engine, Method, Scenario, Session

from ...models.mjcf import mjcf
from ..mujoco.engine import setup
from ..mujoco.port import left_in
from ..mujoco.session import check_not_too_small
from .script import SPRINGS, script
from .session import MJXSession, batch

#: A torque fixed in the world acts wrongly on a free body (docs/measured/engines-more.md).
EFFECTS = (COMMON_EFFECTS - {"torque_world"}) | {"rotors", "table"}


def _method(name: str, order: int, summary: str) -> Method:
    """Return the method that uses MuJoCo's integrator `name` (MJCF's name).

    `order` is its declared order of accuracy, of ω and of the attitude; `summary` describes it in a
    few words.
    """
    return Method(name, order, order, summary, EFFECTS, setup=setup(name))


#: Methods in both precisions, without the passes that a scene does not need.
CLEAN = (
    _method("Euler", 1, "semi-implicit Euler, joint damping implicit"),
    _method("implicitfast", 1, "implicit in velocity, without gyroscopic terms"),
    # Its RK4 averages the stages' rotations, as MuJoCo did before 4.0.
    _method("RK4", 2, "Runge-Kutta of fourth order, but for rotations"),
)


class MJX(Engine):
    """The engine MJX in double precision."""

    interface = 2
    name = "mjx"
    package = "mujoco.mjx"
    stock_timestep = 0.002
    has_batches = True
    methods: tuple[Method, ...] = CLEAN

    @property
    def version(self) -> str:
        """The version of the package `mujoco-mjx`, and of the MuJoCo that compiles its models."""
        return f"{version('mujoco-mjx')} (MuJoCo {mujoco.mj_versionString()})"

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Compile the scene's MJCF by MuJoCo, and MJX's step by JAX; return the session."""
        text = self._text(scenario, method)
        return MJXSession(scenario, text, timestep, is_double=not self.single_precision)

    def open_batch(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Batch:
        """Open a batch that `jax.vmap` steps; the MJCF of equal scenes is compiled once."""
        different = dict.fromkeys(scenarios)
        texts = {scenario: self._text(scenario, method) for scenario in different}
        return batch(scenarios, texts, timestep, is_double=not self.single_precision)

    def _text(self, scenario: Scenario, method: Method) -> str:
        """Return the MJCF of a scene for a method.

        `UnsupportedError` is raised if a mass or moment of the scene is too small for MuJoCo.
        """
        check_not_too_small(scenario)
        integrator = None if method.as_shipped else method.name
        passes = left_in(scenario, integrator, SPRINGS)
        return mjcf(scenario, self.stock_timestep, integrator, passes)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """Return a Python script with the scene's MJCF and the few calls that step it."""
        integrator = None if method.as_shipped else method.name
        return script(scenario, integrator, timestep, is_double=not self.single_precision)


@final
class MJXSingle(MJX):
    """The engine MJX in single precision."""

    name = "mjx-float32"
    extra = "mjx"
    single_precision = True
    methods = (
        *CLEAN,
        Method("default", 1, 1, "as shipped: Euler, every pass on", EFFECTS, as_shipped=True),
    )
