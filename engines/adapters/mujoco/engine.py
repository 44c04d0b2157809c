"""MuJoCo, from the scene as MJCF: every integrator it has is a method."""

from collections.abc import Collection
from copy import copy
from functools import lru_cache
from typing import Any, final

import mujoco

from ....scenarios import EFFECTS, Scenario
from ...engine import Engine, Method
from ...models.mjcf import mjcf, switched_off
from .clock import CLOCK
from .script import script
from .session import MuJoCoSession, check_not_too_small, compiled, left_out

ALL_EFFECTS = frozenset(EFFECTS)
#: Compiled models that are kept: a ladder runs each at every timestep.
KEPT = 16
#: s, of a model before it is given the run's.
ANY_TIMESTEP = 1e-3


@final
class MuJoCo(Engine):
    """MuJoCo's rigid-body dynamics in reduced coordinates."""

    name = "mujoco"
    # Documentation, XML reference, option/timestep.
    stock_timestep = 0.002
    # Orders: MuJoCo documentation, "Numerical integration" and changelog 4.0.0, item 5; measured
    # in docs/engines-mujoco.md.
    methods = (
        Method("Euler", 1, 1, "semi-implicit Euler, joint damping implicit", ALL_EFFECTS),
        Method(
            "implicitfast",
            1,
            1,
            "implicit in velocity; gyroscopic terms of free bodies only",
            ALL_EFFECTS,
        ),
        Method("implicit", 1, 1, "implicit in velocity, gyroscopic terms included", ALL_EFFECTS),
        Method("RK4", 4, 4, "Runge-Kutta of fourth order", ALL_EFFECTS),
        Method(
            "discrete",
            1,
            1,
            "implicit in velocity and position, one solve with the constraints",
            ALL_EFFECTS,
        ),
        Method(
            "default", 1, 1, "as shipped: Euler, with every pass on", ALL_EFFECTS, as_shipped=True
        ),
    )

    @property
    def version(self) -> str:
        """Of the library that runs, which is what counts."""
        return str(mujoco.mj_versionString())

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Compile the scene's MJCF and set its keyframe."""
        if method.as_shipped:
            left_in = switched_off(scenario)
            return _open(scenario, timestep, None, left_in, has_clock=True)
        return _open(scenario, timestep, method.name, (), has_clock=False)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """The MJCF, and the few calls that step it."""
        return script(scenario, None if method.as_shipped else method.name, timestep)

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """The passes that are switched off, and the clock."""
        return () if method.as_shipped else left_out(scenario)

    def open_unpruned(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        left_in: Collection[str] | None = None,
    ) -> MuJoCoSession | None:
        """The same with passes left on, to time what they cost."""
        if not (names := self.left_out(scenario, method)):
            return None
        kept = names if left_in is None else left_in
        return _open(scenario, timestep, method.name, tuple(kept), CLOCK in kept)


def _open(
    scenario: Scenario,
    timestep: float,
    integrator: str | None,
    left_in: tuple[str, ...],
    has_clock: bool,
) -> MuJoCoSession:
    check_not_too_small(scenario)
    model = copy(_model(scenario, integrator, left_in))
    model.opt.timestep = timestep
    start = model.key(0)
    return MuJoCoSession(scenario, model, start.qpos, start.qvel, has_clock)


@lru_cache(maxsize=KEPT)
def _model(scenario: Scenario, integrator: str | None, left_in: tuple[str, ...]) -> Any:
    """The compiled scene; of all that is in it, only one number depends on the timestep."""
    text = mjcf(scenario, ANY_TIMESTEP, integrator, left_in)
    return compiled(lambda: mujoco.MjModel.from_xml_string(text))
