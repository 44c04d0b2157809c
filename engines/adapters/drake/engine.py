"""Drake, multibody dynamics with integrators of fixed step, in double precision.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, final

import numpy as np
from spincheck.engine import (
    COMMON_EFFECTS,
    Derivative,
    EngineError,
    FloatArray,
    Method,
    State,
    along,
    in_chart,
)

from ...scene_record import HeldRotor, WorldBody
from ...world_engine import WorldEngine
from ...world_session import WorldSession

#: A table is modelled by two slides under a ball joint, a rotor's hinge by a revolute joint.
EFFECTS = COMMON_EFFECTS | {"rotors", "table"}


def _method(name: str, order: int, summary: str, as_shipped: bool = False) -> Method:
    """Return the method of one of Drake's integration schemes, or of a discrete plant.

    A discrete plant steps itself, without an integrator.

    Parameters
    ----------
    name : the scheme's name in Drake, or "discrete" or "default" for a discrete plant
    order : declared order of accuracy, of ω and of the attitude
    summary : the method in a few words
    as_shipped : whether the method keeps all of Drake's defaults
    """
    setup = f"""\
plant = MultibodyPlant(time_step=0.0)
config = SimulatorConfig(
    integration_scheme="{name}", max_step_size=TIMESTEP, use_error_control=False
)
ApplySimulatorConfig(config, simulator)"""
    return Method(
        name,
        order,
        order,
        summary,
        EFFECTS,
        as_shipped=as_shipped,
        setup="plant = MultibodyPlant(time_step=TIMESTEP)" if name == "discrete" else setup,
    )


@final
class DrakeSession(WorldSession):
    """A session of one body in a Drake plant of its own; the body's origin is at its joint.

    Raises
    ------
    EngineError
        From `advance`, if the ball joint becomes singular, at a pitch of 90°, or if Drake reports
        another error; the message is Drake's.
    """

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and the timestep, s, if one is given (`Session.restart`).

        A discrete plant is built anew if its timestep changes.
        """
        if self.world.is_discrete and timestep not in (None, self.timestep):
            self.world = self.module.World(self.scene, self.world.method, timestep)
        super().restart(state, timestep)

    def world_body(self) -> WorldBody:
        """Return the body as Drake holds it: mass, com, tensor, held point and rotors.

        The origin is the joint; axes are those of the scene record.
        """
        arm = None if self.world.is_free else np.zeros(3)
        return WorldBody(
            *self._mass_of(self.world.body),
            arm,
            [self._rotor(joint) for joint in self.world.rotors],
        )

    def _mass_of(self, body: Any) -> tuple[float, FloatArray, FloatArray]:
        """Return a body's mass, kg, com, m, and tensor about the com, kg m², in its own frame."""
        spatial = body.CalcSpatialInertiaInBodyFrame(self.world.context)
        mass, com = spatial.get_mass(), np.array(spatial.get_com())
        about_origin = spatial.CalcRotationalInertia()
        about_com = about_origin.ShiftToCenterOfMass(mass, com).CopyToFullMatrix3()
        return mass, com, np.array(about_com)

    def _rotor(self, joint: Any) -> HeldRotor:
        """Return the child body of a joint as a rotor, at joint angle 0.

        Its vectors are in the axes and from the origin of the parent body.
        """
        mass, com, inertia_com = self._mass_of(joint.child_body())
        at = joint.frame_on_parent().GetFixedPoseInBodyFrame()
        R = at.rotation().matrix()
        turns = joint.type_name() == self.module.drake.RevoluteJoint.kTypeName
        axis = R @ joint.revolute_axis() if turns else np.zeros(3)
        return HeldRotor(mass, at @ com, R @ inertia_com @ R.T, axis)

    def advance(self, steps: int) -> None:
        """Let the world take steps; raise Drake's errors as `EngineError`."""
        try:
            self.world.advance(steps)
        except RuntimeError as error:
            words = " ".join(str(error).split())
            singular = "singularity" in words
            raise EngineError(f"Drake: {words}", "warning" if singular else "refused") from None

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the one derivative that Drake computes, by `AutoDiffXd`; its key is a name for it.

        It is the Jacobian of steps for a discrete plant, and the derivative of dω/dt for any other.
        """
        if self.world.is_discrete:
            update = Derivative(self._derivative, through=self._derivative)
            return {"AutoDiff of the discrete update": update}
        return {"AutoDiff of dω/dt": Derivative(self._derivative)}

    def _derivative(self, steps: int = 1) -> FloatArray:
        """Return the derivative of `steps` steps, or of dω/dt, in the chart.

        For a discrete plant it is that of the steps, (6, 6). For a plant with an integrator it is
        that of dω/dt, (3, 6), and `steps` is ignored.

        Raises
        ------
        UnsupportedError
            If the scene has torques that are applied from outside the plant.
        EngineError
            If Drake cannot differentiate the plant.
        """
        try:
            autodiff: Any = import_module(f"{__package__}.autodiff")
            q, numbers = autodiff.differentiated(self.world, steps)
        except RuntimeError as error:
            words = " ".join(str(error).split())
            raise EngineError(f"Drake: {words}", "refused") from None
        derivative = in_chart(q, numbers) if self.world.is_discrete else numbers
        return along(self.frame.body_from_axes.as_matrix(), derivative)

    def check(self) -> None:
        """Raise `EngineError` unless Drake has counted as many steps as were asked for."""
        simulator, taken = self.world.simulator, self.world.taken
        if self.world.is_discrete:
            count = simulator.get_num_unrestricted_updates()
        else:
            count = simulator.get_integrator().get_num_steps_taken()
        if count != taken:
            raise EngineError(f"Drake took {count} steps, not {taken}", "clock")

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the plant.
        """
        plant, joint = self.world.plant, self.world.joint
        slides, rotors = self.world.slides, self.world.rotors
        turns = joint.type_name() == self.module.drake.BallRpyJoint.kTypeName
        named = {
            **self.gravity_by(np.array(plant.gravity_field().gravity_vector())),
            **self.damped_by(np.array(joint.GetDampingVector(self.world.context)).tolist()),
            "pivot": turns and not slides,
            "table": turns and len(slides) == 2,
            "rotors": bool(rotors),
            **dict.fromkeys(self._wrong_hinges(), True),
            **self.pushed_by(self._felt_torque()),
            "joints": plant.num_joints() != 1 + len(slides) + len(rotors),
            # Drake counts gravity as one of the plant's force elements.
            "force elements": plant.num_force_elements() > 1,
            "contact geometry": plant.geometry_source_is_registered(),
        }
        return frozenset(name for name, acts in named.items() if acts)

    def _wrong_hinges(self) -> Iterator[str]:
        """Yield, in words, how the joints of rotors differ from what the scene states.

        Actuators of other joints are described, too.
        """
        plant, context = self.world.plant, self.world.context
        drives = {
            int(actuator.joint().index()): actuator.calc_reflected_inertia(context)
            for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
        }
        described = self.scene.get("rotors", ())
        for number, (rotor, joint) in enumerate(zip(described, self.world.rotors, strict=True), 1):
            driven = drives.pop(int(joint.index()), 0.0)
            if driven != self.module.drive(rotor):
                yield f"rotor {number} with {driven:g} kg m² on a {rotor['hinge']} hinge"
            if joint.GetDampingVector(context).any():
                yield f"damping on the hinge of rotor {number}"
            if np.any(self._mass_of(joint.child_body())[1]):
                yield f"rotor {number} on a hinge beside its centre of mass"
        yield from (f"an actuator of {inertia:g} kg m²" for inertia in drives.values())

    def _felt_torque(self) -> FloatArray:
        """Return the torque that the plant receives at its input port, N m, world axes, (3,)."""
        port, context = self.world.plant.get_applied_spatial_force_input_port(), self.world.context
        forces = port.Eval(context) if port.HasValue(context) else []
        return sum((np.array(force.F_Bq_W.rotational()) for force in forces), np.zeros(3))


@final
class Drake(WorldEngine):
    """The engine Drake, with a free body on a quaternion joint, and a held one on a ball joint.

    The coordinates of the ball joint are roll, pitch and yaw.
    """

    session = DrakeSession
    name = "drake"
    package = "pydrake"
    # The default of MultibodyPlantConfig.time_step.
    stock_timestep = 1e-3
    # Orders are those of Drake's documentation of the integrators; they were confirmed by
    # measurement (docs/measured/engines-more.md).
    methods = (
        _method("runge_kutta5", 5, "Runge-Kutta of fifth order"),
        _method("runge_kutta3", 3, "Runge-Kutta of third order"),
        _method("semi_explicit_euler", 1, "semi-implicit Euler"),
        _method("discrete", 1, "the plant's own steps, without an integrator"),
        _method("default", 1, "as shipped: as discrete, with a scene graph", as_shipped=True),
    )
