"""The Jacobian of MJX's steps, computed by `jax.jacfwd` or `jax.jacrev`."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .world import in_precision, one_step


@cache
def _compiled(trees: Any, way: str) -> Any:
    """Return a compiled function that returns the Jacobian of some steps, and the state after them.

    The arguments of that function are the number of steps, the state before them, the arrays of
    MJX's model and the arrays of its data. A state is qpos and qvel in one array.

    Parameters
    ----------
    trees : structures (JAX's "treedef") of MJX's model and of its data
    way : JAX's mode, "jacfwd" or "jacrev"
    """
    model_tree, data_tree = trees

    def stepped(steps: Any, x: Any, still: Any, moving: Any) -> Any:
        model = jax.tree.unflatten(model_tree, still)
        data = jax.tree.unflatten(data_tree, moving)
        data = data.replace(qpos=x[: model.nq], qvel=x[model.nq :])
        data = jax.lax.fori_loop(0, steps, lambda _, data: one_step(model, data), data)
        after = jnp.concatenate([data.qpos, data.qvel])
        return after, after

    made = getattr(jax, way)(stepped, argnums=1, has_aux=True)
    # JAX's reverse mode needs loops whose length is known when they are compiled.
    return jax.jit(made, static_argnums=0 if way == "jacrev" else ())


def jacobian(world: Any, way: str, steps: int) -> tuple[Any, Any]:
    """Return the state after the next `steps` steps of a world, (n,), and its Jacobian, (n, n).

    A state is qpos and qvel in one array of n numbers. The Jacobian is the derivative of the
    returned state by the present one. The world itself takes no step.

    Parameters
    ----------
    world : a `World` of the adapter's `world.py`
    way : JAX's mode, "jacfwd" or "jacrev"
    steps : number of steps
    """
    in_precision(world.is_double)
    data = world.data()
    x = np.concatenate([data.qpos, data.qvel])
    found, after = _compiled(world.trees, way)(steps, x, world.still, world.moving)
    return np.asarray(after, dtype=float), np.asarray(found, dtype=float)
