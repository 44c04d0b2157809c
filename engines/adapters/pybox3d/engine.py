"""The library libbox3d, in single precision, from its Python package `pybox3d`.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from typing import final

import numpy as np
from spincheck.engine import COMMON_EFFECTS, FloatArray, Method

from ...scene_record import WorldBody
from ...world_engine import WorldEngine
from ...world_session import WorldSession

#: Relative tolerance of numbers that were rounded to single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)
#: Lines by which users keep bodies from falling asleep, and take a step.
AWAKE = """\
world.sleeping_enabled = False
world.step(TIMESTEP)"""


@final
class PyBox3DSession(WorldSession):
    """A session of a world with one box, whose centre is the body's com."""

    def world_body(self) -> WorldBody:
        """Return the body as Box3D holds it: mass, com, tensor and the held point.

        The origin is the com; axes are those of the scene record. The tensor is measured by
        impulses.
        """
        joint, xyz = self.world.joint, self.module.xyz
        arm = None if joint is None else xyz(joint.anchor_b)
        return WorldBody(self.world.body.mass, np.zeros(3), self._tensor(), arm)

    def _tensor(self) -> FloatArray:
        """Return the tensor about the com, kg m², in the scene record's axes, (3, 3).

        Box3D does not report it. It is measured by three couples of impulses on the body at rest.
        If the moments are the scene's, each couple makes the body turn about one axis at 2 rad/s.
        """
        body, world = self.world.body, self.world.world
        before = world.snapshot()
        body.position, body.orientation = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        turned, moments = [], np.array(self.scene["moments"])
        for arm, impulse in zip(np.eye(3)[[1, 2, 0]], np.diag(moments)[[0, 1, 2]], strict=True):
            body.angular_velocity = (0.0, 0.0, 0.0)
            across = np.cross(impulse, arm)
            body.apply_impulse(tuple(across), tuple(arm))
            body.apply_impulse(tuple(-across), tuple(-arm))
            turned.append(self.module.xyz(body.angular_velocity))
        world.restore(before)
        tensor: FloatArray = np.linalg.solve(np.array(turned), np.diag(2 * moments))
        return (tensor + tensor.T) / 2

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the world, except torques, which it does not report: those of the scene
        are assumed to act.
        """
        world, scenario = self.world.world, self.scenario
        joint, gravity = self.world.joint, self.module.xyz(world.gravity)
        right = np.allclose(gravity, scenario.gravity_world, rtol=SLACK, atol=0)
        # The numbers of bodies and joints: a pivot has a fixed body, and its collision filter
        # counts as a joint.
        expected = (1, 0) if joint is None else (2, 2)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": joint is not None and joint.kind == "spherical",
            "other bodies or joints": (world.body_count, world.joint_count) != expected,
            "sleeping": world.sleeping_enabled,
        }
        acting = {name for name, acts in named.items() if acts}
        return frozenset(acting | scenario.called_for & scenario.pushed.keys())


@final
class PyBox3D(WorldEngine):
    """The engine Box3D: the body is a box with the scene's moments, a pivot a spherical joint."""

    session = PyBox3DSession
    name = "pybox3d"
    package = "pybox3d"
    single_precision = True
    # The timestep of its README.
    stock_timestep = 1 / 60
    methods = (
        Method(
            "impulse",
            1,
            1,
            "semi-implicit Euler, the pivot by impulses",
            COMMON_EFFECTS,
            setup=AWAKE,
        ),
        Method("default", 1, 1, "as shipped: may fall asleep", COMMON_EFFECTS, as_shipped=True),
    )
