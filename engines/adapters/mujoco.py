"""MuJoCo, from the scene as MJCF: every integrator it has is a method."""

from typing import final

import mujoco

from ...scenarios import EFFECTS, Scenario
from ..engine import Engine, Method
from ..mjcf import mjcf
from ..mujoco_session import MuJoCoSession, compiled

ALL_EFFECTS = frozenset(EFFECTS)


@final
class MuJoCo(Engine):
    """MuJoCo's rigid-body dynamics in reduced coordinates."""

    name = "mujoco"
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
    )

    @property
    def version(self) -> str:
        """Of the library that runs, which is what counts."""
        return str(mujoco.mj_versionString())

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Compile the scene's MJCF and set its keyframe."""
        return _open(mjcf(scenario, timestep, method.name))

    def open_unpruned(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """The same with MuJoCo's default passes left on, to time what they cost."""
        return _open(mjcf(scenario, timestep, method.name, pruned=False))


def _open(text: str) -> MuJoCoSession:
    model = compiled(lambda: mujoco.MjModel.from_xml_string(text))
    start = model.key(0)
    return MuJoCoSession(model, start.qpos, start.qvel)
