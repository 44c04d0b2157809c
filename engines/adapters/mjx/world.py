"""A body in MJX, which needs `mujoco`, `mujoco-mjx`, `jax` and numpy alone."""

from contextlib import redirect_stdout
from functools import cache
from io import StringIO

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

with redirect_stdout(StringIO()):  # MJX prints that Warp is not installed
    from mujoco import mjx

#: Largest number of samples in one call of the loop; a call costs as much as a hundred steps.
SAMPLES_A_CALL = 256
#: Fields of MuJoCo's model that mark bodies aligned with their inertial frame.
MARKS = ("body_sameframe", "body_simple", "dof_simplenum")
#: MJX's step. JAX traces it once, in a second, and not again for each loop that contains it.
one_step = jax.jit(mjx.step)


def in_precision(is_double):
    """Make JAX compute on the CPU, in double precision or in single, which is its default."""
    jax.config.update("jax_platforms", "cpu")
    if jax.config.jax_enable_x64 != is_double:
        jax.config.update("jax_enable_x64", is_double)
        # Otherwise JAX would use functions that were traced in the other precision.
        jax.clear_caches()


def nameless(text):
    """Return an MJCF as an editable model without its name and its first keyframe.

    JAX would compile its loop anew for models that differ only in one of these.
    """
    spec = mujoco.MjSpec.from_string(text)
    spec.modelname = ""
    spec.delete(spec.keys[0])
    return spec


def in_mjx(compiled):
    """Convert a compiled model of MuJoCo; return MJX's model and data, with arrays of numpy.

    The data have default coordinates and zero velocities. Arrays are numpy's because the compiled
    loop accepts none of JAX's weak types, and so that they can be read like MuJoCo's. The marks of
    aligned bodies (`MARKS`), by which MuJoCo's C code saves work, are set to zero: MJX's steps do
    not read them, but JAX would compile the loop anew for each of their values.
    """
    model = mjx.put_model(compiled)
    model = model.replace(**{name: np.zeros_like(getattr(model, name)) for name in MARKS})
    return jax.tree.map(np.asarray, (model, mjx.make_data(model)))


def kinds(arrays):
    """Return a pair of shape and type for each array, in a tuple that can be a key of a cache."""
    return tuple((array.shape, str(array.dtype)) for array in arrays)


@cache
def loop(trees, still, moving):
    """Return a compiled loop of steps, which all models of one structure can use.

    The loop takes the arrays of a model, the arrays of its data, an array with the number of steps
    before each sample, padded to `SAMPLES_A_CALL`, and the number of samples. It returns the arrays
    of the data at the end, and an array with qpos and then qvel of a sample in each row.

    Parameters
    ----------
    trees : structures (JAX's "treedef") of the model and of the data
    still : shapes and types of the model's arrays, from `kinds`
    moving : shapes and types of the data's arrays, from `kinds`
    """
    model_tree, data_tree = trees

    def run(still, moving, strides, count):
        model = jax.tree.unflatten(model_tree, still)

        def stepped(_, moving):
            return jax.tree.leaves(one_step(model, jax.tree.unflatten(data_tree, moving)))

        def sample(k, carried):
            moving, rows = carried
            moving = jax.lax.fori_loop(0, strides[k], stepped, moving)
            data = jax.tree.unflatten(data_tree, moving)
            return moving, rows.at[k].set(jnp.concatenate([data.qpos, data.qvel]))

        data = jax.tree.unflatten(data_tree, moving)
        rows = jnp.zeros((SAMPLES_A_CALL, model.nq + model.nv), data.qpos.dtype)
        return jax.lax.fori_loop(0, count, sample, (moving, rows))

    kinds = (still, moving, (((SAMPLES_A_CALL,), "int32"),), (((), "int32"),))
    still_as, moving_as, (strides_as,), (count_as,) = (
        [jax.ShapeDtypeStruct(*kind) for kind in part] for part in kinds
    )
    return jax.jit(run).lower(still_as, moving_as, strides_as, count_as).compile()


def at_timestep(model, timestep):
    """Return the model with another timestep, s."""
    return model.tree_replace({"opt.timestep": np.asarray(timestep, model.opt.timestep.dtype)})


class World:
    """One world: MJX's model and data, held as flat lists of JAX's arrays.

    Parameters
    ----------
    model, data : MJX's model, and its data at rest, as `in_mjx` returns them
    timestep : length of the steps, s
    qpos : coordinates at the start, (nq,)
    qvel : velocities at the start, (nv,)
    """

    def __init__(self, model, data, timestep, qpos, qvel):
        self.is_double = data.qpos.dtype == np.float64
        in_precision(self.is_double)
        self.trees = jax.tree.structure(model), jax.tree.structure(data)
        self.model, self.precision = model, data.qpos.dtype
        self.still, self.at_rest = jax.device_put((jax.tree.leaves(model), jax.tree.leaves(data)))
        self.still_at, self.moving_at = (
            jax.tree.unflatten(tree, range(tree.num_leaves)) for tree in self.trees
        )
        self.set_timestep(timestep)
        self.restart(qpos, qvel)
        self.loop = loop(self.trees, kinds(self.still), kinds(self.moving))
        self.run([])

    def set_timestep(self, timestep):
        """Set the length of the steps from now on, s."""
        self.model = at_timestep(self.model, timestep)
        self.still[self.still_at.opt.timestep] = self.model.opt.timestep

    def restart(self, qpos, qvel):
        """Set coordinates, (nq,), and velocities, (nv,); nothing of earlier steps is left."""
        self.moving = [*self.at_rest]
        for at, numbers in (self.moving_at.qpos, qpos), (self.moving_at.qvel, qvel):
            self.moving[at] = np.asarray(numbers, dtype=self.precision)

    def run(self, strides):
        """Take steps; return qpos and then qvel of n samples, a sample in each row, (n, nq + nv).

        `strides` has the number of steps before each sample; n is at most `SAMPLES_A_CALL`.
        """
        padded = np.zeros(SAMPLES_A_CALL, dtype=np.int32)
        padded[: len(strides)] = strides
        in_precision(self.is_double)
        ended = self.loop(self.still, self.moving, padded, np.int32(len(strides)))
        self.moving, rows = jax.block_until_ready(ended)
        return np.asarray(rows)[: len(strides)]

    def advance(self, steps):
        """Take `steps` steps."""
        self.run([steps])

    def motions(self, places):
        """Return an array with qpos and then qvel of this world in each row, (n, nq + nv).

        `places` has n indices of worlds, which all must be 0, since there is one world.
        """
        at = self.moving_at.qpos, self.moving_at.qvel
        return np.concatenate([self.moving[one] for one in at])[None][places]

    def data(self):
        """Return MJX's data after the last step, with arrays of numpy."""
        return jax.tree.unflatten(self.trees[1], [np.asarray(array) for array in self.moving])


class Worlds:
    """Worlds that one compiled loop steps together, by `jax.vmap`.

    The arrays in which the models differ have the worlds along their first axis.

    Parameters
    ----------
    models : pairs of a model and its data, as `in_mjx` returns them
    worlds : index, in `models`, of the model of each world
    timestep : length of the steps, s
    qpos : coordinates at the start, (worlds, nq)
    qvel : velocities at the start, (worlds, nv)

    Raises
    ------
    ValueError
        If the models differ in more than numbers.
    """

    def __init__(self, models, worlds, timestep, qpos, qvel):
        (_, data), *_ = models
        self.is_double = data.qpos.dtype == np.float64
        in_precision(self.is_double)
        models = [at_timestep(model, timestep) for model, _ in models]
        trees = {jax.tree.structure(model) for model in models}
        if len(trees) > 1:
            raise ValueError("its worlds cannot differ in more than numbers")
        self.model, self.data_tree = models[0], jax.tree.structure(data)
        rows = list(zip(*map(jax.tree.leaves, models), strict=True))
        differs = [any(not np.array_equal(row[0], one) for one in row) for row in rows]
        still = [
            np.array(row)[worlds] if one_differs else row[0]
            for row, one_differs in zip(rows, differs, strict=True)
        ]
        moving = jax.tree.map(lambda leaf: np.repeat(leaf[None], len(worlds), axis=0), data)
        with np.errstate(over="ignore"):
            qpos, qvel = (np.array(numbers, data.qpos.dtype) for numbers in (qpos, qvel))
        moving = jax.tree.leaves(moving.replace(qpos=qpos, qvel=qvel))
        self.still, self.moving = jax.device_put((still, moving))

        def step(still, moving):
            model = jax.tree.unflatten(*trees, still)
            return jax.tree.leaves(mjx.step(model, jax.tree.unflatten(self.data_tree, moving)))

        stepped = jax.vmap(
            step, in_axes=([0 if one_differs else None for one_differs in differs], 0)
        )

        def run(still, moving, steps):
            return jax.lax.fori_loop(0, steps, lambda _, now: stepped(still, now), moving)

        self.loop = jax.jit(run)
        self.advance(0)  # compiles the loop

    def advance(self, steps):
        """Take `steps` steps of every world."""
        in_precision(self.is_double)
        self.moving = jax.block_until_ready(self.loop(self.still, self.moving, np.int32(steps)))

    def motions(self, places):
        """Return an array with qpos and then qvel of one world in each row, (n, nq + nv).

        `places` has the indices of the n worlds.
        """
        data = jax.tree.unflatten(self.data_tree, self.moving)
        return np.concatenate([data.qpos, data.qvel], axis=1)[places]
