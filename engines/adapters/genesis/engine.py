"""Genesis's rigid solver, in single precision, on the CPU.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import version
from typing import final

import numpy as np
from spincheck.engine import (
    COMMON_EFFECTS,
    Batch,
    EngineError,
    Method,
    Scenario,
    Session,
)

from ...scene_record import WorldBody
from ...world_engine import WorldEngine
from ...world_parts import matrix, push
from ...world_session import RecordBatch, WorldSession
from .caches import kernels_kept
from .model_reader import GenesisModelReader

#: Relative tolerance of numbers that were rounded to single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)
SETUP = """\
rigid = gs.options.RigidOptions(integrator=gs.integrator.{}, disable_constraint=True)
scene = gs.Scene(sim_options=gs.options.SimOptions(dt=TIMESTEP), rigid_options=rigid)"""


@final
class GenesisSession(WorldSession):
    """A session of one body in a Genesis scene of its own; the body's origin is at its joint."""

    def world_body(self) -> WorldBody:
        """Return the body as the solver holds it: mass, com, tensor and the held point.

        The origin is the joint; axes are those of the scene record.
        """
        links = self.world.solver.dyn_info.links
        mass, com, tensor, q = (
            getattr(links, f"inertial_{name}").to_numpy()[-1].astype(float)
            for name in ("mass", "pos", "i", "quat")
        )
        R = matrix(q)
        return WorldBody(
            float(mass), com, R @ tensor @ R.T, None if self.world.is_free else np.zeros(3)
        )

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the solver.
        """
        world, solver = self.world, self.world.solver
        motion = world.motion()
        gravity = solver.get_gravity().numpy().astype(float).ravel()
        wanted = push({**self.scene, "drag": 0.0}, matrix(motion[:4]), motion[4:7])
        world.push()
        # Genesis stores the torque on a link with the opposite sign.
        torque = -solver.dyn_state.links.cfrc_applied_ang.to_numpy()[-1, 0].astype(float)
        solver.clear_external_force()
        damping = solver.get_dofs_damping().numpy().astype(float).ravel().tolist()
        pushed_right = np.linalg.norm(torque - wanted) <= SLACK * np.linalg.norm(wanted)
        right = np.allclose(gravity, self.scenario.gravity_world, rtol=SLACK, atol=0)
        drag = [0.0] * (len(damping) - 3) + [self.scene["drag"]] * 3
        is_right = np.allclose(damping, drag, rtol=SLACK, atol=0)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": solver.n_dofs == 3,
            "drag" if is_right else f"a joint damping of {damping} N m s": any(damping),
            f"a torque of {torque.tolist()} N m": not pushed_right,
            "joint friction": solver.get_dofs_frictionloss().numpy().any(),
            "joint springs": solver.get_dofs_stiffness().numpy().any(),
            "armature": solver.get_dofs_armature().numpy().any(),
            "other bodies": solver.n_links != 1,
        }
        acting = {name for name, acts in named.items() if acts}
        stated = self.scenario.called_for & {"torque_body", "torque_world"}
        return frozenset(acting | stated if torque.any() else acting)

    def advance(self, steps: int) -> None:
        """Let the world take steps; raise `EngineError` if a state is no longer finite."""
        with errors_told():
            super().advance(steps)

    def close(self) -> None:
        """Free the scene."""
        self.world.close()
        super().close()


@final
class GenesisBatch(RecordBatch):
    """A batch whose worlds are the parallel environments of one Genesis scene."""

    def advance(self, steps: int) -> None:
        """Take steps; raise `EngineError` if a state of any world is no longer finite."""
        with errors_told():
            super().advance(steps)

    def close(self) -> None:
        """Free the scene."""
        self._worlds.close()
        super().close()


#: Words in Genesis's message that a state is no longer finite.
NOT_FINITE = "causing 'nan'"


@contextmanager
def errors_told() -> Iterator[None]:
    """Raise as `EngineError` any exception of Genesis's own type that is raised in the block."""
    genesis = import_module("genesis")
    try:
        yield
    except genesis.GenesisException as error:
        kind = ("not-finite",) if NOT_FINITE in str(error) else ()
        raise EngineError(f"Genesis: {error}", *kind) from None


def _method(name: str, summary: str, *, as_shipped: bool = False) -> Method:
    """Return a method, of first order, named `name`.

    It uses Genesis's integrator of this name, or, if `as_shipped` is true, the default one.
    `summary` describes it in a few words.
    """
    setup = "" if as_shipped else SETUP.format(name)
    return Method(name, 1, 1, summary, COMMON_EFFECTS, as_shipped=as_shipped, setup=setup)


@final
class Genesis(WorldEngine):
    """The engine Genesis, with the body on a free or ball joint; each integrator is a method."""

    session = GenesisSession
    reader = GenesisModelReader()
    name = "genesis"
    package = "genesis"
    single_precision = True
    has_batches = restarts_batches = True
    stock_timestep = 0.01
    methods = (
        _method("Euler", "semi-implicit Euler in joint coordinates"),
        _method("implicitfast", "Euler, implicit in damping; free bodies by implicit midpoint"),
        _method("approximate_implicitfast", "likewise, with one mass matrix a step"),
        _method("default", "as shipped: approximate_implicitfast, every pass on", as_shipped=True),
    )

    @property
    def version(self) -> str:
        """The version of the installed distribution."""
        return version("genesis-world")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Return a session of a new Genesis scene.

        Kernels that are compiled are stored in the user's cache.
        """
        with kernels_kept():
            return super().open(scenario, method, timestep)

    def open_batch(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Batch:
        """Open a batch as one Genesis scene, with a world for each of `scenarios`."""
        with kernels_kept():
            return GenesisBatch(f"{__package__}.world", scenarios, method.name, timestep)
