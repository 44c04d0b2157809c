"""A MuJoCo model and its steps as Python that needs `mujoco` alone."""

from collections.abc import Sequence
from pathlib import Path

from ...models.text import python_text
from ...world_session import run_script


def script(mjcf: str, passes: Sequence[str], tied: float, moving: int) -> str:
    """Return the Python that builds a model and steps it.

    Parameters
    ----------
    passes : MuJoCo's names of the passes that are switched off
    tied : time constant of contacts, in timesteps
    moving : number of coordinates that move a point of the body; its attitude comes after them
    """
    made = f"""\
{python_text("MJCF", mjcf)}
model = mujoco.MjModel.from_xml_string(MJCF)
# What this scene has no use for; not every version of MuJoCo has all of it.
disable(model, {tuple(passes)!r})
set_timestep(model, TIMESTEP, {tied!r})
data = at_start(model, model.key(0).qpos, model.key(0).qvel)"""
    state = (
        f"return data.qpos[{moving}:{moving} + 4].copy(), data.qvel[{moving}:{moving} + 3].copy()"
    )
    world = Path(__file__).with_name("world.py")
    return run_script(world, made, state, "mujoco.mj_step(model, data, count)")
