"""An MJX model and its steps as Python that needs `mujoco`, `mujoco-mjx` and `jax`."""

from ....scenarios import Scenario
from ...models.mjcf import mjcf, switched_off
from ...models.text import python_lines

#: MuJoCo's name of the pass of springs.
SPRINGS = ("spring",)
_SCRIPT = """\
import jax
import mujoco
from mujoco import mjx

jax.config.update("jax_platforms", "cpu")
jax.config.update("jax_enable_x64", {is_double})
MJCF = (
{lines}
)
compiled = mujoco.MjModel.from_xml_string(MJCF)
held = mujoco.MjData(compiled)
mujoco.mj_resetDataKeyframe(compiled, held, 0)
model = mjx.put_model(compiled)
data = mjx.put_data(compiled, held)


@jax.jit
def advanced(data, count):
    return jax.lax.fori_loop(0, count, lambda _, data: mjx.step(model, data), data)


def step(count):
    global data
    data = advanced(data, count)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    q, omega = data.qpos[{moving} : {moving} + 4], data.qvel[{moving} : {moving} + 3]
    return np.array(q, dtype=float), np.array(omega, dtype=float)
"""


def script(scenario: Scenario, integrator: str | None, timestep: float, is_double: bool) -> str:
    """The model of a method; as shipped where there is no integrator."""
    text = mjcf(scenario, timestep, integrator, left_in(scenario, integrator))
    moving = 3 - sum(scenario.constraint.is_held)
    return _SCRIPT.format(is_double=is_double, lines=python_lines(text), moving=moving)


def left_in(scenario: Scenario, integrator: str | None) -> tuple[str, ...]:
    """The passes that stay on; all as shipped, where there is no integrator.

    Without its pass of springs, MJX leaves out dampers as well.
    """
    return switched_off(scenario) if integrator is None else SPRINGS
