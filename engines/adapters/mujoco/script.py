"""A MuJoCo model and its steps as Python that needs `mujoco` alone."""

from ....scenarios import Scenario
from ...models.mjcf import mjcf, switched_off
from ...models.text import python_lines

_SCRIPT = """\
import mujoco

MJCF = (
{lines}
)
model = mujoco.MjModel.from_xml_string(MJCF)
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, 0)


def step(count):
    mujoco.mj_step(model, data, count)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    return data.qpos[-4:].copy(), data.qvel[-3:].copy()
"""


def script(scenario: Scenario, integrator: str | None, timestep: float) -> str:
    """The model of a method; as shipped where there is no integrator."""
    left_in = switched_off(scenario) if integrator is None else ()
    return _SCRIPT.format(lines=python_lines(mjcf(scenario, timestep, integrator, left_in)))
