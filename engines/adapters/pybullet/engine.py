"""PyBullet, Bullet 3 in double precision, with scenes as URDF.

docs/measured/engines-pybullet.md says what the engine does to a top by default, and how effects
were measured.
"""

from collections.abc import Collection
from dataclasses import replace
from functools import cache, partial
from importlib.metadata import version
from math import pi

from spincheck.engine import (
    COMMON_EFFECTS,
    PLAIN,
    Description,
    Engine,
    Method,
    Release,
    Scenario,
    Session,
    start_state,
)

from ...native_output import native_output
from ...version_numbers import numbers_of

with native_output():
    # On import, Bullet prints its build date, which is discarded here.
    from .load import MOTOR, SHAPE, BodyRepresentation
    from .pivot_limit import check_borne
    from .script import script, setup
    from .session import PyBulletSession
    from .world import DEFAULTS, INERTIA, JOINT_MOTOR

#: Largest rotation in a step, rad, for every kind of body: ANGULAR_MOTION_THRESHOLD of Bullet's
#: LinearMath/btTransformUtil.h. If ω is larger, the attitude turns only by this much a step, while
#: ω still reads its full value.
MOST_ROTATION_A_STEP = pi / 4

#: Effects that methods in joint coordinates can simulate.
JOINTED = COMMON_EFFECTS | {"rotors"}
ON_TABLE = frozenset({"table"})
SHIPPED = frozenset(DEFAULTS)
#: Function that makes a method of PyBullet: all are of first order, in whatever coordinates.
bullet_method = partial(
    Method, order=1, attitude_order=1, max_rotation_per_step=MOST_ROTATION_A_STEP
)
#: For each method, by name: how the body is represented, a summary, and the effects that the method
#: can simulate.
METHODS = {
    "multibody": (
        BodyRepresentation(hung=True),
        "joint coordinates, a pivot as a spherical joint, a table as one on two slides",
        JOINTED | ON_TABLE,
    ),
    "multibody-p2p": (
        BodyRepresentation(),
        "joint coordinates, the pivot as a point-to-point constraint",
        JOINTED,
    ),
    "maximal": (
        BodyRepresentation(maximal=True),
        "six coordinates a body, gyroscopic term implicit, the pivot as a constraint",
        COMMON_EFFECTS,
    ),
    "contact": (
        BodyRepresentation(by_contact=True),
        "joint coordinates, the table as a contact of a sphere and a plane",
        COMMON_EFFECTS | ON_TABLE,
    ),
    "default": (
        BodyRepresentation(hung=True, defaults=SHIPPED),
        "as shipped: the URDF without flags, with damping, joint motor and velocity clamp",
        JOINTED,
    ),
    "default-inertia-from-file": (
        BodyRepresentation(hung=True, defaults=SHIPPED - {INERTIA}),
        "as shipped, but for the inertia, which is the file's (URDF_USE_INERTIA_FROM_FILE)",
        JOINTED,
    ),
}
#: Effects that a scene must have, by name of the methods that require them.
REQUIRED = {"multibody-p2p": frozenset({"pivot"}), "contact": ON_TABLE}
REPRESENTATIONS = {name: representation for name, (representation, *_) in METHODS.items()}


class PyBullet(Engine):
    """The engine PyBullet; methods differ in Bullet's kind of body and in how it is held."""

    interface = 1
    name = "pybullet"
    # The default of setTimeStep, from the PyBullet quickstart guide.
    stock_timestep = 1 / 240
    describes = frozenset({"parts", "full tensor", "shape"})
    methods = tuple(
        bullet_method(
            name=name,
            summary=summary,
            effects=effects,
            requires=REQUIRED.get(name, frozenset()),
            as_shipped=representation.as_shipped,
            setup="" if representation.as_shipped else setup(representation),
        )
        for name, (representation, summary, effects) in METHODS.items()
    )

    @property
    def version(self) -> str:
        """The version of the installed package; the library does not report its own."""
        return installed_version()

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Load the scene's URDF and set its start; return the session.

        Raises
        ------
        UnsupportedError
            If the pivot of a body in maximal coordinates cannot bear the load at the start. Also if
            PyBullet would take a mass, a moment or an inverse mass for zero; this is not checked
            for methods as shipped.
        EngineError
            If PyBullet cannot load the scene, or warns.
        """
        if REPRESENTATIONS[method.name].maximal and scenario.constraint.is_pivot:
            check_borne(scenario, start_state(scenario), timestep)
        return self.open_with(scenario, method, timestep)

    def open_with(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        *,
        left_in: Collection[str] = (),
        defaults: Collection[str] | None = None,
        description: Description = PLAIN,
    ) -> Session:
        """Open a scene with unneeded parts left in, with given defaults, or another description.

        `left_in` has the names of the parts, as `left_out` returns them; `defaults` has the names
        of PyBullet's defaults that are kept, or is None for those of the method; `description` says
        how the body is written into the URDF. A body that is described by its shape is a collision
        box, from which PyBullet computes the inertia: no other default is then kept. The errors are
        those of `open`, but the load on the pivot is not checked.
        """
        representation = REPRESENTATIONS[method.name]
        if description.shape:
            defaults = {INERTIA}
        kept = representation.defaults if defaults is None else frozenset(defaults)
        representation = replace(
            representation, left_in=frozenset(left_in), defaults=kept, description=description
        )
        return PyBulletSession(scenario, representation, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """Return a Python script with the scene's URDF, and the calls that load and step it."""
        return script(scenario, REPRESENTATIONS[method.name], timestep)

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """Return the names of the parts that are left out: collision shape, and idle joint motor.

        The motor is named only if a joint holds the body. A method as shipped, or one
        that holds the body on a table by a contact, leaves out neither.
        """
        representation = REPRESENTATIONS[method.name]
        if representation.as_shipped or representation.by_contact:
            return ()
        return (SHAPE, MOTOR) if representation.hangs(scenario) else (SHAPE,)

    def at_version(self, version: str) -> Release:
        """Return what to install for a version of PyBullet, and the methods, which are the same."""
        return release(version, self.methods)

    def defaults(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """Return the names of PyBullet's defaults that a method keeps and that change motions.

        The joint motor is left out if the scene has no joint.
        """
        has_joint = scenario.constraint.is_pivot or scenario.rotors.is_turning.any()
        left = REPRESENTATIONS[method.name].defaults - (set() if has_joint else {JOINT_MOTOR})
        return tuple(name for name in DEFAULTS if name in left)


def release(version: str, methods: tuple[Method, ...]) -> Release:
    """Return what to install for a version of PyBullet, and the given methods, which it has.

    Versions up to 3.2.6 need numpy 1.
    """
    older = ("numpy==1.26.4",) if numbers_of(version) <= (3, 2, 6) else ()
    # Models of robots, 142 MB, which are installed with the package, and not needed.
    robots = ("pybullet_data",)
    return Release((f"pybullet=={version}", *older), methods, PyBullet.name, robots)


@cache
def installed_version() -> str:
    """Return the installed version; it is cached, as looking it up takes as long as many steps."""
    return version("pybullet")
