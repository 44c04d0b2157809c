"""Sets passes, timestep and start of a MuJoCo model of one body; it needs `mujoco` alone."""

from functools import cache

import mujoco


def disable(model, passes):
    """Switch off passes, which are parts of a step, in a compiled model.

    `passes` has MuJoCo's names of the flags that disable them. If several passes share a flag, it
    is set only if all of them are to be off. Flags that this version lacks are skipped.
    """
    bits, passes = disabling(), set(passes)
    kept = {bit for name, bit in bits.items() if name not in passes}
    for name in passes & bits.keys():
        if bits[name] not in kept:
            model.opt.disableflags |= bits[name]


@cache
def disabling():
    """Return the bits of MuJoCo's flags that disable passes (parts of a step), by name."""
    bits = flags(mujoco.mjtDisableBit, "mjDSBL_")
    # Up to 3.3.0 the passes for springs and dampers share one flag.
    passive = bits.pop("passive", 0)
    return bits | ({"spring": passive, "damper": passive} if passive else {})


def flags(enum, prefix):
    """Return the bits of MuJoCo's flags, by their names in MJCF.

    Parameters
    ----------
    enum : one of MuJoCo's enumerations
    prefix : beginning of the names of flags in this enumeration, which MJCF leaves out
    """
    members = enum.__members__.items()
    return {key.removeprefix(prefix).lower(): int(bit) for key, bit in members if prefix in key}


def set_timestep(model, timestep, tied):
    """Set the timestep, s, of a model, and the time constant of its contacts.

    `tied` is that time constant in timesteps; 0 to keep the model's own.
    """
    model.opt.timestep = timestep
    if tied:
        model.geom_solref[:, 0] = tied * timestep


def at_start(model):
    """Return new data of a model, set to its first keyframe."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return data
