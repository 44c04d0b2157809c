"""The scene as MuJoCo reads it from URDF instead of MJCF."""

from typing import Any

import mujoco
import numpy as np
from spincheck.engine import Description, Scenario, UnsupportedError

from ...models.mjcf import START_KEY, armature, start_coordinates
from ...models.urdf import BODY_LINK, urdf

#: Relative margin of the triangle inequality. The reader diagonalises the three principal moments
#: again, with errors of up to 12 ulp each, and without a margin refuses every third flat body.
READER_ROUNDOFF = 3 * 12 * float(np.finfo(float).eps)


def spec_of_urdf(scenario: Scenario, integrator: str, description: Description) -> Any:
    """Return the URDF as an editable model (MjSpec) with integrator, gravity, and a start key.

    Raises
    ------
    UnsupportedError
        If this version of MuJoCo has no editable models.
    """
    if not hasattr(mujoco, "MjSpec"):
        version = mujoco.mj_versionString()
        raise UnsupportedError(f"MuJoCo {version} cannot give a body of a URDF a joint", "effects")
    text = urdf(scenario, READER_ROUNDOFF, description=description)
    spec = mujoco.MjSpec.from_string(text)
    # By default the reader would fuse a single link with the world, and locked rotors with the
    # body.
    spec.compiler.fusestatic = False
    if scenario.constraint.is_free:
        spec.body(BODY_LINK).add_freejoint(align=False)
    for number, rotor in enumerate(scenario.rotors.each, start=1):
        if rotor.hinge != "locked":
            spec.joint(f"hinge{number}").armature = armature(rotor)
    spec.option.integrator = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator.upper()}"]
    spec.option.gravity = scenario.gravity_world
    qpos, qvel = start_coordinates(scenario)
    spec.add_key(name=START_KEY, qpos=qpos, qvel=qvel)
    return spec
