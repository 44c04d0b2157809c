"""PyBullet with a user's own URDF: the link that a scene names is cut out of it."""

from typing import final

from spincheck.engine import Method, Release, Scenario

from ...users_models import MESHES, FileEngine, body_alone, users_link
from .engine import PyBullet, bullet_method, release
from .load import BodyRepresentation
from .model_reader import DEFAULT, FROM_FILE, PyBulletModelReader
from .session import PyBulletSession
from .world import DEFAULTS, FILE, INERTIA

#: The names of PyBullet's defaults that each method keeps.
LEFT = {DEFAULT: frozenset(DEFAULTS), FROM_FILE: frozenset[str]()}


@final
class PyBulletFile(FileEngine):
    """An engine that simulates one link of a user's URDF, as `loadURDF` reads it.

    Its methods are the ways to call `loadURDF`: with the flag that makes it use stated tensors, and
    without.
    """

    name = "pybullet-file"
    reader = PyBulletModelReader()
    stock_timestep = PyBullet.stock_timestep
    methods = (
        bullet_method(
            name=FROM_FILE,
            summary="the link as read from the user's own URDF, with URDF_USE_INERTIA_FROM_FILE",
            effects=frozenset({"gravity"}),
            reader=True,
        ),
        bullet_method(
            name=DEFAULT,
            summary="as shipped: the link as read from the user's own URDF, without a flag",
            effects=frozenset({"gravity"}),
            as_shipped=True,
        ),
    )

    def open(self, scenario: Scenario, method: Method, timestep: float) -> PyBulletSession:
        """Load the scene's link without the others, at the scene's start; return the session."""
        users = users_link(scenario)
        left = LEFT[method.name]
        # Meshes of shapes are needed only if PyBullet computes the tensor from them.
        endings = MESHES if INERTIA in left else None
        text, meshes = body_alone(users.model, users.body, endings)
        representation = BodyRepresentation(defaults=left, own={**meshes, FILE: text})
        return PyBulletSession(scenario, representation, timestep)

    def at_version(self, version: str) -> Release:
        """Return what to install for a version of PyBullet, and this engine's methods."""
        return release(version, self.methods)
