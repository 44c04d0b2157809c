"""A model and its steps as Python that needs `mujoco` alone, or `mujoco-mjx`."""

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
    return data.qpos[-4:].copy(), data.qvel[-3:].copy()
"""
_MJX_SCRIPT = """\
import jax
import mujoco
from mujoco import mjx

jax.config.update("jax_platforms", "cpu")
jax.config.update("jax_enable_x64", {is_double})
MJCF = (
{lines}
)
compiled = mujoco.MjModel.from_xml_string(MJCF)
start = mujoco.MjData(compiled)
mujoco.mj_resetDataKeyframe(compiled, start, 0)
model, data = mjx.put_model(compiled), mjx.put_data(compiled, start)
# Without JAX's weak types, with which it would compile a second time.
model, data = jax.tree.map(lambda x: jax.numpy.array(np.asarray(x)), (model, data))


@jax.jit
def stepped(model, data, count):
    return jax.lax.fori_loop(0, count, lambda _, data: mjx.step(model, data), data)


def step(count):
    global data
    data = stepped(model, data, count)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    return np.array(data.qpos[-4:], dtype=float), np.array(data.qvel[-3:], dtype=float)
"""


def mjx_script(text: str, is_double: bool) -> str:
    """The steps of MJX on an MJCF document."""
    return _MJX_SCRIPT.format(lines=python_lines(text), is_double=is_double)


def script(scenario: Scenario, integrator: str | None, timestep: float) -> str:
    """The model of a method; as shipped where there is no integrator."""
    off = () if integrator is None else switched_off(scenario)
    # One flag up to 3.3.0.
    off += ("passive",) * ({"spring", "damper"} <= set(off))
    text = mjcf(scenario, timestep, integrator, left_in=switched_off(scenario))
    flags = tuple(name.upper() for name in off)
    return _SCRIPT.format(lines=python_lines(text), flags=flags)
