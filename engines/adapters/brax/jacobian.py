"""The Jacobian of steps of Brax's generalized pipeline, by `jax.jacfwd` or `jax.jacrev`."""

import warnings
from importlib import import_module
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from spincheck.engine import FloatArray, in_chart, numbers_by_chart

from ...user_cache import user_cache

parts: Any = import_module(f"{__package__}.world")
# JAX compiles a Jacobian for a minute: what it compiles is stored in the user's cache.
parts.jax.config.update("jax_compilation_cache_dir", str(user_cache() / "jax"))
#: Indices of the quaternion in the coordinates q of a free joint, and of ω in its velocities qd.
QUATERNION, TURNING = slice(3, 7), slice(3, 6)


def _stepped(steps: Any, x: Any, system: Any) -> Any:
    """Return coordinates and velocities (Brax's q and qd) after `steps` steps, in one array, twice.

    JAX differentiates the first by `x`, the same array before the steps, and hands on the second
    as auxiliary output. `system` is Brax's system.
    """
    without_actuators = jnp.zeros(0, x.dtype)
    begun = parts.generalized.init(system, x[: system.q_size()], x[system.q_size() :])
    ended = jax.lax.fori_loop(
        0, steps, lambda _, now: parts.generalized.step(system, now, without_actuators), begun
    )
    after = jnp.concatenate([ended.q, ended.qd])
    return after, after


#: Functions that return a Jacobian and the end of the steps, by JAX's mode. Reverse mode needs
#: loops whose length is known when they are compiled.
_JACOBIANS = {
    "jacfwd": jax.jit(jax.jacfwd(_stepped, argnums=1, has_aux=True)),
    "jacrev": jax.jit(jax.jacrev(_stepped, argnums=1, has_aux=True), static_argnums=0),
}


def jacobian(world: Any, way: str, steps: int) -> FloatArray:
    """Return the Jacobian of a world's next `steps` steps, in the chart, (6, 6).

    The chart's turns, rad, and ω, rad/s, are along the axes of the scene's record. The world itself
    takes no step.

    Parameters
    ----------
    world : a `World` of the adapter's `world.py`
    way : JAX's mode, "jacfwd" or "jacrev"
    steps : number of steps
    """
    x = np.concatenate([world.state.q, world.state.qd])
    with warnings.catch_warnings(**parts.WARNINGS):
        made = _JACOBIANS[way](steps, x, parts.system_of(*world.system_parts))
    by_before, after = (np.asarray(array, dtype=float) for array in made)
    (q, qd), (q_after, qd_after) = (
        np.split(one.astype(float), [world.system.q_size()]) for one in (x, after)
    )
    if not world.is_free:
        before, end = _chart_by_hinges(q, qd), _chart_by_hinges(q_after, qd_after)
        return np.asarray(end @ by_before @ np.linalg.inv(before))
    kept = np.r_[QUATERNION, np.r_[TURNING] + len(q)]
    numbers = by_before[np.ix_(kept, kept)] @ numbers_by_chart(q[QUATERNION])
    return in_chart(q_after[QUATERNION], numbers)


def _chart_by_hinges(q: Any, qd: Any) -> FloatArray:
    """Return the derivative of the chart by angles and rates of three hinges, (6, 6).

    The chart is a turn δθ and ω, in body axes. If b_i is the axis of hinge i in body axes, ω is the
    sum of b_i q_i', and a turn δq_j of a later hinge j changes b_i by b_i × b_j δq_j. `q` has the
    angles, rad, (3,), and `qd` their rates, rad/s, (3,).
    """
    b = parts.hinged(q).T @ parts.hinge_axes(q)
    by_angles = np.zeros((3, 3))
    for j in range(3):
        for i in range(j):
            by_angles[:, j] += qd[i] * np.cross(b[:, i], b[:, j])
    return np.block([[b, np.zeros((3, 3))], [by_angles, b]])
