"""A MuJoCo model and its steps as Python that needs `mujoco` alone."""

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


def script(mjcf: str, switched_off: tuple[str, ...], moving: int) -> str:
    """A model and its steps.

    Parameters
    ----------
    switched_off : passes
    moving : coordinates that move a point of the body; its attitude comes after them
    """
    # One flag up to 3.3.0.
    off = switched_off + ("passive",) * ({"spring", "damper"} <= set(switched_off))
    flags = tuple(name.upper() for name in off)
    return _SCRIPT.format(
        lines=python_lines(mjcf),
        flags=flags,
        attitude=f"{moving}:{moving + 4}",
        rotation=f"{moving}:{moving + 3}",
    )
