"""A scene in MJX: stepped by one compiled loop, audited by MuJoCo's functions."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache, partial
from importlib import import_module
from typing import Any, final

import numpy as np
from spincheck.engine import (
    BodyReading,
    Derivative,
    FloatArray,
    Scenario,
    Session,
    State,
    in_chart,
    numbers_by_chart,
)

from ...models.mjcf import start_coordinates
from ...user_cache import user_cache
from ..mujoco.audit import FLAG_WORDS, acting
from ..mujoco.coordinates import Coordinates
from ..mujoco.session import compiled
from .script import SPRINGS

#: Models that are kept as MJX holds them, some 100 kB each.
MODELS = 64


@final
class MJXSession(Session):
    """One body and its rotors; MJX's model and data as flat lists of JAX's arrays."""

    def __init__(self, scenario: Scenario, text: str, timestep: float, is_double: bool) -> None:
        self._scenario = scenario
        model, data = _in_mjx(text, is_double)
        self._coordinates = Coordinates(model, scenario)
        self._world = _module().World(model, data, timestep, *start_coordinates(scenario))

    @property
    def can_restart(self) -> bool:
        """Always."""
        return True

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Unless it moves another point of the body than its com."""
        return self._coordinates.restarts_to_the_last_bit

    def restart(self, state: State, timestep: float | None = None) -> None:
        """The data of the start with the coordinates of the state; nothing is compiled again."""
        if timestep is not None:
            self._world.set_timestep(self._world.model, timestep)
        self._world.restart(*self._coordinates.of(state))

    def read_body(self) -> BodyReading:
        """The body in MJX's model."""
        return self._coordinates.read_body()

    def read_state(self) -> State:
        """The state now."""
        return self.states([self.snapshot()]).rows(0)

    def snapshot(self) -> FloatArray:
        """Coordinates qpos and velocities qvel now."""
        data = self._world.data()
        return np.concatenate([data.qpos, data.qvel])

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        """The states, read from qpos and qvel alone."""
        rows = np.array(snapshots, dtype=float)
        return self._coordinates.states(*np.split(rows, [self._world.model.nq], axis=1))

    def advance(self, steps: int) -> None:
        """One compiled loop."""
        self._world.run([steps])

    def record(self, strides: Sequence[int], keep: Callable[[FloatArray], object]) -> None:
        """As in `Session`, many samples a call."""
        most = _module().SAMPLES_A_CALL
        for first in range(0, len(strides), most):
            for row in self._world.run(strides[first : first + most]):
                keep(row)

    def check(self) -> None:
        """Nothing to do: MJX neither warns nor resets."""

    def active(self) -> frozenset[str]:
        """What acts, from MJX's model and data; its pass of springs is that of dampers, too."""
        names_acting = acting(self._world.model, self._world.data(), self._scenario)
        return names_acting - {FLAG_WORDS[name] for name in SPRINGS}

    def derivatives(self) -> Mapping[str, Derivative]:
        """JAX's, of one step, in forward and reverse mode."""
        return {way: Derivative(partial(self._derivative, way)) for way in ("jacfwd", "jacrev")}

    def _derivative(self, way: str) -> FloatArray:
        """That of the quaternion and ω by themselves, in the chart."""
        jacobians: Any = import_module(f"{__package__}.jacobian")
        before = self._world.data()
        after, jacobian = jacobians.jacobian(self._world, way)
        # The quaternion stands before any spins of rotors.
        turning = self._coordinates.turning
        kept = np.concatenate([np.arange(4) + turning[0], self._world.model.nq + turning])
        q, q_after = np.array(before.qpos, dtype=float)[kept[:4]], after[kept[:4]]
        numbers = jacobian[np.ix_(kept, kept)]
        return in_chart(q_after, numbers @ numbers_by_chart(q))

    def close(self) -> None:
        """Drop model and data."""
        del self._world


@lru_cache(maxsize=MODELS)
def _in_mjx(text: str, is_double: bool) -> tuple[Any, Any]:
    """A model and data at rest; to hand a model to MJX takes a tenth of a second."""
    module = _module()
    module.in_precision(is_double)
    made: tuple[Any, Any] = module.in_mjx(compiled(lambda: module.nameless(text).compile()))
    return made


@cache
def _module() -> Any:
    """The adapter's stand-alone module, with what JAX compiles kept in the user's cache."""
    module: Any = import_module(f"{__package__}.world")
    module.jax.config.update("jax_compilation_cache_dir", str(user_cache() / "jax"))
    return module
