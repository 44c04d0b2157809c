"""A PyBullet world and its steps as Python that needs `pybullet` and numpy alone."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import Scenario
from ...models.mjcf_contact import sphere_and_plane
from ...models.principal_frame import principal_frame
from ...models.text import python_lines, python_list
from ...models.urdf import urdf
from .load import (
    CLAMP,
    DAMPING,
    FRICTIONLESS,
    INERTIA,
    JOINT_MOTOR,
    BodyRepresentation,
    set_free,
    tip_sphere,
)

_START = """\
import os
import tempfile

import pybullet as p

URDF = (
{lines}
)
LINK = {link}  # -1 is the base; a body that hangs by a joint is link 0
Q_BODY_PRINCIPAL = {principal}  # w x y z: PyBullet turns the principal axes of the body
p.connect(p.DIRECT)
p.setGravity({gravity})
p.setTimeStep(TIMESTEP)
with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "top.urdf")
    with open(path, "w") as file:
        file.write(URDF)
    body = p.loadURDF(
        path, {position}, {attitude}, useMaximalCoordinates={maximal}, flags={flags}
    )
"""
NO_DAMPING = "p.changeDynamics(body, -1, linearDamping=0, angularDamping=0)"
NO_CLAMP = "p.changeDynamics(body, -1, maxJointVelocity=1e100)"
NO_MOTOR = (
    "p.setJointMotorControlMultiDof(body, 0, p.POSITION_CONTROL, "
    "targetPosition=[0, 0, 0, 1], positionGain=0, velocityGain=0, force=[0, 0, 0])"
)
EXACT_SOLVER = "p.setPhysicsEngineParameter(constraintSolverType=p.CONSTRAINT_SOLVER_LCP_DANTZIG)"
CONTACT = (
    "p.setPhysicsEngineParameter(contactSlop=0)",
    "for one in (plane, body):",
    f"    p.changeDynamics(one, -1, **{FRICTIONLESS!r})",
)
STRONG_TIE = "p.changeConstraint(tie, maxForce=1e100)"
_STEPS = """

def motion():
    \"\"\"Attitude of the principal axes, x y z w, and angular velocity, world axes.\"\"\"
    if LINK == -1:
        return p.getBasePositionAndOrientation(body)[1], p.getBaseVelocity(body)[1]
    link = p.getLinkState(body, LINK, 1, 1)
    return link[1], link[7]


def step(count):
    for _ in range(count):
{pushes}        p.stepSimulation()


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    (x, y, z, w), omega_world = motion()
    q = product(np.array([w, x, y, z]), conjugate(np.array(Q_BODY_PRINCIPAL)))
    return q, turned(conjugate(q), np.array(omega_world))
"""


def setup(representation: BodyRepresentation) -> str:
    """What users write who load a URDF of their own, its pivot a joint or a constraint."""
    maximal = ", useMaximalCoordinates=True" if representation.maximal else ""
    pivot = (
        ["# on a spherical joint:", NO_MOTOR]
        if representation.hung and not representation.maximal
        else ["# tied to a point:", EXACT_SOLVER, STRONG_TIE]
    )
    if representation.by_contact:
        pivot = ["# on a plane, of both bodies:", *CONTACT]
    load = f'body = p.loadURDF("body.urdf", flags=p.URDF_USE_INERTIA_FROM_FILE{maximal})'
    return "\n".join(["p.setTimeStep(TIMESTEP)", load, NO_DAMPING, NO_CLAMP, *pivot])


def script(scenario: Scenario, representation: BodyRepresentation, timestep: float) -> str:  # noqa: ARG001
    """The world of a method; its timestep is the script's `TIMESTEP`."""
    hung = representation.hung and scenario.constraint.is_pivot
    world_from_body = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)
    frame = principal_frame(scenario.carrier).q_body_axes_wxyz
    position, attitude = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    if not hung:
        attitude = world_from_body.as_quat()
        if not scenario.constraint.is_pivot:
            arm_world = world_from_body.apply(np.array(scenario.body.com))
            position = scenario.start.position_world - arm_world
    sphere = tip_sphere(scenario) if representation.by_contact else None
    posed = scenario if hung else set_free(scenario)
    text = urdf(posed, sphere=sphere, has_box=representation.as_shipped)
    start = _START.format(
        lines=python_lines(text),
        link=0 if hung else -1,
        principal=python_list(frame),
        gravity=", ".join(repr(float(g)) for g in scenario.gravity_world),
        position=python_list(position),
        attitude=python_list(attitude),
        maximal=representation.maximal,
        flags=0 if INERTIA in representation.defaults else "p.URDF_USE_INERTIA_FROM_FILE",
    )
    principal = Rotation.from_quat(frame, scalar_first=True)
    settings = "".join(f"{line}\n" for line in _settings(scenario, representation, principal, hung))
    pushes = "".join(f"        {line}\n" for line in _pushes(scenario, principal, hung))
    return start + settings + _STEPS.format(pushes=pushes)


def _settings(
    scenario: Scenario, representation: BodyRepresentation, principal: Rotation, hung: bool
) -> Iterator[str]:
    """What is taken away, what holds the body, and its start."""
    world_from_body = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)
    omega_body = np.array(scenario.start.omega_body)
    yield from _hinges(scenario, representation, first_link=1 if hung else 0)
    if DAMPING not in representation.defaults:
        yield NO_DAMPING
    if CLAMP not in representation.defaults:
        yield NO_CLAMP
    if hung:
        if JOINT_MOTOR not in representation.defaults:
            yield NO_MOTOR
        if drag := scenario.pushed["drag"]:
            yield f"p.changeDynamics(body, 0, jointDamping={drag!r})"
        q_joint = (principal.inv() * world_from_body * principal).as_quat()
        omega = python_list(principal.inv().apply(omega_body))
        yield f"p.resetJointStateMultiDof(body, 0, {python_list(q_joint)}, {omega})"
        return
    velocity = scenario.start.velocity_world
    if scenario.constraint.is_pivot:
        yield EXACT_SOLVER
        anchor = "-1"
        if representation.maximal:
            yield "anchor = p.createMultiBody(baseMass=0, useMaximalCoordinates=True)"
            anchor = "anchor"
        pivot = python_list(principal.inv().apply(-np.array(scenario.carrier.com)))
        yield (
            f"tie = p.createConstraint(body, -1, {anchor}, -1, p.JOINT_POINT2POINT, "
            f"[0, 0, 0], {pivot}, [0, 0, 0])"
        )
        yield STRONG_TIE
        velocity = world_from_body.apply(np.cross(omega_body, scenario.body.com))
    if representation.by_contact:
        yield from _table(scenario)
    omega_world = world_from_body.apply(omega_body)
    if scenario.rotors:
        arm_world = world_from_body.apply(scenario.body.com - scenario.carrier.com)
        velocity = velocity - np.cross(omega_world, arm_world)
    yield f"p.resetBaseVelocity(body, {python_list(velocity)}, {python_list(omega_world)})"


def _table(scenario: Scenario) -> Iterator[str]:
    """The plane under the body."""
    yield "plane = p.createCollisionShape(p.GEOM_PLANE)"
    height = sphere_and_plane(scenario)[1]
    yield f"plane = p.createMultiBody(0, plane, basePosition=[0, 0, {height!r}])"
    yield from CONTACT


def _hinges(
    scenario: Scenario, representation: BodyRepresentation, first_link: int
) -> Iterator[str]:
    """The motors that are taken away, the drives, and the spins at the start."""
    if scenario.rotors and not representation.as_shipped:
        yield EXACT_SOLVER
    for link, rotor in enumerate(scenario.rotors.each, start=first_link):
        spin = float(rotor.spin)
        motor = f"p.setJointMotorControl2(body, {link}, p.VELOCITY_CONTROL, targetVelocity"
        if rotor.hinge == "driven":
            yield f"{motor}={spin!r}, force=1e100)"
        elif rotor.hinge == "free" and JOINT_MOTOR not in representation.defaults:
            yield f"{motor}=0, force=0)"
        if rotor.hinge != "locked":
            yield f"p.resetJointState(body, {link}, 0, {spin!r})"


def _pushes(scenario: Scenario, principal: Rotation, hung: bool) -> Iterator[str]:
    """Torques, which PyBullet forgets after each step."""
    if scenario.pushed["torque_world"].any():
        torque = python_list(scenario.pushed["torque_world"])
        yield f"p.applyExternalTorque(body, LINK, {torque}, p.WORLD_FRAME)"
    if scenario.pushed["torque_body"].any():
        torque = python_list(principal.inv().apply(np.array(scenario.pushed["torque_body"])))
        if hung:
            yield f"p.setJointMotorControlMultiDof(body, 0, p.TORQUE_CONTROL, force={torque})"
        else:
            yield f"p.applyExternalTorque(body, LINK, {torque}, p.LINK_FRAME)"
    if (coefficient := scenario.pushed["drag"]) and not hung:
        drag = f"[-{coefficient!r} * w for w in motion()[1]]"
        yield f"p.applyExternalTorque(body, LINK, {drag}, p.WORLD_FRAME)"
