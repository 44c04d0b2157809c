"""A scene in MJX: a compiled loop steps it, and the audit of MuJoCo's adapter finds what acts."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache, partial
from importlib import import_module
from typing import Any, final

import numpy as np
from spincheck.engine import Batch, Derivative, FloatArray, Scenario, in_chart, numbers_by_chart

from ...models.mjcf import start_coordinates
from ...user_cache import user_cache
from ...world_session import WorldBatch
from ..mujoco.port import PortSession, starts
from ..mujoco.session import compiled
from .script import SPRINGS

#: Largest number of models in MJX's form that are kept, some 100 kB each.
MODELS = 64


@final
class MJXSession(PortSession):
    """A session of one body and its rotors in MJX.

    Parameters
    ----------
    text : MJCF of the scene
    is_double : whether MJX computes in double precision; else in single
    """

    def __init__(self, scenario: Scenario, text: str, timestep: float, is_double: bool) -> None:
        model, data = _in_mjx(text, is_double)
        world = _module().World(model, data, timestep, *start_coordinates(scenario))
        super().__init__(scenario, model, world, SPRINGS)

    def record(self, strides: Sequence[int], keep: Callable[[FloatArray], object]) -> None:
        """Take strides of given numbers of steps, and pass a snapshot after each stride to `keep`.

        One call of the compiled loop takes up to `SAMPLES_A_CALL` strides.
        """
        most = _module().SAMPLES_A_CALL
        for first in range(0, len(strides), most):
            for row in self._world.run(strides[first : first + most]):
                keep(row)

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the Jacobians of steps that JAX computes, by its modes: "jacfwd" and "jacrev"."""
        ways = {way: partial(self._derivative, way) for way in ("jacfwd", "jacrev")}
        return {way: Derivative(compute, through=compute) for way, compute in ways.items()}

    def _derivative(self, way: str, steps: int = 1) -> FloatArray:
        """Return the Jacobian of the next `steps` steps, in the chart, (6, 6).

        `way` is JAX's mode, "jacfwd" or "jacrev".
        """
        jacobians: Any = import_module(f"{__package__}.jacobian")
        before = self._world.data()
        after, jacobian = jacobians.jacobian(self._world, way, steps)
        # In qpos the quaternion comes before the angles of rotors.
        turning = self.turning
        kept = np.concatenate([np.arange(4) + turning[0], self._world.model.nq + turning])
        q, q_after = np.array(before.qpos, dtype=float)[kept[:4]], after[kept[:4]]
        numbers = jacobian[np.ix_(kept, kept)]
        return in_chart(q_after, numbers @ numbers_by_chart(q))


def batch(
    scenarios: Sequence[Scenario], texts: Mapping[Scenario, str], timestep: float, is_double: bool
) -> Batch:
    """Open a batch with a world for each scene, stepped by `jax.vmap`.

    Parameters
    ----------
    texts : the MJCF of each scene; equal scenes share an entry
    timestep : length of the steps, s
    is_double : whether MJX computes in double precision; else in single
    """
    models = [_in_mjx(text, is_double) for text in texts.values()]
    worlds = [list(texts).index(scenario) for scenario in scenarios]
    return WorldBatch(_module().Worlds(models, worlds, timestep, *starts(scenarios)))


@lru_cache(maxsize=MODELS)
def _in_mjx(text: str, is_double: bool) -> tuple[Any, Any]:
    """Return MJX's model of an MJCF, and MJX's data with default coordinates and zero velocities.

    Both are cached, because MJX takes a tenth of a second to make them. `is_double` says whether
    MJX computes in double precision; else it does in single.
    """
    module = _module()
    module.in_precision(is_double)
    made: tuple[Any, Any] = module.in_mjx(compiled(lambda: module.nameless(text).compile()))
    return made


@cache
def _module() -> Any:
    """Return the adapter's stand-alone module, `world.py`.

    JAX is set to store compiled code in the user's cache.
    """
    module: Any = import_module(f"{__package__}.world")
    module.jax.config.update("jax_compilation_cache_dir", str(user_cache() / "jax"))
    return module
