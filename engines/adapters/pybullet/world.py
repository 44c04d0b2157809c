"""A body in a PyBullet world: loading, holding and stepping it; this needs `pybullet` alone.

docs/measured/engines-pybullet.md says why each call is there, and what happens without it.
"""

import tempfile
from functools import cache, partial
from itertools import count
from pathlib import Path

import pybullet as p

#: PyBullet's index of a body's base; its links count from 0.
BASE = -1
#: Names of PyBullet's defaults that change motions; only a body with joints has the motor.
INERTIA, DAMPING = "inertia of the shape", "damping"
JOINT_MOTOR, CLAMP = "joint motor", "velocity clamp"
DEFAULTS = (INERTIA, DAMPING, JOINT_MOTOR, CLAMP)
#: A velocity, rad/s and m/s, force, N, and torque, N m, larger than any in a run.
UNREACHED = 1e100
#: Parameters of a contact without friction and restitution.
FRICTIONLESS = dict.fromkeys(
    ("lateralFriction", "spinningFriction", "rollingFriction", "restitution"), 0
)
#: Name of the model's file, and a counter that numbers the models of this process.
FILE, numbers = "body.urdf", count()
#: Largest number of steps in a native call: they take some 20 ms, and cannot be interrupted.
MOST_STEPS_A_CALL = 2**14


@cache
def calls(steps, timestep):
    """Return a tuple of numbers of steps, one for each native call, whose sum is `steps`.

    For a call of k steps of length dt, PyBullet is given k dt and k; it divides the one by the
    other, and takes as many steps as fit. This is exact if k is a power of two; otherwise PyBullet
    may take a step less, or steps of another length. One call is used if this is exact for `steps`.

    Parameters
    ----------
    timestep : length of the steps, s
    """
    span = steps * timestep
    each = span / steps
    if steps <= MOST_STEPS_A_CALL and each == timestep and int(span / each) == steps:
        return (steps,)
    chunk = min(1 << (steps.bit_length() - 1), MOST_STEPS_A_CALL)
    rest = steps - chunk
    return (chunk, *calls(rest, timestep)) if rest else (chunk,)


class World:
    """One body in a PyBullet world of its own.

    The body is loaded in its pose at the start, because PyBullet turns a rigid body's inertia to
    world axes only at the end of a step.

    Parameters
    ----------
    scene : the record of the scene, with these keys; the last two groups are needed only for
        `set_up`

        - how the body is loaded: `maximal`, whether in maximal coordinates; `hung`, whether it is
          on a spherical joint; `slides`, the number of slides under that joint; `position`, m;
          `attitude`, x y z w; `rotors`, a list of their kinds of hinge; `defaults`, the names of
          PyBullet's defaults that are kept
        - what acts on it: `gravity`, m/s²; `drag`, N m s; `torque_world`, N m; `plane`, the height
          of the plane that it lies on, m, or None; `motor`, the gain of the spherical joint's
          motor; `is_exact`, whether constraints are solved directly
        - along the principal axes that PyBullet has found: `axes`, the attitude of these axes in
          the scene's body axes, w x y z, which scripts use; `pivot`, the point that is tied to the
          world's origin, m, or None; `torque_body`, N m
        - the motion at the start: `turn`, the attitude, x y z w, and `omega`, rad/s, of the
          spherical joint, along principal axes, or of a base, in world axes; `place`, m, and
          `velocity`, m/s, of the slides or of a base; `spins` of the rotors, rad/s
    client : PyBullet's number of an empty world
    files : the contents of `FILE`, a URDF, and of its meshes, by their names
    """

    def __init__(self, scene, client, files):
        self.scene, self.client = scene, client
        self.link = scene["slides"] if scene["hung"] else BASE
        flags = 0 if INERTIA in scene["defaults"] else p.URDF_USE_INERTIA_FROM_FILE
        # PyBullet caches files and meshes by name, so each model has a folder of its own. It is
        # removed now, not after the run, because the process may be killed during the run.
        prefix = f"scene-{next(numbers)}-"
        with tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) as folder:
            for name, content in files.items():
                Path(folder, name).write_bytes(content)
            self.body = p.loadURDF(
                str(Path(folder, FILE)),
                scene["position"],
                scene["attitude"],
                useMaximalCoordinates=scene["maximal"],
                flags=flags,
                physicsClientId=client,
            )
        # The kinds of the rotors' hinges, by number of their links, which come last.
        self.first_rotor = p.getNumJoints(self.body, client) - len(scene["rotors"])
        hinges = dict(enumerate(scene["rotors"], start=self.first_rotor))
        self.hinges = {link: hinge for link, hinge in hinges.items() if hinge != "locked"}
        self.pushes = []

    def set_up(self, timestep):
        """Remove PyBullet's defaults that are not kept, hold the body, and set it moving.

        `timestep` is the length of the steps, s.
        """
        scene, client = self.scene, self.client
        has_motors = JOINT_MOTOR in scene["defaults"]
        if DAMPING not in scene["defaults"]:
            self.take_away_damping()
        if CLAMP not in scene["defaults"]:
            # The clamp applies to all joint velocities, the base's ω among them.
            self.change(BASE, maxJointVelocity=UNREACHED)
        if scene["hung"] and not has_motors:
            self.set_motor(scene["motor"])
        if scene["is_exact"]:
            # The default solver's 50 iterations leave some drives unsolved, and so much of a
            # slender body's constraint that its error is no longer of first order.
            p.setPhysicsEngineParameter(
                constraintSolverType=p.CONSTRAINT_SOLVER_LCP_DANTZIG, physicsClientId=client
            )
        if scene["pivot"] is not None:
            self.tie()
        if scene["plane"] is not None:
            self.lay_under()
        if not has_motors:
            self.take_away_motors()
        if scene["plane"] is not None:
            # As `restart` does: PyBullet rounds a pose that is loaded otherwise, and a contact
            # divides what is rounded by the timestep.
            p.resetBasePositionAndOrientation(self.body, scene["place"], scene["turn"], client)
        self.set_moving(scene)
        p.setGravity(*scene["gravity"], physicsClientId=client)
        self.set_torques()
        self.set_timestep(timestep)

    def change(self, link, **numbers):
        """Set dynamics parameters of the base or a link, named as in `changeDynamics`."""
        p.changeDynamics(self.body, link, physicsClientId=self.client, **numbers)

    def take_away_damping(self):
        """Set linear and angular damping to 0 for all links; PyBullet stores them with the base."""
        self.change(BASE, linearDamping=0, angularDamping=0)

    def set_motor(self, gain):
        """Set the gain of the motor with which PyBullet brakes a spherical joint by default.

        Parameters
        ----------
        gain : the number 0, with which PyBullet removes the motor for good, or the three numbers
            (0, 0, 0), with which the motor stays in the solver but exerts no torque
        """
        self.control(
            p.POSITION_CONTROL,
            targetPosition=(0, 0, 0, 1),
            positionGain=gain,
            velocityGain=gain,
            force=[0, 0, 0],
        )

    def control(self, mode, **numbers):
        """Control the spherical joint that holds the body.

        `mode` and `numbers` are arguments of `setJointMotorControlMultiDof`.
        """
        p.setJointMotorControlMultiDof(
            self.body, self.link, mode, physicsClientId=self.client, **numbers
        )

    def tie(self):
        """Tie the body's point `pivot` to the world's origin by a point-to-point constraint."""
        client, anchor = self.client, BASE
        if self.scene["maximal"]:
            # In maximal coordinates a constraint is between two bodies. The second, without mass or
            # shape, does not move and stands for the world.
            anchor = p.createMultiBody(
                baseMass=0, useMaximalCoordinates=True, physicsClientId=client
            )
        constraint = p.createConstraint(
            self.body,
            BASE,
            anchor,
            BASE,
            p.JOINT_POINT2POINT,
            jointAxis=(0, 0, 0),
            parentFramePosition=self.scene["pivot"],
            childFramePosition=(0, 0, 0),
            physicsClientId=client,
        )
        # By default the constraint's impulse in a step is limited to 500 N s.
        p.changeConstraint(constraint, maxForce=UNREACHED, physicsClientId=client)

    def lay_under(self):
        """Put a plane without friction and restitution under the body, at the record's height.

        The depth of contacts that Bullet leaves uncorrected, 1e-5 m by default, is set to 0,
        because the error by it does not vanish with the timestep.
        """
        client = self.client
        p.setPhysicsEngineParameter(contactSlop=0, physicsClientId=client)
        shape = p.createCollisionShape(p.GEOM_PLANE, physicsClientId=client)
        place = [0, 0, self.scene["plane"]]
        plane = p.createMultiBody(0, shape, basePosition=place, physicsClientId=client)
        for body in (plane, self.body):
            p.changeDynamics(body, BASE, **FRICTIONLESS, physicsClientId=client)

    def restart(self, motion, timestep):
        """Set the body to a motion, and the length of the steps from now on, s.

        `motion` has the last group of keys of the record: `turn`, `omega`, `place`, `velocity` and
        `spins`.
        """
        if self.link == BASE:
            place, turn = motion["place"], motion["turn"]
            p.resetBasePositionAndOrientation(self.body, place, turn, self.client)
        self.set_moving(motion)
        self.set_timestep(timestep)

    def set_moving(self, motion):
        """Set velocities, spins and the coordinates of joints to those of a motion.

        The pose of a base is left as it is. `motion` has the keys `turn`, `omega`, `place`,
        `velocity` and `spins` of the record, or is the whole record, for the start.
        """
        place, velocity, omega = motion["place"], motion["velocity"], motion["omega"]
        if self.link == BASE:
            p.resetBaseVelocity(self.body, velocity, omega, self.client)
        else:
            self.turn_joint(motion["turn"], omega)
        for link in range(self.link):
            p.resetJointState(self.body, link, place[link], velocity[link], self.client)
        self.set_spins(motion["spins"])

    def turn_joint(self, turn, omega):
        """Set attitude, x y z w, and ω, rad/s, of the spherical joint that holds the body.

        The attitude is a rotation from the joint's zero pose. Both are along the principal axes.
        """
        p.resetJointStateMultiDof(self.body, self.link, turn, omega, physicsClientId=self.client)

    def set_spins(self, spins):
        """Set the spins of the rotors, rad/s, and their angles to 0.

        `spins` has a number for each rotor, which is ignored for a locked one. The drives of driven
        rotors keep their new spins from now on.
        """
        for link, spin in enumerate(spins, start=self.first_rotor):
            if link in self.hinges:
                p.resetJointState(self.body, link, 0.0, float(spin), self.client)
                if self.hinges[link] == "driven":
                    self.drive(link, float(spin), UNREACHED)

    def take_away_motors(self):
        """Remove PyBullet's motors, which brake every hinge and slide."""
        for link in (*range(self.link), *self.hinges):
            self.drive(link, 0.0, 0.0)

    def drive(self, link, spin, torque):
        """Set the motor of a hinge or slide: the spin that it keeps, rad/s, and its largest torque.

        The torque is in N m; a motor with torque 0 is off.
        """
        p.setJointMotorControl2(
            self.body,
            link,
            p.VELOCITY_CONTROL,
            targetVelocity=spin,
            force=torque,
            physicsClientId=self.client,
        )

    def set_torques(self):
        """Choose the torques to apply before each native call; decide if it may take many steps.

        PyBullet applies a torque in all steps of a call and clears it afterwards. This is right for
        a torque that is constant in world axes, or one on a joint. With any other torque, each step
        needs a call of its own.
        """
        in_world, in_body, drag = map(self.scene.get, ("torque_world", "torque_body", "drag"))
        on_base = self.link == BASE
        self.at_once = not (drag or (on_base and any(in_body)))
        if any(in_world):
            self.pushes.append(partial(self.push, in_world, p.WORLD_FRAME))
        if any(in_body) and on_base:
            self.pushes.append(partial(self.push, in_body, p.LINK_FRAME))
        elif any(in_body):
            self.pushes.append(partial(self.control, p.TORQUE_CONTROL, force=in_body))
        if drag and on_base:
            self.pushes.append(partial(self.resist, drag))
        elif drag:
            self.change(self.link, jointDamping=drag)

    def push(self, torque, frame):
        """Apply a torque, N m, to the base or link that is the body.

        `frame` is PyBullet's name of the torque's axes, `LINK_FRAME` or `WORLD_FRAME`.
        """
        p.applyExternalTorque(self.body, self.link, torque, frame, self.client)

    def resist(self, drag):
        """Apply the torque −drag ω, N m, to a body that is not on a spherical joint."""
        _, (x, y, z) = p.getBaseVelocity(self.body, self.client)
        self.push((-drag * x, -drag * y, -drag * z), p.WORLD_FRAME)

    def set_timestep(self, timestep):
        """Set the length of the steps from now on, s."""
        self.timestep, self.substeps = timestep, 0

    def advance(self, steps):
        """Take `steps` steps, many in a native call if no torque has to be set again in between.

        RuntimeError is raised if PyBullet is interrupted in a step.
        """
        if steps == self.substeps and self.at_once:
            self.step(steps)
            return
        for substeps in calls(steps, self.timestep) if self.at_once else [1] * steps:
            self.step(substeps)

    def step(self, substeps):
        """Take `substeps` steps in one native call; raise RuntimeError if it is interrupted."""
        if substeps != self.substeps:
            p.setPhysicsEngineParameter(
                fixedTimeStep=self.timestep * substeps,
                numSubSteps=substeps,
                physicsClientId=self.client,
            )
            self.substeps = substeps
        for push in self.pushes:
            push()
        if p.stepSimulation(self.client) is None:
            raise RuntimeError("PyBullet did not complete a step")

    def motion(self):
        """Return four tuples: com, m, attitude (x y z w), velocity, m/s, and ω, rad/s, world axes.

        They are those of the base, or of the link on the spherical joint, without rotors; the
        attitude is that of its principal axes. A link's motion is computed anew, because PyBullet's
        cached values are those of the step before.
        """
        if self.link == BASE:
            com_world, q_xyzw = p.getBasePositionAndOrientation(self.body, self.client)
            velocity_world, omega_world = p.getBaseVelocity(self.body, self.client)
            return com_world, q_xyzw, velocity_world, omega_world
        # The two numbers 1 are computeLinkVelocity and computeForwardKinematics; passing them by
        # keyword would take longer.
        state = p.getLinkState(self.body, self.link, 1, 1, self.client)
        return state[0], state[1], state[6], state[7]

    def spins(self):
        """Return the spins, rad/s, of the rotors that are not locked, as a tuple."""
        if not self.hinges:
            return ()
        return tuple(state[1] for state in p.getJointStates(self.body, [*self.hinges], self.client))
