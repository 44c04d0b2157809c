"""Brax's three pipelines, in single precision, on the CPU.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import final

import numpy as np
from spincheck.engine import Batch, Derivative, FloatArray, Method, Scenario, along

from ...scene_record import WorldBody, scene_record
from ...world_engine import WorldEngine
from ...world_session import WorldBatch, WorldSession

#: Effects that Brax can simulate. Brax applies forces along the coordinates of joints only; those
#: of a free joint, or of the three hinges of a pivot, cannot apply the scene's torques.
EFFECTS = frozenset({"gravity", "pivot"})
#: Relative tolerance of numbers that were rounded to single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)


@final
class BraxSession(WorldSession):
    """A session of one body in a Brax system of its own, with the body's origin at its joint."""

    def world_body(self) -> WorldBody:
        """Return the body as the system holds it: mass, com, tensor and the held point.

        The origin is the joint; axes are those of the scene record.
        """
        inertia = self.world.system.link.inertia
        mass, com, tensor = (
            np.asarray(one[0], dtype=float)
            for one in (inertia.mass, inertia.transform.pos, inertia.i)
        )
        return WorldBody(float(mass), com, tensor, None if self.world.is_free else np.zeros(3))

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the system.
        """
        system, gravity = self.world.system, np.asarray(self.world.system.gravity, dtype=float)
        right = np.allclose(gravity, self.scenario.gravity_world, rtol=SLACK, atol=0)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": system.link_types == "3",
            "damping": np.any(system.ang_damping) or np.any(system.vel_damping),
            "joint damping": np.any(system.dof.damping),
            "armature": np.any(system.dof.armature),
            "a fluid": bool(system.enable_fluid),
            "other bodies": system.num_links() != 1,
        }
        return frozenset(name for name, acts in named.items() if acts)

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the Jacobians of steps that JAX computes, by its modes: "jacfwd" and "jacrev".

        The mapping is empty unless the method uses the pipeline `generalized`.
        """
        if not self.world.is_generalized:
            return {}
        ways = {way: partial(self._derivative, way) for way in ("jacfwd", "jacrev")}
        return {way: Derivative(compute, through=compute) for way, compute in ways.items()}

    def _derivative(self, way: str, steps: int = 1) -> FloatArray:
        """Return the Jacobian of the next `steps` steps, in the chart, (6, 6).

        `way` is JAX's mode, "jacfwd" or "jacrev".
        """
        found = import_module(f"{__package__}.jacobian").jacobian(self.world, way, steps)
        return along(self.frame.body_from_axes.as_matrix(), found)


def _method(name: str, summary: str, *, as_shipped: bool = False) -> Method:
    """Return the method `name`, of first order, which uses Brax's pipeline of this name.

    `summary` describes it in a few words; `as_shipped` says whether it keeps all defaults.
    """
    setup = f"state = brax.{name}.pipeline.step(sys, state, act)"
    return Method(name, 1, 1, summary, EFFECTS, as_shipped=as_shipped, setup=setup)


@final
class Brax(WorldEngine):
    """The engine Brax, with the body on a free joint, or on three hinges at its pivot."""

    session = BraxSession
    name = "brax"
    package = "brax"
    single_precision = True
    has_batches = True
    stock_timestep = 0.002
    methods = (
        _method("generalized", "semi-implicit Euler in joint coordinates"),
        _method("spring", "semi-implicit Euler of bodies, joints as springs"),
        _method("positional", "position-based dynamics"),
        _method(
            "default", "as shipped: generalized, its mass matrix inverted roughly", as_shipped=True
        ),
    )

    def open_batch(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Batch:
        """Open a batch with a world for each scene; the model of equal scenes is compiled once."""
        module = import_module(f"{__package__}.world")
        worlds = {
            scenario: module.World(scene_record(scenario), method.name, timestep)
            for scenario in dict.fromkeys(scenarios)
        }
        return WorldBatch(module.Worlds([worlds[scenario] for scenario in scenarios]))
