"""Newton's rigid-body solvers, in single precision, on the CPU.

What it does to a top by default, and how each effect was measured: docs/measured/engines-2026.md.
"""

import warnings
from collections.abc import Iterator
from typing import Any, final

import numpy as np

from ....scenarios import PUSHED, FloatArray, Scenario
from ...checks.read_back import UnsupportedError
from ...method import COMMON_EFFECTS, Method
from ...native_output import native_output
from ...scene_record import HeldRotor, WorldBody
from ...session import Session
from ...user_cache import user_cache
from ...world_engine import WorldEngine
from ...world_parts import matrix, push
from ...world_session import WorldSession

#: A rotor is a link on a revolute or fixed joint.
EFFECTS = COMMON_EFFECTS | {"rotors"}
#: 1/s, of its sources: `angular_damping` of two solvers, `_DEFAULT_ANGULAR_DAMPING` of Steel.
DAMPING = 0.05
#: Solvers whose joints have no armature, by which the spin of a driven rotor would be kept.
WITHOUT_ARMATURE = ("semi-implicit", "xpbd", "vbd")
#: Relative rounding of numbers in single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)
#: What users write to have a solver.
SETUP = """\
solver = newton.solvers.Solver{}
solver.step(state_in, state_out, control, contacts, TIMESTEP)"""
MUJOCO = 'MuJoCo(model, integrator="{}", disable_contacts=True)'
UNDAMPED = "{}(model, angular_damping=0.0)"


@final
class NewtonSession(WorldSession):
    """One body in a model of its own, its frame at the joint."""

    def world_body(self) -> WorldBody:
        """The body as the solver holds it."""
        arm = None if self.scene["arm"] is None else np.zeros(3)
        first, *others = self._held()
        rotors = zip(others, self.world.model.joint_type.numpy()[1:], strict=True)
        return WorldBody(*first, arm, [self._rotor(k, *one) for k, one in enumerate(rotors, 1)])

    def _held(self) -> list[tuple[float, FloatArray, FloatArray]]:
        """Mass, com and tensor about it of each body, in its own axes."""
        model, held = self.world.model, getattr(self.world.solver, "mjw_model", None)
        if held is None:
            arrays = model.body_mass, model.body_com, model.body_inertia
            return list(zip(*(array.numpy().astype(float) for array in arrays), strict=True))
        names = ("body_mass", "body_ipos", "body_inertia", "body_iquat")
        # Of the first world; its first body is the ground.
        rows = zip(*(getattr(held, name).numpy()[0][1:].astype(float) for name in names), strict=True)
        return [
            (mass, com, matrix(q) @ np.diag(moments) @ matrix(q).T) for mass, com, moments, q in rows
        ]

    def _rotor(self, number: int, body: Any, kind: int) -> HeldRotor:
        """A rotor, whose axes are the body's at the joint's angle 0."""
        mass, com, tensor = body
        model = self.world.model
        place = model.joint_X_p.numpy()[number, :3] + com
        turns = kind == self.module.newton.JointType.REVOLUTE
        axis = model.joint_axis.numpy()[model.joint_qd_start.numpy()[number]] if turns else np.zeros(3)
        return HeldRotor(mass, place, tensor, axis)

    def active(self) -> frozenset[str]:
        """What acts, as reported by the model and the solver."""
        world, model, scenario = self.world, self.world.model, self.scenario
        motion, gravity = world.motion(), model.gravity.numpy()[0].astype(float)
        wanted = push(self.scene, matrix(motion[:4]), motion[4:7])
        world.push()
        force, torque = np.split(world.now.body_f.numpy()[0].astype(float), 2)
        pushed_right = np.linalg.norm(torque - wanted) <= SLACK * np.linalg.norm(wanted)
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
        stated_effects = scenario.called_for & PUSHED
        return frozenset(acting | stated_effects if torque.any() else acting)

    def _damping(self) -> float:
        """1/s, of ω, by the solver."""
        model = self.world.model
        if hasattr(model, "steel"):
            return float(model.steel.rigid_body_angular_damping.numpy()[0]) * (
                model.joint_type.numpy()[0] == self.module.newton.JointType.FREE
            )
        return float(getattr(self.world.solver, "angular_damping", 0.0))

    def _wrong_hinges(self) -> Iterator[str]:
        """Joints that are other than the scene's, in words."""
        model = self.world.model
        armature, starts = model.joint_armature.numpy(), model.joint_qd_start.numpy()
        if armature[: starts[1]].any():
            yield "armature on the body's joint"
        for number, rotor in enumerate(self.scene.get("rotors", ()), 1):
            held = float(armature[starts[number] : starts[number + 1]].sum())
            if (held > 0) != (rotor["hinge"] == "driven"):
                yield f"rotor {number} with {held:g} kg m² on a {rotor['hinge']} hinge"


def _clean(name: str, order: int, summary: str, solver: str) -> Method:
    return Method(name, order, order, summary, EFFECTS, setup=SETUP.format(solver))


def _shipped(name: str, summary: str, damping: float = 0.0) -> Method:
    return Method(name, 1, 1, f"as shipped: {summary}", EFFECTS, as_shipped=True, damping=damping)


@final
class Newton(WorldEngine):
    """A body on a free or ball joint, by each of Newton's solvers of rigid bodies."""

    session = NewtonSession
    name = "newton"
    package = "newton"
    step_seconds = 50e-6
    single_precision = True
    methods = (
        _clean("mujoco-rk4", 4, "MuJoCo Warp's Runge-Kutta", MUJOCO.format("rk4")),
        _clean(
            "mujoco-implicitfast",
            1,
            "MuJoCo Warp's, implicit in velocity",
            MUJOCO.format("implicitfast"),
        ),
        _clean("mujoco-euler", 1, "MuJoCo Warp's semi-implicit Euler", MUJOCO.format("euler")),
        _clean("mujoco-discrete", 1, "MuJoCo Warp's discrete Euler", MUJOCO.format("discrete")),
        _clean(
            "featherstone",
            1,
            "semi-implicit Euler in joint coordinates",
            UNDAMPED.format("Featherstone"),
        ),
        _clean("steel", 1, "symplectic Euler in joint coordinates", "Steel(model)"),
        _clean(
            "semi-implicit",
            1,
            "semi-implicit Euler of bodies, joints as springs",
            UNDAMPED.format("SemiImplicit"),
        ),
        _clean("xpbd", 1, "extended position-based dynamics, two iterations", "XPBD(model)"),
        _clean("vbd", 1, "vertex block descent of bodies", "VBD(model)"),
        _shipped("default", "SolverMuJoCo, implicitfast"),
        _shipped("featherstone-default", "SolverFeatherstone, damping 0.05 /s", DAMPING),
        _shipped("steel-default", "SolverSteel, damping 0.05 /s of free bodies", DAMPING),
        _shipped("semi-implicit-default", "SolverSemiImplicit, damping 0.05 /s", DAMPING),
    )

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Build the model and the solver; kernels are compiled once, into the user's cache."""
        driven = any(rotor.hinge == "driven" for rotor in scenario.rotors.each)
        if driven and method.name.removesuffix("-default") in WITHOUT_ARMATURE:
            raise UnsupportedError(
                f"Newton's solver {method.name} has no joint armature, by which the spin of a "
                "driven rotor would be kept; use a solver in joint coordinates, such as mujoco-rk4",
                "effects",
            )
        with native_output(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import warp

            warp.config.kernel_cache_dir = str(user_cache() / "warp")
            return super().open(scenario, method, timestep)
