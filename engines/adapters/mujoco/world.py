"""A MuJoCo model of one body, at its start and with passes switched off; needs `mujoco` alone."""

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
    """Return the bits of MuJoCo's flags that disable passes, by name."""
    bits = flags(mujoco.mjtDisableBit, "mjDSBL_")
    # Up to 3.3.0 one flag switches both passes.
    passive = bits.pop("passive", 0)
    return bits | ({"spring": passive, "damper": passive} if passive else {})


def flags(enum, prefix):
    """Return the bits of MuJoCo's flags by the names that MJCF gives them.

    Parameters
    ----------
    enum : one of MuJoCo's enumerations
    prefix : what the names of its flags begin with
    """
    members = enum.__members__.items()
    return {key.removeprefix(prefix).lower(): int(bit) for key, bit in members if prefix in key}


def set_timestep(model, timestep, tied):
    """Set the timestep, s, and with `tied` > 0 the time constant of contacts, in timesteps.

    With `tied` = 0 the model's own time constants are left.
    """
    model.opt.timestep = timestep
    if tied:
        model.geom_solref[:, 0] = tied * timestep


def at_start(model):
    """Return new data of a model, set to its first keyframe."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return data
