"""An MJX model and its steps as Python that needs `mujoco`, `mujoco-mjx` and `jax`."""

from pathlib import Path

from spincheck.engine import Scenario

from ...models.mjcf import mjcf, start_coordinates, switched_off
from ...models.text import python_lines
from ...world_session import stand_alone

#: MuJoCo's name of the pass of springs.
SPRINGS = ("spring",)
_SCRIPT = """\
{world}

MJCF = (
{lines}
)
in_precision({is_double})
world = World(*in_mjx(nameless(MJCF).compile()), TIMESTEP, qpos={qpos}, qvel={qvel})


def step(count):
    world.run([count])


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    data = world.data()
    q, omega = data.qpos[{moving} : {moving} + 4], data.qvel[{moving} : {moving} + 3]
    return np.array(q, dtype=float), np.array(omega, dtype=float)
"""


def script(scenario: Scenario, integrator: str | None, timestep: float, is_double: bool) -> str:
    """The model of a method; as shipped where there is no integrator."""
    text = mjcf(scenario, timestep, integrator, left_in(scenario, integrator))
    qpos, qvel = start_coordinates(scenario)
    return _SCRIPT.format(
        world=stand_alone(Path(__file__).with_name("world.py")),
        lines=python_lines(text),
        is_double=is_double,
        qpos=qpos,
        qvel=qvel,
        moving=3 - sum(scenario.constraint.is_held),
    )


def left_in(scenario: Scenario, integrator: str | None) -> tuple[str, ...]:
    """The passes that stay on; all as shipped, where there is no integrator.

    Without its pass of springs, MJX leaves out dampers as well.
    """
    return switched_off(scenario) if integrator is None else SPRINGS
