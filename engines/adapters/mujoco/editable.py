"""Editable models (MjSpec) of files that state only a body; joint, gravity and start are added."""

from typing import Any

import mujoco
from spincheck.engine import Scenario, UnsupportedError

from ...models.mjcf import START_KEY, start_coordinates


def spec_of_urdf(text: str) -> Any:
    """Return a URDF as an editable model, with a body for each link.

    Raises
    ------
    UnsupportedError
        If this version of MuJoCo has no editable models.
    """
    if not hasattr(mujoco, "MjSpec"):
        version = mujoco.mj_versionString()
        raise UnsupportedError(f"MuJoCo {version} cannot give a body of a URDF a joint", "effects")
    spec = mujoco.MjSpec.from_string(text)
    # By default MuJoCo fuses a link on a fixed joint with its parent, and a single link with the
    # world.
    spec.compiler.fusestatic = False
    return spec


def free(body: Any) -> None:
    """Give a body of an editable model a free joint."""
    joint = body.add_freejoint()
    if hasattr(joint, "align"):
        # If aligned with the inertial frame, the joint's qpos and qvel would be along other axes.
        joint.align = False


def with_start(spec: Any) -> Any:
    """Compile an editable model with an empty keyframe added; return the compiled model.

    `set_scene` writes the start into the keyframe.
    """
    spec.add_key(name=START_KEY)
    return spec.compile()


def set_scene(model: Any, scenario: Scenario, integrator: str) -> None:
    """Set in a compiled model what its file does not state: integrator, gravity and start.

    The start is written into the first keyframe. `integrator` is MuJoCo's name, in upper or lower
    case.
    """
    model.opt.integrator = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator.upper()}"]
    model.opt.gravity = scenario.gravity_world
    model.key_qpos[0], model.key_qvel[0] = start_coordinates(scenario)
