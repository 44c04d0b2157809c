"""Loads a scene's body into a PyBullet world, in the way that a method represents it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation
from spincheck.engine import PLAIN, Description, EngineError, Scenario, UnsupportedError

from ...models.mjcf_contact import sphere_and_plane
from ...models.urdf import urdf
from .model import Model
from .world import DEFAULTS, FILE, World

#: Names of the parts that are left out because they do not change the motion.
SHAPE, MOTOR = "collision shape", "idle joint motor"
#: SIMD_EPSILON of Bullet's LinearMath/btScalar.h: Bullet takes values up to it for zero.
TAKEN_FOR_ZERO = float(np.finfo(float).eps)


@dataclass(frozen=True)
class BodyRepresentation:
    """How a method represents the body and holds it.

    Attributes
    ----------
    maximal : whether the body is in maximal coordinates, six a body (btRigidBody), instead of joint
        coordinates (btMultiBody)
    hung : whether a pivot is a spherical joint, and a table such a joint on slides; if not, a pivot
        is a point-to-point constraint
    left_in : names of parts that are kept so that their cost can be measured: `SHAPE`, `MOTOR`
    defaults : names, out of `DEFAULTS`, of PyBullet's defaults that are kept
    own : the user's own files that are loaded, contents by name; None if the scene's URDF is loaded
    description : how the scene's URDF describes the body
    by_contact : whether a table is implemented by a contact of a sphere and a plane
    """

    maximal: bool = False
    hung: bool = False
    left_in: frozenset[str] = frozenset()
    defaults: frozenset[str] = frozenset()
    own: Mapping[str, bytes] | None = None
    description: Description = PLAIN
    by_contact: bool = False

    @property
    def as_shipped(self) -> bool:
        """Whether the body is loaded as users do it, with at least one of PyBullet's defaults."""
        return bool(self.defaults)

    def hangs(self, scenario: Scenario) -> bool:
        """Whether a spherical joint holds the body: `hung` is true and the scene holds it."""
        return self.hung and not scenario.constraint.is_free


def load(
    client: int, scenario: Scenario, representation: BodyRepresentation, timestep: float
) -> Model:
    """Load the scene's body into an empty world, hold it as the scene says, and set its start.

    Parameters
    ----------
    client : PyBullet's number of the world
    representation : how the body is represented and held
    timestep : length of the steps, s

    Raises
    ------
    UnsupportedError
        If PyBullet would take a mass, a moment or an inverse mass of the body for zero; this is not
        checked for a method as shipped.
    EngineError
        If PyBullet cannot load the body.
    OSError
        If a file cannot be written.
    """
    if not representation.as_shipped:
        _check_not_lost(scenario, representation)
    own = representation.own or scenes_own(scenario, representation)
    try:
        world = World(_record(scenario, representation), client, own)
    except p.error as error:
        raise EngineError(f"PyBullet cannot load the body: {error}") from None
    model = Model(world, scenario)
    world.scene |= model.in_its_axes(scenario)
    world.set_up(timestep)
    return model


def _record(scenario: Scenario, representation: BodyRepresentation) -> dict[str, Any]:
    """Return those entries of the record for `World` that are known before the body is loaded.

    They say how the body is loaded and what acts on it: the first two groups of keys that `World`
    lists. Entries along principal axes are missing, because PyBullet finds these axes as it loads.
    """
    start, is_pivot = scenario.start, scenario.constraint.is_pivot
    hung = representation.hangs(scenario)
    world_from_body = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
    position, attitude = np.zeros(3), Rotation.identity() if hung else world_from_body
    if not (is_pivot or hung):
        position = start.position_world - world_from_body.apply(np.array(scenario.body.com))
    drives = scenario.rotors and not representation.as_shipped
    return {
        "maximal": representation.maximal,
        "hung": hung,
        "slides": 3 - sum(scenario.constraint.is_held) if hung else 0,
        "defaults": [name for name in DEFAULTS if name in representation.defaults],
        "position": position.tolist(),
        "attitude": attitude.as_quat().tolist(),
        "gravity": scenario.gravity_world.tolist(),
        "drag": float(scenario.pushed["drag"]),
        "torque_world": scenario.pushed["torque_world"].tolist(),
        "plane": sphere_and_plane(scenario)[1] if representation.by_contact else None,
        "rotors": [rotor.hinge for rotor in scenario.rotors.each],
        "motor": (0, 0, 0) if MOTOR in representation.left_in else 0,
        "is_exact": bool(drives or (is_pivot and not hung)),
    }


def scenes_own(scenario: Scenario, representation: BodyRepresentation) -> dict[str, bytes]:
    """Return a dict with the scene's URDF, as bytes, under the name of its file, `FILE`.

    The URDF states a joint that holds the body only if the representation has one. It has a
    collision sphere if a contact holds the body, or if `SHAPE` is left in.
    """
    hung = representation.hangs(scenario)
    sphere: tuple[tuple[float, ...], float] | None = None
    if representation.by_contact:
        table = scenario.effects.table
        assert table is not None
        sphere = table.tip, sphere_and_plane(scenario)[0]
    elif SHAPE in representation.left_in:
        # The sphere is about as large as the body: its radius is the radius of gyration.
        radius = np.sqrt(scenario.body.principal_moments[-1] / scenario.body.mass)
        sphere = tuple(scenario.body.com), float(radius)
    text = urdf(
        scenario,
        sphere=sphere,
        has_box=representation.as_shipped,
        description=representation.description,
        is_loose=not hung,
    )
    return {FILE: text.encode()}


def _check_not_lost(scenario: Scenario, representation: BodyRepresentation) -> None:
    """Raise `UnsupportedError` if Bullet would take a number of the body for zero.

    The number is a mass, a moment, the product of the moments or an inverse mass; which of them
    matters depends on how the body is represented and held, `representation`.
    """
    mass, moments = scenario.carrier.mass, scenario.carrier.principal_moments
    is_pivot, product, least = scenario.constraint.is_pivot, np.prod(moments), min(mass, *moments)
    is_jointed = is_pivot and representation.hung
    limits = (
        (
            representation.maximal,
            product,
            "in maximal coordinates PyBullet drops the gyroscopic term unless the product of the "
            f"principal moments exceeds {TAKEN_FOR_ZERO:.2g} (kg m²)³, got {product:.2g}; "
            "scale the scene up, or use another method",
        ),
        (
            is_pivot and not (is_jointed or representation.maximal),
            1 / mass,
            "PyBullet drops a point-to-point constraint on a body whose inverse mass does not "
            f"exceed {TAKEN_FOR_ZERO:.2g} /kg, got {mass:.2g} kg; scale the scene down, or use "
            "another method",
        ),
        (
            not is_jointed,
            least,
            f"PyBullet takes a mass or moment for zero unless it exceeds {TAKEN_FOR_ZERO:.2g} "
            f"(kg, kg m²), got {least:.2g}; scale the scene up",
        ),
    )
    for concerns, number, words in limits:
        if concerns and number <= TAKEN_FOR_ZERO:
            raise UnsupportedError(words)
