"""The Jacobian of steps of MJX, as `jax.jacfwd` and `jax.jacrev` give it."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .world import in_precision, one_step


@cache
def _compiled(trees: Any, way: str) -> Any:
    """Return a compiled function that gives the Jacobian of steps, and qpos and qvel after them.

    Its arguments are the number of steps, qpos and qvel before them in one array, and the arrays of
    the model and of the data.

    Parameters
    ----------
    trees : structures of the model and of the data, as JAX's trees
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
    # Reverse mode only goes through loops whose length the compiler knows.
    return jax.jit(made, static_argnums=0 if way == "jacrev" else ())


def jacobian(world: Any, way: str, steps: int) -> tuple[Any, Any]:
    """Return qpos and qvel after the next steps of a world, (n,), and their Jacobian, (n, n).

    The Jacobian is by qpos and qvel before the steps; `way` is JAX's mode, "jacfwd" or "jacrev".
    The world itself takes no step.
    """
    in_precision(world.is_double)
    data = world.data()
    x = np.concatenate([data.qpos, data.qvel])
    found, after = _compiled(world.trees, way)(steps, x, world.still, world.moving)
    return np.asarray(after, dtype=float), np.asarray(found, dtype=float)
