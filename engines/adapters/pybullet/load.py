"""Puts a scene's body into a PyBullet world: loaded, stripped of defaults, held, set to its start.

Why each call is there, and what happens without it: docs/measured/engines-pybullet.md.
"""

import atexit
import shutil
import tempfile
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cache
from itertools import count
from pathlib import Path

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation

from ....scenarios import Effects, FloatArray, Scenario
from ....scenarios.gyrostat import Rotors
from ....scenarios.scenario import with_tables
from ...checks.read_back import EngineError, UnsupportedError
from ...models.description import PLAIN, Description
from ...models.mjcf_contact import sphere_and_plane
from ...models.urdf import urdf
from .as_shipped import idle_motor, take_away_clamp, take_away_damping, take_away_motor
from .hinges import Hinges
from .model import BASE, HUNG, Model

#: Names of the parts left out; they would change no motion.
SHAPE, MOTOR = "collision shape", "idle joint motor"
#: Defaults of PyBullet that alter motions; the third is of bodies on a joint.
INERTIA, DAMPING, JOINT_MOTOR, CLAMP = (
    "inertia of the shape",
    "damping",
    "joint motor",
    "velocity clamp",
)
DEFAULTS = (INERTIA, DAMPING, JOINT_MOTOR, CLAMP)
#: Of a contact.
FRICTIONLESS = {
    "lateralFriction": 0,
    "spinningFriction": 0,
    "rollingFriction": 0,
    "restitution": 0,
}
#: N, limit of a constraint's force. The default is an impulse of 500 N s a step.
UNREACHED_FORCE = 1e100
#: SIMD_EPSILON of Bullet's LinearMath/btScalar.h: values not above it are taken for zero.
TAKEN_FOR_ZERO = float(np.finfo(float).eps)


@dataclass(frozen=True)
class OwnURDF:
    """A user's URDF of one link, and its meshes, which are copied beside it."""

    data: bytes
    meshes: tuple[tuple[str, Path], ...]


@dataclass(frozen=True)
class BodyRepresentation:
    """How a method represents the body, and its pivot where there is one.

    Attributes
    ----------
    maximal : six coordinates a body (btRigidBody) instead of joint coordinates (btMultiBody)
    hung : whether the pivot is a spherical joint; otherwise a point-to-point constraint
    defaults : those of `DEFAULTS` that are kept
    own : the file that is loaded; the scene's URDF if None
    by_contact : whether a table is a contact of a sphere and a plane
    description : how the scene's URDF describes the body
    """

    maximal: bool
    hung: bool
    defaults: frozenset[str] = frozenset()
    own: OwnURDF | None = None
    description: Description = PLAIN
    by_contact: bool = False

    @property
    def as_shipped(self) -> bool:
        """Whether it is loaded as a user would, apart from defaults removed one by one."""
        return bool(self.defaults)


def left_out(scenario: Scenario, representation: BodyRepresentation) -> tuple[str, ...]:
    """Parts left out of the body that would change no motion."""
    if representation.as_shipped or representation.own or representation.by_contact:
        return ()
    return (SHAPE, MOTOR) if representation.hung and scenario.constraint.is_pivot else (SHAPE,)


def load(
    client: int, scenario: Scenario, representation: BodyRepresentation, left_in: Collection[str]
) -> Model:
    """Put the scene's body into an empty world, at its start, held as the scene says.

    Parameters
    ----------
    left_in : the names of `left_out` that are kept

    Raises
    ------
    UnsupportedError
        If the body is so small that PyBullet would leave out terms.
    EngineError
        If PyBullet cannot load the body.
    OSError
        If there is no file to load it from.
    """
    hung = representation.hung and scenario.constraint.is_pivot
    world_from_body = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)
    arm_world = world_from_body.apply(np.array(scenario.body.com))
    if not representation.as_shipped:
        _check_not_lost(scenario, representation)
    text = representation.own or _scenes_own(scenario, representation, left_in)
    if hung:
        body = _load_urdf(client, text, representation, np.zeros(3), Rotation.identity())
        model = _model_of_link(client, body, HUNG, scenario.rotors)
    else:
        is_held = scenario.constraint.is_pivot
        position = np.zeros(3) if is_held else scenario.start.position_world - arm_world
        body = _load_urdf(client, text, representation, position, world_from_body)
        if representation.maximal:
            model = _model_of_rigid_body(client, body, position, world_from_body)
        else:
            model = _model_of_link(client, body, BASE, scenario.rotors)
    if DAMPING not in representation.defaults:
        take_away_damping(model)
    if CLAMP not in representation.defaults:
        take_away_clamp(model)
    if hung and JOINT_MOTOR not in representation.defaults:
        # If it were removed first, it would not come back.
        idle_motor(model) if MOTOR in left_in else take_away_motor(model)
    if hung:
        model.set_joint_attitude(world_from_body)
    elif scenario.constraint.is_pivot:
        _tie_to_world(model, representation)
    if representation.by_contact:
        _lay_under(model, scenario)
    omega_world = world_from_body.apply(np.array(scenario.start.omega_body))
    at_pivot = np.cross(omega_world, arm_world)
    model.set_velocity(
        omega_world, at_pivot if scenario.constraint.is_pivot else scenario.start.velocity_world
    )
    if model.hinges:
        if JOINT_MOTOR not in representation.defaults:
            model.hinges.take_away_motors()
        if not representation.as_shipped:
            _solve_exactly(client)
        model.hinges.set(scenario.rotors.start_spins)
    return model


def _scenes_own(
    scenario: Scenario, representation: BodyRepresentation, left_in: Collection[str]
) -> OwnURDF:
    """The scene as URDF; what holds a body that does not hang by a joint is no part of it."""
    hung = representation.hung and scenario.constraint.is_pivot
    sphere: tuple[Iterable[float], float] | None = None
    if representation.by_contact:
        sphere = tip_sphere(scenario)
    elif SHAPE in left_in:
        sphere = scenario.body.com, _gyration_radius(scenario)
    text = urdf(
        scenario if hung else set_free(scenario),
        sphere=sphere,
        has_box=representation.as_shipped,
        description=representation.description,
    )
    return OwnURDF(text.encode(), ())


def _load_urdf(
    client: int,
    model: OwnURDF,
    representation: BodyRepresentation,
    position: FloatArray,
    attitude: Rotation,
) -> int:
    """Load a model with its frame's origin at `position` (3,) m; PyBullet's number for it.

    PyBullet caches files by name, so every file has a name of its own. The pose is given here and
    not set later: a rigid body keeps the inertia, in world axes, that it was loaded with until the
    end of its first step.
    """
    number = next(_numbers)
    file = Path(_folder(), f"{number}.urdf")
    try:
        file.write_bytes(model.data)
        if model.meshes:
            # Meshes too have names of their own, since they are cached as well.
            file = _beside_meshes(file, model.meshes)
        try:
            return int(
                p.loadURDF(
                    str(file),
                    position,
                    attitude.as_quat(),
                    useMaximalCoordinates=representation.maximal,
                    flags=0 if INERTIA in representation.defaults else p.URDF_USE_INERTIA_FROM_FILE,
                    physicsClientId=client,
                )
            )
        except p.error as error:
            # Raises the system's own error if the file cannot be opened.
            file.read_bytes()
            raise EngineError(f"PyBullet cannot load the body: {error}") from None
    finally:
        file.unlink(missing_ok=True)
        if model.meshes:
            shutil.rmtree(file.parent, ignore_errors=True)


def _beside_meshes(file: Path, meshes: tuple[tuple[str, Path], ...]) -> Path:
    """The file in a folder of its own, together with its meshes."""
    folder = file.with_suffix("")
    folder.mkdir()
    for name, mesh in meshes:
        Path(folder, name).symlink_to(mesh)
    return file.rename(folder / file.name)


_numbers = count()


@cache
def _folder() -> str:
    """A folder for files that PyBullet reads; of this process, and removed with it."""
    folder = tempfile.TemporaryDirectory(prefix="spincheck-", ignore_cleanup_errors=True)
    atexit.register(folder.cleanup)
    return folder.name


def _model_of_link(client: int, body: int, link: int, rotors: Rotors) -> Model:
    _, _, _, com, q_body_principal_xyzw, *_ = p.getDynamicsInfo(body, link, client)
    is_driven = np.array([rotor.hinge == "driven" for rotor in rotors.each])
    first = p.getNumJoints(body, client) - len(is_driven)
    hinges = Hinges(client, body, first, rotors.is_turning, is_driven) if rotors else None
    axes = Rotation.from_quat(q_body_principal_xyzw)
    return Model(client, body, link, axes, np.array(com), hinges)


def _model_of_rigid_body(
    client: int, body: int, position: FloatArray, world_from_body: Rotation
) -> Model:
    """The model of a rigid body, from the pose after loading: PyBullet does not report its frame.

    (For rigid bodies `getDynamicsInfo` returns uninitialised memory.)
    """
    com_world, q_world_principal_xyzw = p.getBasePositionAndOrientation(body, client)
    body_from_principal = world_from_body.inv() * Rotation.from_quat(q_world_principal_xyzw)
    com = world_from_body.inv().apply(np.array(com_world) - position)
    return Model(client, body, BASE, body_from_principal, com)


def set_free(scenario: Scenario) -> Scenario:
    """The scene's body without its pivot, which is then not part of the URDF."""
    return with_tables(scenario, effects=Effects())


def tip_sphere(scenario: Scenario) -> tuple[tuple[float, float, float], float]:
    """Centre, m, body axes, and radius, m, of the sphere that lies on the table."""
    table = scenario.effects.table
    assert table is not None
    return table.tip, sphere_and_plane(scenario)[0]


def _lay_under(model: Model, scenario: Scenario) -> None:
    """Put a plane under the body, both without friction or restitution.

    By default Bullet leaves contacts that are 1e-5 m deep, which shows in the limit of short steps.
    """
    p.setPhysicsEngineParameter(contactSlop=0, physicsClientId=model.client)
    client, height = model.client, sphere_and_plane(scenario)[1]
    shape = p.createCollisionShape(p.GEOM_PLANE, physicsClientId=client)
    plane = p.createMultiBody(0, shape, basePosition=[0, 0, height], physicsClientId=client)
    for body in (plane, model.body):
        p.changeDynamics(body, BASE, **FRICTIONLESS, physicsClientId=client)


def _gyration_radius(scenario: Scenario) -> float:
    """The body's radius of gyration about its com, m: about the size of a collision shape."""
    return float(np.sqrt(scenario.body.principal_moments[-1] / scenario.body.mass))


def _check_not_lost(scenario: Scenario, representation: BodyRepresentation) -> None:
    """Raise if Bullet would leave out terms, which it does below an absolute constant."""
    mass, moments = scenario.carrier.mass, scenario.carrier.principal_moments
    if representation.maximal and np.prod(moments) <= TAKEN_FOR_ZERO:
        raise UnsupportedError(
            "in maximal coordinates PyBullet drops the gyroscopic term unless the product of the "
            f"principal moments exceeds {TAKEN_FOR_ZERO:.2g} (kg m²)³, got {np.prod(moments):.2g}; "
            "scale the scene up, or use another method"
        )
    on_a_joint = representation.hung and scenario.constraint.is_pivot
    if not on_a_joint and min(mass, *moments) <= TAKEN_FOR_ZERO:
        raise UnsupportedError(
            f"PyBullet takes a mass or moment for zero unless it exceeds {TAKEN_FOR_ZERO:.2g} "
            f"(kg, kg m²), got {min(mass, *moments):.2g}; scale the scene up"
        )


def _solve_exactly(client: int) -> None:
    """Have constraints, and drives, solved directly: 50 iterations leave some of them unsolved."""
    p.setPhysicsEngineParameter(
        constraintSolverType=p.CONSTRAINT_SOLVER_LCP_DANTZIG, physicsClientId=client
    )


def _tie_to_world(model: Model, representation: BodyRepresentation) -> None:
    """A point-to-point constraint from the body's origin to the world's, solved directly.

    The default solver's 50 iterations leave so much of a slender body's constraint unsolved that
    its error is no longer of first order.
    """
    _solve_exactly(model.client)
    anchor = BASE
    if representation.maximal:
        # Of two rigid bodies only: a massless, shapeless one stands for the world.
        anchor = p.createMultiBody(
            baseMass=0, useMaximalCoordinates=True, physicsClientId=model.client
        )
    constraint = p.createConstraint(
        model.body,
        BASE,
        anchor,
        BASE,
        p.JOINT_POINT2POINT,
        jointAxis=(0, 0, 0),
        parentFramePosition=model.body_from_principal.inv().apply(-model.link_com),
        childFramePosition=(0, 0, 0),
        physicsClientId=model.client,
    )
    p.changeConstraint(constraint, maxForce=UNREACHED_FORCE, physicsClientId=model.client)
