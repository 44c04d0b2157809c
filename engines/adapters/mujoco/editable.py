"""Editable models (MjSpec) of files that state a body alone; joint, gravity and start are added."""

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
    # By default the reader would fuse a single link with the world, and fixed links with others.
    spec.compiler.fusestatic = False
    return spec


def free(body: Any) -> None:
    """Give a body of an editable model a free joint."""
    joint = body.add_freejoint()
    if hasattr(joint, "align"):
        # A free joint aligned with the inertial frame would have qpos and qvel along other axes.
        joint.align = False


def with_start(spec: Any) -> Any:
    """Add a keyframe to an editable model, which `set_scene` fills; return the compiled model."""
    spec.add_key(name=START_KEY)
    return spec.compile()


def set_scene(model: Any, scenario: Scenario, integrator: str) -> None:
    """Set in a compiled model what a body's file does not have: integrator, gravity, the start.

    The start goes into the model's first keyframe; `integrator` is MuJoCo's name, in any case.
    """
    model.opt.integrator = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator.upper()}"]
    model.opt.gravity = scenario.gravity_world
    model.key_qpos[0], model.key_qvel[0] = start_coordinates(scenario)
