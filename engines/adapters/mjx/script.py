"""An MJX model and its steps as Python that needs `mujoco`, `mujoco-mjx` and `jax`."""

from pathlib import Path

from spincheck.engine import Scenario

from ...models.mjcf import mjcf
from ..mujoco.port import left_in, port_script

#: MuJoCo's name of the pass for springs; if it is off, MJX leaves out dampers as well.
SPRINGS = ("spring",)
_MADE = """\
in_precision({is_double})
world = World(*in_mjx(nameless(MJCF).compile()), TIMESTEP, qpos={{qpos}}, qvel={{qvel}})"""


def script(scenario: Scenario, integrator: str | None, timestep: float, is_double: bool) -> str:
    """Return a Python script that builds and steps a scene's model in MJX.

    Parameters
    ----------
    integrator : MuJoCo's name of the integrator; None for the model as shipped
    timestep : length of the steps, s
    is_double : whether MJX computes in double precision; else in single
    """
    text = mjcf(scenario, timestep, integrator, left_in(scenario, integrator, SPRINGS))
    world = Path(__file__).with_name("world.py")
    return port_script(world, scenario, text, _MADE.format(is_double=is_double))
