"""MJX, MuJoCo's dynamics written in JAX, on the CPU, from the scene as MJCF.

In single precision, as JAX is by default, and in double precision. How each effect was measured:
docs/engines-more.md.
"""

from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from functools import cache
from importlib import import_module
from importlib.metadata import version
from io import StringIO
from typing import Any, final

import mujoco
import numpy as np

from ...scenarios import EFFECTS, FloatArray, Scenario
from ..engine import Engine, Method
from ..models.mjcf import START_KEY, mjcf, start_coordinates, switched_off
from ..read_back import BodyReading, State
from ..session import Session
from ..user_cache import user_cache
from .mujoco.audit import acting
from .mujoco.script import mjx_script
from .mujoco.session import body_of, check_not_too_small, compiled, states_of

ALL_EFFECTS = frozenset(EFFECTS)
CLEAN = (
    Method("Euler", 1, 1, "semi-implicit Euler, joint damping implicit", ALL_EFFECTS),
    Method("implicitfast", 1, 1, "implicit in velocity, without gyroscopic terms", ALL_EFFECTS),
    # It averages the stages' rotations, as MuJoCo did before 4.0.
    Method("RK4", 2, 2, "Runge-Kutta of fourth order, but for rotations", ALL_EFFECTS),
)
#: Samples that one call takes: a call costs as much as a hundred steps.
SAMPLES_A_CALL = 256


class MJX(Engine):
    """MJX in double precision."""

    name = "mjx"
    package = "mujoco.mjx"
    step_seconds = 10e-6
    stock_timestep = 0.002
    methods: tuple[Method, ...] = CLEAN

    @property
    def version(self) -> str:
        """Of the installed package, and of the MuJoCo that compiles its models."""
        return f"{version('mujoco-mjx')} (MuJoCo {mujoco.mj_versionString()})"

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Compile the scene's MJCF, hand it to MJX, and have JAX compile the step."""
        check_not_too_small(scenario)
        text = _model_of(scenario, method, timestep)
        return MJXSession(scenario, text, is_double=not self.single_precision)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """The model, and MJX's steps of it, as Python."""
        text = _model_of(scenario, method, timestep)
        return mjx_script(text, is_double=not self.single_precision)


@final
class MJXSingle(MJX):
    """MJX in single precision."""

    name = "mjx-float32"
    extra = "mjx"
    single_precision = True
    methods = (
        *CLEAN,
        Method("default", 1, 1, "as shipped: Euler, every pass on", ALL_EFFECTS, as_shipped=True),
    )


@final
class MJXSession(Session):
    """One body, on a ball joint or free; MJX's model and data as flat lists of JAX's arrays."""

    def __init__(self, scenario: Scenario, text: str, is_double: bool) -> None:
        self._jax, self._is_double, self._scenario = _jax(is_double), is_double, scenario
        mjx, jnp = import_module("mujoco.mjx"), import_module("jax.numpy")
        model = mjx.put_model(compiled(lambda: _nameless(text).compile()))
        qpos, qvel = (jnp.array(numbers) for numbers in start_coordinates(scenario))
        data = mjx.make_data(model).replace(qpos=qpos, qvel=qvel)
        flat = [self._jax.tree.flatten(part) for part in (model, data)]
        # Through numpy, which drops JAX's weak types: with them it would compile twice.
        leaves = [[jnp.array(np.asarray(leaf)) for leaf in part] for part, _ in flat]
        (self._held, self._moving), self._trees = leaves, tuple(tree for _, tree in flat)
        # All else that it holds follows from the arrays; as numpy's, for MuJoCo's audit.
        held = [np.asarray(leaf) for leaf in self._held]
        self._model = self._jax.tree.unflatten(self._trees[0], held)
        self.record((), lambda _: None)

    def read_body(self) -> BodyReading:
        """From MJX's model."""
        return body_of(self._model)

    def read_state(self) -> State:
        """The state now."""
        return self.states([self.snapshot()]).rows(0)

    def snapshot(self) -> FloatArray:
        """Coordinates qpos and velocities qvel now."""
        data = self._data()
        return np.concatenate([data.qpos, data.qvel])

    def states(self, snapshots: Sequence[FloatArray]) -> State:
        """From qpos and qvel alone."""
        qpos, qvel = np.split(np.array(snapshots, dtype=float), [self._model.nq], axis=1)
        return states_of(qpos, qvel, self._model.body_ipos[-1])

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
        """What acts, from MJX's model and data."""
        return acting(self._model, self._data(), self._scenario)

    def close(self) -> None:
        """Drop model and data."""
        del self._held, self._moving, self._model

    def _data(self) -> Any:
        return self._jax.tree.unflatten(self._trees[1], [np.asarray(x) for x in self._moving])

    def _run(self, strides: Sequence[int]) -> FloatArray:
        """Take some steps before each sample; returns the samples, one a row."""
        padded = np.zeros(SAMPLES_A_CALL, dtype=np.int32)
        padded[: len(strides)] = strides
        _jax(self._is_double)
        ended = _stepper()(self._trees, self._held, self._moving, padded, len(strides))
        self._moving, rows = self._jax.block_until_ready(ended)
        return np.asarray(rows)[: len(strides)]


def _model_of(scenario: Scenario, method: Method, timestep: float) -> str:
    """The scene as MJCF, with all passes on if as shipped."""
    integrator = None if method.as_shipped else method.name
    left_in = switched_off(scenario) if method.as_shipped else ()
    return mjcf(scenario, timestep, integrator, left_in)


def _nameless(text: str) -> Any:
    """The MJCF without what makes JAX compile anew though it alters no step: name and keyframe."""
    spec = mujoco.MjSpec.from_string(text)
    spec.modelname = ""
    spec.delete(spec.key(START_KEY))
    return spec


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


@cache
def _stepper() -> Any:
    """The compiled loop of steps: numbers are arguments; only the model's structure is compiled."""
    jax, jnp, mjx = import_module("jax"), import_module("jax.numpy"), import_module("mujoco.mjx")

    def run(trees: Any, held: Any, moving: Any, strides: Any, count: int) -> Any:
        model_tree, data_tree = trees
        model = jax.tree.unflatten(model_tree, held)

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

    return jax.jit(run, static_argnums=0)
