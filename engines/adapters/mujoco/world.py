"""A MuJoCo model of one body, which needs `mujoco` alone: passes switched off, at its start."""

from functools import cache

import mujoco


def disable(model, passes):
    """Switch passes off in a compiled model, by MuJoCo's names for its flags.

    A flag shared by several passes is set only if all of them are to be off; flags that this
    version lacks are skipped.
    """
    bits, passes = disabling(), set(passes)
    kept = {bit for name, bit in bits.items() if name not in passes}
    for name in passes & bits.keys():
        if bits[name] not in kept:
            model.opt.disableflags |= bits[name]


@cache
def disabling():
    """The bits that disable passes, by name."""
    bits = flags(mujoco.mjtDisableBit, "mjDSBL_")
    # One flag of both up to 3.3.0.
    passive = bits.pop("passive", 0)
    return bits | ({"spring": passive, "damper": passive} if passive else {})


def flags(enum, prefix):
    """MuJoCo's flags by the names MJCF gives them."""
    members = enum.__members__.items()
    return {key.removeprefix(prefix).lower(): int(bit) for key, bit in members if prefix in key}


def set_timestep(model, timestep, tied):
    """Set the timestep, s, and to `tied` of them the time constant of contacts, unless it is 0."""
    model.opt.timestep = timestep
    if tied:
        model.geom_solref[:, 0] = tied * timestep


def at_start(model, qpos, qvel):
    """Data of the model at these coordinates and velocities."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.qvel[:] = qvel
    return data
