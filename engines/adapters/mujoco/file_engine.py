"""MuJoCo with a user's own file: the link that a scene names is cut out of its URDF or MJCF."""

import tempfile
from copy import copy
from functools import lru_cache
from pathlib import Path
from typing import Any, final

import mujoco
from spincheck.engine import EngineError, Method, Release, Scenario

from ...models.mjcf import switched_off
from ...users_models import FileEngine, UsersLink, body_alone, users_link
from .editable import free, set_scene, spec_of_urdf, with_start
from .engine import KEPT, MuJoCo, release
from .model_reader import MuJoCoModelReader, spec_of
from .session import MuJoCoSession, check_not_too_small, compiled
from .world import disable

#: Prefix of the names of bodies that are cut out: names do not clash, and the bodies are found.
PREFIX = "cut-"


@final
class MuJoCoFile(FileEngine):
    """An engine that simulates one link of a user's URDF or MJCF, as MuJoCo reads it."""

    name = "mujoco-file"
    reader = MuJoCoModelReader()
    stock_timestep = MuJoCo.stock_timestep
    # Faults in how a file is read show with any integrator, and best with the most accurate one.
    methods = (
        Method(
            "RK4",
            4,
            4,
            "Runge-Kutta of fourth order, on the link as read from the user's own file",
            frozenset({"gravity"}),
            reader=True,
        ),
    )

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Return a session of the scene's link alone, on a free joint, at the scene's start.

        Gravity is the scene's; passes (parts of a step) that the scene does not need are switched
        off.
        """
        check_not_too_small(scenario)
        model = copy(_model(users_link(scenario)))
        set_scene(model, scenario, method.name)
        model.opt.timestep = timestep
        disable(model, switched_off(scenario))
        return MuJoCoSession(scenario, model)

    def at_version(self, version: str) -> Release:
        """Return what to install for a version of MuJoCo, and this engine's method."""
        return release(version, self.methods)


@lru_cache(maxsize=KEPT)
def _model(users: UsersLink) -> Any:
    """Return the compiled model of a user's link; it is cached, as all timesteps need the same."""
    return compiled(lambda: (_of_urdf if users.model.format == "urdf" else _of_mjcf)(users))


def _of_urdf(users: UsersLink) -> Any:
    """Return the compiled model of a link with the inertia that its URDF states, but no shapes."""
    text, _ = body_alone(users.model, users.body)
    spec = spec_of_urdf(text.decode(errors="replace"))
    free(spec.body(users.body.host.name))
    return with_start(spec)


def _of_mjcf(users: UsersLink) -> Any:
    """Return the compiled model of a link of an MJCF, with the welded links that the scene names.

    The file's compiler settings and defaults apply to it.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        return _alone(spec_of(users.model, Path(folder)), users)


def _alone(whole: Any, users: UsersLink) -> Any:
    """Return the compiled model of a link and the links welded to it, on a free joint.

    Parameters
    ----------
    whole : the editable model of the whole file; its options are set to MuJoCo's defaults

    Raises
    ------
    EngineError
        If the file sets the total mass of its model: the mass of a single link is then unknown.
    """
    if whole.compiler.settotalmass > 0:
        raise EngineError(
            "the file's compiler option 'settotalmass' scales the mass and tensor of the link with "
            "those of the whole model: 'spincheck inspect' shows by how much; take it away",
            "body",
        )
    spec = mujoco.MjSpec()
    # From 4.0.0 on MuJoCo warns if the options of the two models differ. None of the file's options
    # is part of the body.
    for name in (name for name in dir(spec.option) if not name.startswith("_")):
        setattr(whole.option, name, getattr(spec.option, name))
    body = spec.worldbody.add_frame().attach_body(whole.body(users.body.host.name), PREFIX, "")
    others = spec.sensors, spec.actuators, spec.tendons, spec.equalities, spec.keys
    for parts in (*others, spec.joints, spec.geoms, spec.sites, spec.cameras, spec.lights):
        for part in list(parts):
            spec.delete(part)
    kept = {f"{PREFIX}{link.name}" for link, _ in users.body.parts}
    for inner in [one for one in spec.bodies if one.name.startswith(PREFIX)]:
        if inner.name not in kept and inner.parent.name in kept:
            spec.delete(inner)
    free(body)
    return with_start(spec)
