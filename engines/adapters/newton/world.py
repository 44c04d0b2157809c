"""A Newton world of one body; it needs `newton`, numpy, and for one solver `mujoco-warp`."""

from itertools import groupby

import newton
import numpy as np
import warp as wp

from ...world_parts import drive, is_pushed, matrix, rotor_tensor

wp.config.log_level = wp.LOG_ERROR
wp.set_device("cpu")
#: Newton's solver for each method, and the solver's options.
SOLVERS = {
    **{
        f"mujoco-{name}": ("MuJoCo", {"integrator": name, "disable_contacts": True})
        for name in ("rk4", "implicitfast", "euler", "discrete")
    },
    "featherstone": ("Featherstone", {"angular_damping": 0.0}),
    "steel": ("Steel", {}),
    "semi-implicit": ("SemiImplicit", {"angular_damping": 0.0}),
    "xpbd": ("XPBD", {"angular_damping": 0.0}),
    "default": ("MuJoCo", {}),
    "steel-default": ("Steel", {}),
    "semi-implicit-default": ("SemiImplicit", {}),
}


@wp.kernel
def push_bodies(
    pose: wp.array(dtype=wp.transform),
    twist: wp.array(dtype=wp.spatial_vector),
    drag: float,
    torque_body: wp.vec3,
    torque_world: wp.vec3,
    bodies: int,
    wrench: wp.array(dtype=wp.spatial_vector),
):
    """Write the scene's torque on the first body of each world into `wrench`; a Warp kernel.

    `pose` and `twist` are poses and velocities of all bodies. `drag`, N m s, and the torques, N m,
    are those of the scene record. `bodies` is the number of bodies in a world. The force in
    `wrench` is set to zero.
    """
    i = wp.tid() * bodies
    turned = wp.quat_rotate(wp.transform_get_rotation(pose[i]), torque_body)
    torque = turned + torque_world - drag * wp.spatial_bottom(twist[i])
    wrench[i] = wp.spatial_vector(wp.vec3(), torque)


def transform(place, q_wxyz=(1.0, 0.0, 0.0, 0.0)):
    """Return Warp's transform with a position, m, and an attitude, a quaternion w x y z."""
    w, x, y, z = q_wxyz
    return wp.transform(wp.vec3(*place), wp.quat(x, y, z, w))


def lever_of(scene):
    """Return the vector from the body's joint to its com, m, in the scene record's axes, (3,)."""
    return -np.array(scene["arm"] or (0.0, 0.0, 0.0))


class World:
    """One body on a free joint at its com, or on a ball joint at its pivot; rotors are on hinges.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method, a key of `SOLVERS`
    timestep : length of the steps, s
    others : records of more scenes, each a further world of the same model; gravity, drag and
        torques of all worlds are those of `scene`
    """

    def __init__(self, scene, method, timestep, others=()):
        self.scene, self.scenes = scene, [scene, *others]
        solver, self.options = SOLVERS[method]
        self.solver_class = getattr(newton.solvers, f"Solver{solver}")
        builder = self.builder()
        if others:
            for _, alike in groupby(self.scenes, id):
                one, *more = alike
                world = self.builder()
                self.add_scene(world, one)
                builder.replicate(world, 1 + len(more))
        else:
            self.add_scene(builder, scene)
        builder.color()
        self.model = builder.finalize()
        if method == "steel":
            self.model.steel.rigid_body_angular_damping.zero_()
        self.solver = self.solver_class(self.model, **self.options)
        self.now, self.then = self.model.state(), self.model.state()
        self.control = self.model.control()
        self.bodies = self.model.body_count // len(self.scenes)
        self.graphs = {}
        self.restart(self.scenes, timestep)
        self.advance(2)  # records the step now, so that it does not count when steps are timed
        self.restart(self.scenes, timestep)

    def builder(self):
        """Return a new model builder with the scene's gravity and no body."""
        builder = newton.ModelBuilder(gravity=tuple(self.scene["gravity"]))
        if hasattr(self.solver_class, "register_custom_attributes"):
            self.solver_class.register_custom_attributes(builder)
        return builder

    def add_scene(self, builder, scene):
        """Add a scene's body and rotors to a model builder."""
        lever = lever_of(scene)
        body = self.add_body(builder, scene["mass"], lever, np.diag(scene["moments"]))
        is_free = scene["arm"] is None
        root = builder.add_joint_free(body) if is_free else builder.add_joint_ball(-1, body)
        hinges = [self.add_rotor(builder, body, lever, one) for one in scene.get("rotors", ())]
        builder.add_articulation([root, *hinges])

    def add_body(self, builder, mass, com, tensor):
        """Add a body to a model builder; return its number.

        `mass` is in kg, and `com`, from the body's origin, in m, (3,). `tensor`, about the com, is
        in kg m², (3, 3).
        """
        inertia = wp.mat33(*tensor.ravel())
        return builder.add_link(mass=mass, com=wp.vec3(*com), inertia=inertia, lock_inertia=True)

    def add_rotor(self, builder, body, lever, rotor):
        """Add a rotor to a body, on the joint of its kind of hinge; return the joint's number.

        Parameters
        ----------
        builder : the model builder
        body : number of the body
        lever : vector from the body's joint to its com, m, in the scene record's axes, (3,)
        rotor : the rotor's entry in the scene record
        """
        child = self.add_body(builder, rotor["mass"], np.zeros(3), rotor_tensor(rotor))
        at = transform(lever + rotor["place"])
        if rotor["hinge"] == "locked":
            return builder.add_joint_fixed(body, child, parent_xform=at)
        axis, armature = wp.vec3(*rotor["axis"]), drive(rotor)
        return builder.add_joint_revolute(
            body, child, parent_xform=at, axis=axis, armature=armature
        )

    def restart(self, motion, timestep):
        """Set another motion and timestep; nothing of earlier steps is left.

        Parameters
        ----------
        motion : a dict with `q`, `omega`, `com`, `velocity` and, with rotors, `spins` as in a scene
            record; if there are several worlds, a list of such dicts, one for each world
        timestep : length of the steps from now on, s
        """
        self.timestep = timestep
        motions = motion if isinstance(motion, list) else [motion]
        pairs = [self.coordinates(*both) for both in zip(self.scenes, motions, strict=True)]
        with np.errstate(over="ignore"):
            q, qd = (np.concatenate(part).astype(np.float32) for part in zip(*pairs, strict=True))
        self.solver.reset(self.now, flags=0)
        self.now.joint_q.assign(q)
        self.now.joint_qd.assign(qd)
        newton.eval_fk(self.model, self.now.joint_q, self.now.joint_qd, self.now)
        self.then.assign(self.now)

    def coordinates(self, scene, motion):
        """Return coordinates and velocities of a scene's joints in a motion, as two lists.

        The coordinates of a free joint are com, m, and attitude, x y z w. Its velocities are that
        of the com, m/s, and ω, rad/s, in world axes. A ball joint has only attitude and ω. Rotors
        that are not locked come last, with angle 0 and their spins, rad/s.

        Parameters
        ----------
        scene : the scene's record
        motion : the motion, a dict with `q`, `omega`, `com`, `velocity` and, with rotors, `spins`
            as in a scene record
        """
        w, *xyz = motion["q"]
        spins = zip(scene.get("rotors", ()), motion.get("spins", ()), strict=True)
        spins = [spin for rotor, spin in spins if rotor["hinge"] != "locked"]
        place, velocity = (motion["com"], motion["velocity"]) if scene["arm"] is None else ((), ())
        return [*place, *xyz, w, *np.zeros(len(spins))], [*velocity, *motion["omega"], *spins]

    def motion(self, world=0):
        """Return the state of the world with a given index as one array, (13 + rotors,).

        Its numbers are attitude (w x y z), ω (rad/s), com (m) and its velocity (m/s), all in world
        axes, and spins (rad/s).
        """
        scene, own = self.scenes[world], slice(world * self.bodies, (world + 1) * self.bodies)
        poses = self.now.body_q.numpy()[own].astype(float)
        twists = self.now.body_qd.numpy()[own].astype(float)
        x, y, z, w = poses[0, 3:]
        R, omega = matrix((w, x, y, z)), twists[0, 3:]
        spun = zip(scene.get("rotors", ()), twists[1:, 3:], strict=True)
        spins = [
            (R @ rotor["axis"]) @ (turned - omega) * (rotor["hinge"] != "locked")
            for rotor, turned in spun
        ]
        com = poses[0, :3] + R @ lever_of(scene)
        return np.concatenate([(w, x, y, z), omega, com, twists[0, :3], spins])

    def motions(self, worlds):
        """Return the states of the worlds with given indices, as a list of arrays.

        Each array has the numbers that `motion` returns.
        """
        return [self.motion(world) for world in worlds]

    def push(self, state):
        """Write the scene's torques on the bodies into Newton's state, for the next step.

        They are computed from that state, and stay constant during the step.
        """
        scene = self.scene
        numbers = wp.vec3(*scene["torque_body"]), wp.vec3(*scene["torque_world"])
        inputs = [state.body_q, state.body_qd, scene["drag"], *numbers, self.bodies, state.body_f]
        wp.launch(push_bodies, dim=len(self.scenes), inputs=inputs)

    def step(self, timestep):
        """Take a step of length `timestep`, s."""
        if is_pushed(self.scene):
            self.push(self.now)
        self.solver.step(self.now, self.then, self.control, None, timestep)
        self.now.assign(self.then)

    def advance(self, steps):
        """Take `steps` steps, most of them by replaying a recorded graph of kernel launches.

        For each timestep, the very first step is taken by calls from Python. Then a step is
        recorded as a graph, and all further steps launch this graph, which takes a hundredth of
        the time of the calls. Recording takes as long as two steps.
        """
        if steps and self.timestep not in self.graphs:
            self.step(self.timestep)  # loads the kernels, which is not possible while recording
            self.graphs[self.timestep] = None
            steps -= 1
        if steps and self.graphs[self.timestep] is None:
            with wp.ScopedCapture() as capture:
                self.step(self.timestep)
            self.graphs[self.timestep] = capture.graph
        for _ in range(steps):
            wp.capture_launch(self.graphs[self.timestep])
        wp.synchronize_device()  # waits until a GPU has taken the steps
