"""A Brax system of one body, which needs `brax`, `mujoco`, `jax` and numpy."""

import warnings
from functools import cache, partial

import jax
import mujoco
import numpy as np

from ...world_parts import matrix, quaternion

#: Filter that ignores all warnings. Brax and a package that it imports warn that they are not
#: maintained; the parts of MJX that it uses warn as well.
WARNINGS = {"action": "ignore", "category": Warning}

with warnings.catch_warnings(**WARNINGS):
    from brax import com, kinematics
    from brax.base import Motion, Transform
    from brax.generalized import pipeline as generalized
    from brax.io.mjcf import load_model
    from brax.positional import pipeline as positional
    from brax.spring import pipeline as spring

jax.config.update("jax_platforms", "cpu")
#: The pipeline of each method, and Brax's own options, which it reads from `custom` in an MJCF.
PIPELINES = {
    # With iterations, the inverse mass matrix would only be approximated, beginning with that of
    # the step before.
    "generalized": (generalized, {"matrix_inv_iterations": 0}),
    "spring": (spring, {}),
    "positional": (positional, {}),
    "default": (generalized, {}),
}
MJCF = """\
<mujoco>
  <option gravity="{gravity}"/>
  <custom>{custom}</custom>
  <worldbody>
    <body>
      {joints}
      <inertial pos="{com}" mass="{mass!r}" diaginertia="{moments}"/>
    </body>
  </worldbody>
</mujoco>"""
#: Brax has no ball joint. In its place are three hinges in series, about the axes of the body.
HINGES = "".join(f'<joint axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
#: Axes of the frame that the hinges are in, as columns, world axes. The hinges are singular where
#: the body's third axis is along the first column. At the start, the third axis of a top is often
#: along an axis of the world, so the first column is along none.
FRAME = np.array([[1, 1, 1], [1, -1, 1], [1, 0, -2]]) / np.sqrt([3, 2, 6])


def single(numbers):
    """Return numbers as an array in single precision; those beyond its range are infinite."""
    with np.errstate(over="ignore"):
        return np.asarray(numbers, np.float32)


def texts(numbers):
    """Return numbers as one text, separated by spaces, as in an attribute of MJCF."""
    return " ".join(map(repr, map(float, numbers)))


def mjcf(scene, options):
    """Return the MJCF of a body on a free joint at its com, or on three hinges at its pivot.

    Parameters
    ----------
    scene : the scene's record
    options : Brax's own options, numbers by name, which become `numeric` elements of the MJCF
    """
    is_free = scene["arm"] is None
    custom = "".join(f'<numeric name="{key}" data="{options[key]}"/>' for key in options)
    return MJCF.format(
        gravity=texts(scene["gravity"]),
        custom=custom,
        joints="<freejoint/>" if is_free else HINGES,
        com=texts(-np.array(scene["arm"] or (0.0, 0.0, 0.0))),
        mass=scene["mass"],
        moments=texts(scene["moments"]),
    )


def angles(R):
    """Return the angles, rad, (3,), of three hinges in series that together rotate by R.

    The first hinge turns about x, the next about y, the last about z. `hinged` returns R for these
    angles.
    """
    return np.array(
        [
            np.arctan2(-R[1, 2], R[2, 2]),
            np.arctan2(R[0, 2], np.hypot(R[0, 0], R[0, 1])),
            np.arctan2(-R[0, 1], R[0, 0]),
        ]
    )


def turned_about(angle, axis):
    """Return the matrix of a rotation by an angle, rad, about the axis with number 0, 1 or 2."""
    q = np.zeros(4)
    q[0], q[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return matrix(q)


def hinged(q):
    """Return the rotation matrix, body to the hinges' frame, for hinges at angles q, rad, (3,)."""
    return turned_about(q[0], 0) @ turned_about(q[1], 1) @ turned_about(q[2], 2)


def hinge_axes(q):
    """Return the axes about which the hinges turn the body, as columns, (3, 3).

    They are unit vectors in the axes of the hinges' frame. `q` has the angles, rad, (3,).
    """
    first = turned_about(q[0], 0)
    second = first @ turned_about(q[1], 1)
    return np.column_stack([np.eye(3)[0], first[:, 1], second[:, 2]])


class Structure:
    """The structure (JAX's "treedef") of Brax systems, shared by all that differ only in numbers.

    JAX finds compiled code by the identity of this object: comparing the constant arrays of two
    structures would take longer than a step.
    """

    def __init__(self, tree):
        self.tree = tree


#: Function that returns the `Structure` of a tree: the same object for equal trees.
structure_of = cache(Structure)


def system_of(structure, numbers, timestep):
    """Return the Brax system that has a given structure, arrays and timestep.

    Parameters
    ----------
    structure : the system's `Structure`
    numbers : the system's arrays, in the order in which JAX lists the leaves of the tree
    timestep : length of the steps, s
    """
    system = jax.tree.unflatten(structure.tree, numbers)
    return system.replace(opt=system.opt.replace(timestep=timestep))


@partial(jax.jit, static_argnums=(0, 1))
def begun(pipeline, structure, numbers, timestep, q, qd):
    """Return the state before the first step, at coordinates q and velocities qd.

    `pipeline` is the module of one of Brax's pipelines. `structure`, `numbers` and `timestep` are
    the arguments of `system_of`.
    """
    return pipeline.init(system_of(structure, numbers, timestep), q, qd)


@partial(jax.jit, static_argnums=0)
def moved(structure, numbers, timestep, state, place, turning):
    """Return a state with the bodies set to other poses and velocities.

    This function is needed because Brax's `init` gives a body on several hinges a wrong velocity,
    as a note in brax/kinematics.py says: "fix qd->jd calculation for stacked/offset joints".

    Parameters
    ----------
    structure, numbers, timestep : the arguments of `system_of`
    state : the state before, which is not changed
    place : position of each body's com, and each body's attitude, a `Transform`
    turning : ω of each body, and the velocity of its com, a `Motion`
    """
    system = system_of(structure, numbers, timestep)
    x, xd = com.to_world(system, place, turning)
    j, jd, a_p, a_c = kinematics.world_to_joint(system, x, xd)
    found = {"x": x, "xd": xd, "j": j, "jd": jd, "a_p": a_p, "a_c": a_c}
    return state.replace(x_i=place, xd_i=turning, **found)


@partial(jax.jit, static_argnums=(0, 1))
def stepped(pipeline, structure, numbers, timestep, state, count):
    """Return the state after `count` steps of a pipeline that start from `state`.

    `pipeline` is the module of one of Brax's pipelines. `structure`, `numbers` and `timestep` are
    the arguments of `system_of`.
    """
    system = system_of(structure, numbers, timestep)
    without_actuators = np.zeros(0, np.float32)
    return jax.lax.fori_loop(
        0, count, lambda _, now: pipeline.step(system, now, without_actuators), state
    )


class World:
    """One body in a Brax system of its own.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method, a key of `PIPELINES`
    timestep : length of the steps, s
    """

    def __init__(self, scene, method, timestep):
        self.scene, self.is_free = scene, scene["arm"] is None
        self.pipeline, options = PIPELINES[method]
        self.is_generalized = self.pipeline is generalized
        model = mujoco.MjModel.from_xml_string(mjcf(scene, options))
        with warnings.catch_warnings(**WARNINGS):
            system = load_model(model)
        if not self.is_free:
            place = system.link.transform.replace(rot=single([quaternion(FRAME)]))
            system = system.replace(link=system.link.replace(transform=place))
        # Without MuJoCo's model in them, systems differ only in numbers, and JAX compiles once.
        self.system = jax.tree.map(np.asarray, system.replace(mj_model=None))
        numbers, tree = jax.tree.flatten(self.system)
        self.structure, self.numbers = structure_of(tree), jax.device_put(numbers)
        self.restart(scene, timestep)

    def restart(self, motion, timestep):
        """Set another motion, and the timestep, s; nothing of earlier steps is left.

        `motion` is a dict with `q`, `omega`, `com` and `velocity` as in a scene record.
        """
        self.timestep = single(timestep)
        R, omega = matrix(motion["q"]), np.array(motion["omega"])
        if self.is_free:
            # A free joint has its angular velocity in body axes.
            q = [*motion["com"], *motion["q"]]
            qd = [*motion["velocity"], *(R.T @ omega)]
        else:
            q = angles(FRAME.T @ R)
            qd = np.linalg.solve(FRAME @ hinge_axes(q), omega)
        with warnings.catch_warnings(**WARNINGS):
            self.state = begun(self.pipeline, *self.system_parts, single(q), single(qd))
            if not self.is_generalized:
                place = Transform(pos=single([motion["com"]]), rot=single([motion["q"]]))
                turning = Motion(ang=single([omega]), vel=single([motion["velocity"]]))
                self.state = moved(*self.system_parts, self.state, place, turning)

    @property
    def system_parts(self):
        """The structure, the numbers and the timestep of the system: arguments of `system_of`."""
        return self.structure, self.numbers, self.timestep

    def motion(self):
        """Return the present state as one array, (13,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m) and velocity of the com (m/s).
        """
        return self.motion_of(self.state)

    def motion_of(self, state):
        """Return a state of the pipeline as an array, (13,), in the order and units of `motion`."""
        q, qd = np.asarray(state.q, float), np.asarray(state.qd, float)
        if not self.is_generalized:
            place, turning = jax.tree.map(
                lambda row: np.asarray(row[0], float), (state.x_i, state.xd_i)
            )
            return np.concatenate([place.rot, turning.ang, place.pos, turning.vel])
        if self.is_free:
            return np.concatenate([q[3:], matrix(q[3:]) @ qd[3:], q[:3], qd[:3]])
        R, omega = FRAME @ hinged(q), FRAME @ hinge_axes(q) @ qd
        com = R @ -np.array(self.scene["arm"])
        return np.concatenate([quaternion(R), omega, com, np.cross(omega, com)])

    def advance(self, steps):
        """Take `steps` steps."""
        with warnings.catch_warnings(**WARNINGS):
            ended = stepped(self.pipeline, *self.system_parts, self.state, np.int32(steps))
        self.state = jax.block_until_ready(ended)


@partial(jax.jit, static_argnums=0)
def stepped_all(pipeline, systems, states, count):
    """Return the states of all worlds after `count` steps of each.

    `pipeline` is the module of one of Brax's pipelines. `systems` and `states` are trees whose
    arrays have a row for each world.
    """
    without_actuators = np.zeros(0, np.float32)
    step = jax.vmap(lambda system, now: pipeline.step(system, now, without_actuators))
    return jax.lax.fori_loop(0, count, lambda _, now: step(systems, now), states)


def stacked(trees):
    """Join JAX trees that differ only in numbers: each array gets a row for each of the trees."""
    return jax.tree.map(lambda *leaves: np.stack(leaves), *trees)


class Worlds:
    """Worlds whose systems differ only in numbers, stepped together by `jax.vmap`.

    Parameters
    ----------
    worlds : the single worlds, each a `World` at its start
    """

    def __init__(self, worlds):
        self.worlds, self.pipeline = worlds, worlds[0].pipeline
        systems = [jax.tree.map(np.asarray, system_of(*world.system_parts)) for world in worlds]
        self.systems = jax.device_put(stacked(systems))
        self.states = jax.device_put(stacked([world.state for world in worlds]))

    def advance(self, steps):
        """Take `steps` steps of each world."""
        with warnings.catch_warnings(**WARNINGS):
            ended = stepped_all(self.pipeline, self.systems, self.states, np.int32(steps))
        self.states = jax.block_until_ready(ended)

    def motions(self, places):
        """Return a list of `World.motion` of each world whose index is in `places`."""
        states = jax.tree.map(np.asarray, self.states)
        return [
            self.worlds[k].motion_of(jax.tree.map(lambda leaf, k=k: leaf[k], states))
            for k in places
        ]
