"""A MuJoCo model and its steps as Python that needs `mujoco` alone."""

from collections.abc import Sequence
from pathlib import Path

from ...models.text import python_lines
from ...world_session import stand_alone

_SCRIPT = """\
{world}

MJCF = (
{lines}
)
model = mujoco.MjModel.from_xml_string(MJCF)
# What this scene has no use for; not every version of MuJoCo has all of it.
disable(model, {passes!r})
set_timestep(model, TIMESTEP, {tied!r})
data = at_start(model, model.key(0).qpos, model.key(0).qvel)


def step(count):
    mujoco.mj_step(model, data, count)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    return data.qpos[{moving}:{moving} + 4].copy(), data.qvel[{moving}:{moving} + 3].copy()
"""


def script(mjcf: str, passes: Sequence[str], tied: float, moving: int) -> str:
    """Return the Python that builds a model and steps it.

    Parameters
    ----------
    passes : MuJoCo's names of the passes that are switched off
    tied : time constant of contacts, in timesteps
    moving : number of coordinates that move a point of the body; its attitude comes after them
    """
    return _SCRIPT.format(
        world=stand_alone(Path(__file__).with_name("world.py")),
        lines=python_lines(mjcf),
        passes=tuple(passes),
        tied=tied,
        moving=moving,
    )
