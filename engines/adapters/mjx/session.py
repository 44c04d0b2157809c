"""A scene in MJX: stepped by one compiled loop, audited by MuJoCo's functions."""

from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from functools import cache, lru_cache
from importlib import import_module
from io import StringIO
from typing import Any, final

import mujoco
import numpy as np

from ....scenarios import FloatArray, Scenario
from ...checks.read_back import BodyReading, State
from ...models.mjcf import START_KEY, start_coordinates
from ...session import Session
from ...user_cache import user_cache
from ..mujoco.audit import FLAG_WORDS, acting
from ..mujoco.session import anchor, axial, body_of, compiled, coordinates_of, states_of
from .script import SPRINGS

#: Samples that one call takes: a call costs as much as a hundred steps.
SAMPLES_A_CALL = 256
#: Fields that mark aligned bodies.
_MARKS = ("body_sameframe", "body_simple", "dof_simplenum")
#: Models that are kept as MJX holds them, some 100 kB each.
MODELS = 64


@final
class MJXSession(Session):
    """One body and its rotors; MJX's model and data as flat lists of JAX's arrays."""

    def __init__(self, scenario: Scenario, text: str, timestep: float, is_double: bool) -> None:
        self._jax, self._is_double, self._scenario = _jax(is_double), is_double, scenario
        model, data = _in_mjx(text, is_double)
        self._model, self._is_turning = _with_timestep(model, timestep), scenario.rotors.is_turning
        self._arm_body, self._place_world = anchor(model)
        qpos, qvel = (
            np.asarray(numbers, dtype=data.qpos.dtype) for numbers in start_coordinates(scenario)
        )
        still, model_tree = self._jax.tree.flatten(self._model)
        self._still = self._jax.device_put(still)
        self._at_start, data_tree = self._jax.tree.flatten(data.replace(qpos=qpos, qvel=qvel))
        self._moving = self._at_start
        self._trees = model_tree, data_tree
        self._loop = _loop(self._trees, _kinds(self._still), _kinds(self._moving))
        self.record((), lambda _: None)

    @property
    def can_restart(self) -> bool:
        """Always."""
        return True

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Unless it moves another point of the body than its com."""
        on_pivot = self._model.jnt_type[0] == mujoco.mjtJoint.mjJNT_BALL
        return bool(on_pivot or not self._arm_body.any())

    def restart(self, state: State, timestep: float | None = None) -> None:
        """The data of the start with the coordinates of the state; nothing is compiled again."""
        if timestep is not None:
            self._model = _with_timestep(self._model, timestep)
            self._still = self._jax.tree.leaves(self._model)
        data = self._jax.tree.unflatten(self._trees[1], self._at_start)
        coordinates = coordinates_of(state, self._model.nv, self._arm_body, self._is_turning)
        qpos, qvel = (numbers.astype(data.qpos.dtype) for numbers in coordinates)
        self._moving = self._jax.tree.leaves(data.replace(qpos=qpos, qvel=qvel))

    def read_body(self) -> BodyReading:
        """The body in MJX's model."""
        return replace(body_of(self._model), axial=axial(self._model, len(self._is_turning)))

    def read_state(self) -> State:
        """The state now."""
        return self.states([self.snapshot()]).rows(0)

    def snapshot(self) -> FloatArray:
        """Coordinates qpos and velocities qvel now."""
        data = self._data()
        return np.concatenate([data.qpos, data.qvel])

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        """The states, read from qpos and qvel alone."""
        qpos, qvel = np.split(np.array(snapshots, dtype=float), [self._model.nq], axis=1)
        states = states_of(qpos, qvel, self._arm_body, self._is_turning)
        states.com_world[:] += self._place_world
        return states

    def advance(self, steps: int) -> None:
        """One compiled loop."""
        self._run([steps])

    def record(self, strides: Sequence[int], keep: Callable[[FloatArray], object]) -> None:
        """As in `Session`, many samples a call."""
        for first in range(0, len(strides) or 1, SAMPLES_A_CALL):
            for row in self._run(strides[first : first + SAMPLES_A_CALL]):
                keep(row)

    def check(self) -> None:
        """Nothing to do: MJX neither warns nor resets."""

    def active(self) -> frozenset[str]:
        """What acts, from MJX's model and data; its pass of springs is that of dampers, too."""
        names_acting = acting(self._model, self._data(), self._scenario)
        return names_acting - {FLAG_WORDS[name] for name in SPRINGS}

    def close(self) -> None:
        """Drop model and data."""
        del self._still, self._moving, self._model

    def _data(self) -> Any:
        return self._jax.tree.unflatten(self._trees[1], [np.asarray(x) for x in self._moving])

    def _run(self, strides: Sequence[int]) -> FloatArray:
        """Take some steps before each sample; returns the samples, one a row."""
        padded = np.zeros(SAMPLES_A_CALL, dtype=np.int32)
        padded[: len(strides)] = strides
        _jax(self._is_double)
        ended = self._loop(self._still, self._moving, padded, np.int32(len(strides)))
        self._moving, rows = self._jax.block_until_ready(ended)
        return np.asarray(rows)[: len(strides)]


def _nameless(text: str) -> Any:
    """The MJCF without what makes JAX compile anew though it alters no step: name and keyframe."""
    spec = mujoco.MjSpec.from_string(text)
    spec.modelname = ""
    spec.delete(spec.key(START_KEY))
    return spec


@lru_cache(maxsize=MODELS)
def _in_mjx(text: str, is_double: bool) -> tuple[Any, Any]:
    """A model and data at rest, as MJX makes them of an MJCF, in numpy's arrays.

    As numpy's: the compiled loop takes none of JAX's weak types, and MuJoCo's audit reads them. To
    hand a model to MJX takes a tenth of a second; nothing changes the arrays.
    """
    jax, mjx = _jax(is_double), import_module("mujoco.mjx")
    model = _unmarked(mjx.put_model(compiled(lambda: _nameless(text).compile())))
    made: tuple[Any, Any] = jax.tree.map(np.asarray, (model, mjx.make_data(model)))
    return made


def _unmarked(model: Any) -> Any:
    """The model without the marks of aligned bodies, by which MuJoCo's C code saves itself work.

    MJX's steps do not read them, but JAX would compile them anew for each.
    """
    return model.replace(**{name: np.zeros_like(getattr(model, name)) for name in _MARKS})


def _with_timestep(model: Any, timestep: float) -> Any:
    made = np.asarray(timestep, dtype=model.opt.timestep.dtype)
    return model.tree_replace({"opt.timestep": made})


def _jax(is_double: bool) -> Any:
    """JAX on the CPU in this precision, which keeps what it compiles in the user's cache."""
    jax: Any = import_module("jax")
    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_compilation_cache_dir", str(user_cache() / "jax"))
    with redirect_stdout(StringIO()):  # It prints that Warp is not there.
        import_module("mujoco.mjx")
    if jax.config.jax_enable_x64 != is_double:
        jax.config.update("jax_enable_x64", is_double)
        # Functions that were traced in the other precision do not fit MJX's any more.
        jax.clear_caches()
    return jax


#: Shape and type of an array.
Kind = tuple[tuple[int, ...], str]


def _kinds(arrays: Sequence[Any]) -> tuple[Kind, ...]:
    return tuple((array.shape, str(array.dtype)) for array in arrays)


@cache
def _loop(trees: Any, still: tuple[Kind, ...], moving: tuple[Kind, ...]) -> Any:
    """The compiled loop of steps: numbers are arguments; only the model's structure is compiled."""
    jax, jnp, mjx = import_module("jax"), import_module("jax.numpy"), import_module("mujoco.mjx")
    model_tree, data_tree = trees

    def run(still: Any, moving: Any, strides: Any, count: Any) -> Any:
        model = jax.tree.unflatten(model_tree, still)

        def step(_: int, moving: Any) -> Any:
            return jax.tree.leaves(mjx.step(model, jax.tree.unflatten(data_tree, moving)))

        def sample(k: int, carried: Any) -> Any:
            moving, rows = carried
            moving = jax.lax.fori_loop(0, strides[k], step, moving)
            data = jax.tree.unflatten(data_tree, moving)
            return moving, rows.at[k].set(jnp.concatenate([data.qpos, data.qvel]))

        data = jax.tree.unflatten(data_tree, moving)
        rows = jnp.zeros((SAMPLES_A_CALL, model.nq + model.nv), data.qpos.dtype)
        return jax.lax.fori_loop(0, count, sample, (moving, rows))

    kinds = (still, moving, (((SAMPLES_A_CALL,), "int32"),), (((), "int32"),))
    held_as, moving_as, (strides_as,), (count_as,) = (
        [jax.ShapeDtypeStruct(*kind) for kind in part] for part in kinds
    )
    return jax.jit(run).lower(held_as, moving_as, strides_as, count_as).compile()
