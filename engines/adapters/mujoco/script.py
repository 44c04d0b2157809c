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
# What this scene has no use for; not every version of MuJoCo has all of it.
for flag in {flags!r}:
    model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, "mjDSBL_" + flag, 0))
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, 0)


def step(count):
    mujoco.mj_step(model, data, count)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    return data.qpos[{attitude}].copy(), data.qvel[{rotation}].copy()
"""


def script(scenario: Scenario, integrator: str | None, timestep: float) -> str:
    """The model of a method; as shipped where there is no integrator."""
    off = () if integrator is None else switched_off(scenario)
    # One flag up to 3.3.0.
    off += ("passive",) * ({"spring", "damper"} <= set(off))
    text = mjcf(scenario, timestep, integrator, left_in=switched_off(scenario))
    flags = tuple(name.upper() for name in off)
    first = 0 if scenario.constraint.is_pivot else 3
    return _SCRIPT.format(
        lines=python_lines(text),
        flags=flags,
        attitude=f"{first}:{first + 4}",
        rotation=f"{first}:{first + 3}",
    )
