"""Newton's rigid-body solvers, in single precision, on the CPU.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from importlib import import_module
from typing import Any, final

import numpy as np
from spincheck.engine import (
    COMMON_EFFECTS,
    Batch,
    Derivative,
    FloatArray,
    Method,
    Release,
    Scenario,
    Session,
    UnsupportedError,
    along,
)

from ...scene_record import HeldRotor, WorldBody
from ...version_numbers import numbers_of
from ...warp_kernels import kernels_kept, use_warp_device, warp_device
from ...world_engine import WorldEngine
from ...world_parts import matrix, push
from ...world_session import RecordBatch, WorldSession
from .model_reader import NewtonModelReader

#: Effects that solvers in joint coordinates can simulate. A rotor is a link on a revolute or fixed
#: joint, with an armature if it is driven. The other solvers have no armatures, and so do not
#: simulate rotors.
EFFECTS = COMMON_EFFECTS | {"rotors"}
#: Version of MuJoCo and MuJoCo Warp that each version of Newton requires, from its metadata. For a
#: version of Newton that is not listed, the version of the newest one is taken.
MUJOCO: dict[tuple[int, ...], str] = {(1, 8): "3.17.0", (1, 7): "3.15.0"}
#: Relative tolerance of numbers that were rounded to single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)
#: The smallest positive normal number of single precision.
SMALLEST = float(np.finfo(np.float32).tiny)
#: Lines by which users make a solver and take a step.
SETUP = """\
solver = newton.solvers.Solver{}
solver.step(state_in, state_out, control, contacts, TIMESTEP)"""


@final
class NewtonSession(WorldSession):
    """A session of one body in a Newton model of its own; the body's origin is at its joint."""

    def world_body(self) -> WorldBody:
        """Return the body as the solver holds it: mass, com, tensor, held point and rotors.

        The origin is the joint; axes are those of the scene record.
        """
        arm = None if self.scene["arm"] is None else np.zeros(3)
        first, *others = self._bodies()
        rotors = zip(others, self.world.model.joint_type.numpy()[1:], strict=True)
        return WorldBody(*first, arm, [self._rotor(k, *one) for k, one in enumerate(rotors, 1)])

    def _bodies(self) -> list[tuple[float, FloatArray, FloatArray]]:
        """Return each body's mass, kg, com, m, and tensor about the com, kg m², in its own axes."""
        model, solved = self.world.model, getattr(self.world.solver, "mjw_model", None)
        if solved is None:
            arrays = model.body_mass, model.body_com, model.body_inertia
            return list(zip(*(array.numpy().astype(float) for array in arrays), strict=True))
        names = ("body_mass", "body_ipos", "body_inertia", "body_iquat")
        # The arrays have a row for each world; the first body of a world is the ground.
        rows = zip(
            *(getattr(solved, name).numpy()[0][1:].astype(float) for name in names), strict=True
        )
        return [
            (mass, com, matrix(q) @ np.diag(moments) @ matrix(q).T)
            for mass, com, moments, q in rows
        ]

    def _rotor(self, number: int, body: Any, kind: int) -> HeldRotor:
        """Return a rotor at joint angle 0, where its axes coincide with those of the body.

        Parameters
        ----------
        number : index of the rotor's joint
        body : mass, com and tensor of the rotor, in its own axes, from `_bodies`
        kind : Newton's type of the joint
        """
        mass, com, tensor = body
        model = self.world.model
        place = model.joint_X_p.numpy()[number, :3] + com
        turns = kind == self.module.newton.JointType.REVOLUTE
        axis = (
            model.joint_axis.numpy()[model.joint_qd_start.numpy()[number]] if turns else np.zeros(3)
        )
        return HeldRotor(mass, place, tensor, axis)

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the Jacobian of steps that Warp's tape computes, under the name "Warp's tape"."""
        return {"Warp's tape": Derivative(self._taped, through=self._taped)}

    def _taped(self, steps: int = 1) -> FloatArray:
        """Return the Jacobian of the next `steps` steps, in the chart, (6, 6).

        `UnsupportedError` is raised if the solver does not accept a model with gradients.
        """
        motion = self.frame.motion(self.read_state())
        try:
            with kernels_kept():
                found = self._tape.jacobian(motion, self.timestep, steps)
        except NotImplementedError as error:
            raise UnsupportedError(f"Newton: {error}") from None
        return along(self.frame.body_from_axes.as_matrix(), found)

    @cached_property
    def _tape(self) -> Any:
        """A second model of the scene, in which steps are differentiated; made on first use."""
        return import_module(f"{__package__}.tape").Tape(self.world)

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from Newton.
        """
        world, model, scenario = self.world, self.world.model, self.scenario
        motion, gravity = world.motion(), model.gravity.numpy()[0].astype(float)
        drag = self.scene["drag"]
        wanted = push(self.scene, matrix(motion[:4]), motion[4:7])
        world.push(world.now)
        force, torque = np.split(world.now.body_f.numpy()[0].astype(float), 2)
        # Drag and torques may nearly cancel, so rounding is relative to the sum of their sizes.
        terms = self.scene["torque_body"], self.scene["torque_world"], drag * motion[4:7]
        size = sum(map(np.linalg.norm, terms))
        pushed_right = np.linalg.norm(torque - wanted) <= SLACK * size + SMALLEST
        right = np.allclose(gravity, scenario.gravity_world, rtol=SLACK, atol=0)
        kinds, rotors = model.joint_type.numpy(), self.scene.get("rotors", ())
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": kinds[0] == self.module.newton.JointType.BALL,
            "rotors": bool(rotors),
            **dict.fromkeys(self._wrong_hinges(), True),
            f"a torque of {torque.tolist()} N m": not pushed_right or force.any(),
            "damping": self._damping() != 0,
            "joint damping": model.joint_damping.numpy().any(),
            "joint friction": model.joint_friction.numpy().any(),
            "a collision shape": model.shape_count > 0,
            "other bodies": model.body_count != 1 + len(rotors),
        }
        acting = {name for name, acts in named.items() if acts}
        stated_effects = scenario.called_for & scenario.pushed.keys()
        # A torque that is too small for single precision counts as applied.
        is_pushed = torque.any() or np.linalg.norm(wanted) <= SMALLEST
        return frozenset(acting | stated_effects if is_pushed else acting)

    def _damping(self) -> float:
        """Return the rate at which the solver itself damps ω, 1/s; 0 if it does not damp it."""
        model: Any = self.world.model
        if not hasattr(model, "steel"):
            return float(getattr(self.world.solver, "angular_damping", 0.0))
        is_free = model.joint_type.numpy()[0] == self.module.newton.JointType.FREE
        return float(model.steel.rigid_body_angular_damping.numpy()[0] * is_free)

    def _wrong_hinges(self) -> Iterator[str]:
        """Yield a description of each joint that has an armature but no drive, or the reverse."""
        model = self.world.model
        armature, starts = model.joint_armature.numpy(), model.joint_qd_start.numpy()
        if armature[: starts[1]].any():
            yield "armature on the body's joint"
        for number, rotor in enumerate(self.scene.get("rotors", ()), 1):
            armed = float(armature[starts[number] : starts[number + 1]].sum())
            if (armed > 0) != (rotor["hinge"] == "driven"):
                yield f"rotor {number} with {armed:g} kg m² on a {rotor['hinge']} hinge"


def _clean(
    name: str, order: int, summary: str, solver: str, effects: frozenset[str] = EFFECTS
) -> Method:
    """Return a clean method.

    Parameters
    ----------
    name : name of the method
    order : declared order of accuracy, of ω and of the attitude
    summary : the method in a few words
    solver : Python code, the call that makes Newton's solver; `Method.setup` contains it
    effects : names of the effects that the method can simulate
    """
    return Method(name, order, order, summary, effects, setup=SETUP.format(solver))


def _mujoco(integrator: str, order: int, summary: str) -> Method:
    """Return the clean method that uses one of MuJoCo Warp's integrators.

    Parameters
    ----------
    integrator : the integrator's name in Newton
    order : declared order of accuracy, of ω and of the attitude
    summary : the integrator in a few words
    """
    solver = f'MuJoCo(model, integrator="{integrator}", disable_contacts=True)'
    return _clean(f"mujoco-{integrator}", order, f"MuJoCo Warp's {summary}", solver)


def _shipped(name: str, summary: str, effects: frozenset[str] = EFFECTS) -> Method:
    """Return the method `name` as shipped, of first order: a solver of Newton's with its defaults.

    `summary` describes the solver in a few words; `effects` names the effects that it can simulate.
    """
    return Method(name, 1, 1, f"as shipped: {summary}", effects, as_shipped=True)


@final
class Newton(WorldEngine):
    """The engine Newton, with the body on a free or ball joint; methods are Newton's solvers."""

    session = NewtonSession
    reader = NewtonModelReader()
    name = "newton"
    package = "newton"
    single_precision = True
    has_batches = restarts_batches = True
    methods = (
        _mujoco("rk4", 4, "Runge-Kutta"),
        _mujoco("implicitfast", 1, "Euler, implicit in velocity"),
        _mujoco("euler", 1, "semi-implicit Euler"),
        _mujoco("discrete", 1, "discrete Euler"),
        # This solver does not use its `angular_damping`: a method as shipped would be the same.
        _clean(
            "featherstone", 1, "semi-implicit Euler in joint coordinates", "Featherstone(model)"
        ),
        _clean(
            "steel",
            1,
            "symplectic Euler in joint coordinates",
            "Steel(model)\nmodel.steel.rigid_body_angular_damping.zero_()",
        ),
        _clean(
            "semi-implicit",
            1,
            "semi-implicit Euler of bodies, joints as springs",
            "SemiImplicit(model, angular_damping=0.0)",
            COMMON_EFFECTS,
        ),
        _clean(
            "xpbd",
            1,
            "position-based dynamics, two iterations a step",
            "XPBD(model)",
            COMMON_EFFECTS,
        ),
        _shipped("default", "SolverMuJoCo, implicitfast"),
        _shipped("steel-default", "SolverSteel, damping 0.05 /s of free bodies"),
        _shipped(
            "semi-implicit-default",
            "SolverSemiImplicit, damping 0.05 /s",
            COMMON_EFFECTS,
        ),
    )

    def at_version(self, version: str) -> Release:
        """Return what to install for a version of Newton, and the methods.

        MuJoCo's packages are installed in the versions that Newton requires.
        """
        mujoco = MUJOCO.get(numbers_of(version)[:2], MUJOCO[1, 8])
        parts = f"newton=={version}", f"mujoco=={mujoco}", f"mujoco-warp=={mujoco}"
        return Release((*parts, "warp-lang>=1.17"), self.methods)

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Return a session of a new model and solver.

        Kernels that are compiled are stored in the user's cache.
        """
        with kernels_kept():
            return super().open(scenario, method, timestep)

    def use_device(self, name: str) -> None:
        """Make the device with Warp's name `name` step all scenes that are opened from now on."""
        use_warp_device(f"{__package__}.world", name)

    def open_batch(self, scenarios: Sequence[Scenario], method: Method, timestep: float) -> Batch:
        """Open a batch as one Newton model, with one world for each of the scenes."""
        with kernels_kept():
            world = f"{__package__}.world"
            return RecordBatch(world, scenarios, method.name, timestep, warp_device())
