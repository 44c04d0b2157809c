"""A Genesis scene of one body, which needs `genesis-world`, `torch` and numpy."""

import sys
import warnings

import numpy as np

from ...world_parts import matrix

hook = sys.excepthook
with warnings.catch_warnings(action="ignore"):
    import genesis as gs

    gs.init(backend=gs.cpu, precision="32", logging_level="error")
sys.excepthook = hook
#: Options that switch off passes that no scene needs; and the option with which joints get no
#: armature by default.
OFF = {"enable_collision": False, "enable_joint_limit": False, "disable_constraint": True}
WITHOUT_ARMATURE = {"default_armature": None}
MJCF = """\
<mujoco>
  <worldbody>
    <body>
      <{joint}/>
      <inertial pos="{com}" mass="{mass!r}" diaginertia="{moments}"/>
    </body>
  </worldbody>
</mujoco>"""


def texts(numbers):
    """Return numbers as one text, separated by spaces, as in an attribute of MJCF."""
    return " ".join(map(repr, map(float, numbers)))


def lever_of(scene):
    """Return the vector from the body's joint to its com, m, in the scene record's axes, (3,)."""
    return -np.array(scene["arm"] or (0.0, 0.0, 0.0))


def mjcf(scene):
    """Return the MJCF of a body on a free joint at its com, or on a ball joint at its pivot."""
    return MJCF.format(
        joint="freejoint" if scene["arm"] is None else 'joint type="ball"',
        com=texts(lever_of(scene)),
        mass=scene["mass"],
        moments=texts(scene["moments"]),
    )


class World:
    """A Genesis scene of one body, in one world or in several.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : length of the steps, s
    others : records of more scenes, each simulated in a further world of the Genesis scene;
        gravity, drag and torques of all worlds are those of `scene`
    """

    def __init__(self, scene, method, timestep, others=()):
        self.scene, self.scenes = scene, [scene, *others]
        self.is_free = scene["arm"] is None
        bodies = list(dict.fromkeys(map(mjcf, self.scenes)))
        # The option batch_links_info allows another body in each world, but its kernels round
        # otherwise: it is set only if bodies differ. Genesis refuses to change a body that it has
        # aligned to its principal axes, so that align is then off.
        options, morph = ({"batch_links_info": True}, {"align": False}) if bodies[1:] else ({}, {})
        if method != "default":
            options |= {"integrator": getattr(gs.integrator, method), **OFF}
            morph |= WITHOUT_ARMATURE
        self.there = gs.Scene(
            sim_options=gs.options.SimOptions(dt=timestep, gravity=tuple(scene["gravity"])),
            rigid_options=gs.options.RigidOptions(**options),
            show_viewer=False,
        )
        self.there.add_entity(gs.morphs.MJCF(file=mjcf(scene), **morph))
        self.there.build(n_envs=len(self.scenes))
        self.solver = self.there.rigid_solver
        if bodies[1:]:
            self.set_bodies()
        if scene["drag"]:
            rotations = np.arange(self.solver.n_dofs)[-3:]
            self.solver.set_dofs_damping(np.full(3, scene["drag"]), rotations)
        self.start(self.scenes)

    def set_bodies(self):
        """Set in each world the mass, com and tensor of the body to those of the world's scene."""
        link = [self.solver.n_links - 1]
        rows = [(one["mass"], lever_of(one), np.diag(one["moments"])) for one in self.scenes]
        mass, com, tensor = (
            np.array(part, np.float32)[:, None] for part in zip(*rows, strict=True)
        )
        self.solver.set_links_mass(mass, link)
        self.solver.set_links_COM(com, link)
        self.solver.set_links_inertia(tensor, link)

    def restart(self, motion, timestep):
        """Set another motion and timestep; nothing of earlier steps is left.

        Parameters
        ----------
        motion : a dict with `q`, `omega`, `com` and `velocity` as in a scene record; if there are
            several worlds, a list of such dicts, one for each world
        timestep : length of the steps from now on, s
        """
        self.there.reset()
        self.solver.rigid_info.substep_dt.fill(timestep)
        self.start(motion if isinstance(motion, list) else [motion])

    def start(self, motions):
        """Set the motion of each world.

        `motions` has a dict for each, with `q`, `omega`, `com` and `velocity` as in a scene record.
        """
        pairs = [self.coordinates(motion) for motion in motions]
        with np.errstate(over="ignore"):
            q, qd = (np.array(part, np.float32) for part in zip(*pairs, strict=True))
        self.solver.set_qpos(q)
        self.solver.set_dofs_velocity(qd)

    def coordinates(self, motion):
        """Return coordinates and velocities of the body's joint in a motion, as two lists.

        `motion` is a dict with `q`, `omega`, `com` and `velocity` as in a scene record. The
        coordinates of a free joint are com, m, and attitude, w x y z. Its velocities are that of
        the com, m/s, world axes, and ω, rad/s, body axes. A ball joint has only attitude and ω.
        """
        place, velocity = (motion["com"], motion["velocity"]) if self.is_free else ((), ())
        omega = matrix(motion["q"]).T @ motion["omega"]
        return [*place, *motion["q"]], [*velocity, *omega]

    def motion(self):
        """Return the state of the first world as one array, (13,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m) and velocity of the com (m/s).
        """
        (motion,) = self.motions([0])
        return motion

    def motions(self, worlds):
        """Return the states of the worlds with given indices, as a list of arrays.

        Each array has the numbers that `motion` returns.
        """
        q, qd = (
            numbers.numpy().astype(float)
            for numbers in (self.solver.get_qpos(), self.solver.get_dofs_velocity())
        )
        return [self.motion_of(self.scenes[k], q[k], qd[k]) for k in worlds]

    def motion_of(self, scene, q, qd):
        """Return the state of one world as an array, (13,), in the order and units of `motion`.

        Parameters
        ----------
        scene : the record of the world's scene
        q, qd : coordinates and velocities of the body's joint, as `coordinates` returns them
        """
        R = matrix(q[-4:])
        omega = R @ qd[-3:]
        if self.is_free:
            return np.concatenate([q[3:], omega, q[:3], qd[:3]])
        com = R @ lever_of(scene)
        return np.concatenate([q, omega, com, np.cross(omega, com)])

    def push(self):
        """Apply the scene's constant torques to the bodies for one step.

        Drag is left out: it is implemented as damping of the joint.
        """
        link = [self.solver.n_links - 1]
        for torque, is_local in (
            (self.scene["torque_body"], True),
            (self.scene["torque_world"], False),
        ):
            if any(torque):
                torques = np.tile(np.array(torque, np.float32), (len(self.scenes), 1, 1))
                self.solver.apply_links_external_wrench(
                    torque=torques, links_idx=link, local=is_local
                )

    def advance(self, steps):
        """Take `steps` steps."""
        for _ in range(steps):
            self.push()
            self.there.step(update_visualizer=False)

    def close(self):
        """Free the scene's memory."""
        self.there.destroy()
