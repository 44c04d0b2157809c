"""MuJoCo, from the scene as MJCF: every integrator it has is a method."""

from collections.abc import Collection
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, final

import mujoco
from spincheck.engine import (
    COMMON_EFFECTS,
    PLAIN,
    Description,
    Engine,
    Method,
    Release,
    Scenario,
    UnsupportedError,
)

from ...models.mjcf import mjcf, switched_off
from ...models.mjcf_contact import PASSES, off_its_table, with_contact
from ...version_numbers import numbers_of
from .clock import CLOCK, SHIPPED
from .script import script
from .session import MuJoCoSession, check_not_too_small, compiled
from .urdf_reader import spec_of_urdf
from .world import disable

#: The MuJoCo version that introduced an integrator, from the changelog.
SINCE = {"discrete": "3.13.0"}
#: Number of compiled models kept: a ladder of timesteps uses the same model at each.
KEPT = 16
#: Timestep of a compiled model, s, until that of the run is set.
ANY_TIMESTEP = 1e-3


def setup(integrator: str) -> str:
    """Return how users choose an integrator: in MJCF, and on a compiled model."""
    return f"""\
<option integrator="{integrator}" timestep="TIMESTEP"/>

model.opt.integrator = mujoco.mjtIntegrator.mjINT_{integrator.upper()}
model.opt.timestep = TIMESTEP"""


#: Shortest time constant of a contact that MuJoCo takes to be stable, in timesteps.
STIFFEST = 2.0
#: Passes that are switched off for a body on a contact, so that a step depends on the state alone.
OF_CONTACTS = ("warmstart",)
CONTACT_SETUP = """
# of the plane and of the sphere at the tip, whenever the timestep is set:
model.geom_solref[:, 0] = 2 * TIMESTEP"""


@dataclass(frozen=True)
class Way:
    """How a method steps a body and holds it.

    Attributes
    ----------
    order : order of accuracy, in ω and in attitude
    integrator : as MJCF names it; None for MuJoCo as shipped
    by_contact : whether a table is a contact; otherwise it is two slides under a ball joint
    tied : time constant of a contact, in timesteps; 0 for MuJoCo's own
    """

    order: int
    summary: str
    integrator: str | None
    by_contact: bool = False
    tied: float = 0.0

    def method(self, name: str) -> Method:
        """Return the method, with the effects that its joints and contacts can simulate."""
        of_contact = COMMON_EFFECTS | {"table"}
        return Method(
            name,
            self.order,
            self.order,
            self.summary,
            of_contact if self.by_contact else of_contact | {"rotors"},
            requires=frozenset({"table"} if self.by_contact else ()),
            as_shipped=self.integrator is None,
            setup=setup(self.integrator) + CONTACT_SETUP * self.by_contact
            if self.integrator
            else "",
        )

    def alone(self, scenario: Scenario) -> Scenario:
        """Return the scene as the joints see it: a body that lies on a contact is free."""
        return off_its_table(scenario) if self.by_contact else scenario

    def switched_off(self, scenario: Scenario) -> tuple[str, ...]:
        """Return MuJoCo's names of the passes that the method does not need."""
        passes = switched_off(self.alone(scenario))
        return tuple(name for name in passes if not (self.by_contact and name in PASSES))


CONTACT = "{}, the table as a contact as stiff as the timestep allows"
# Orders as in MuJoCo's documentation, "Numerical integration", and changelog 4.0.0, item 5;
# measured in docs/measured/engines-mujoco.md.
WAYS = {
    "Euler": Way(1, "semi-implicit Euler, joint damping implicit", "Euler"),
    "implicitfast": Way(
        1, "implicit in velocity; gyroscopic terms of free bodies only", "implicitfast"
    ),
    "implicit": Way(1, "implicit in velocity, gyroscopic terms included", "implicit"),
    "RK4": Way(4, "Runge-Kutta of fourth order", "RK4"),
    "discrete": Way(
        1, "implicit in velocity and position, one solve with the constraints", "discrete"
    ),
    "default": Way(1, "as shipped: Euler, with every pass on", None),
    "contact-RK4": Way(2, CONTACT.format("RK4"), "RK4", by_contact=True, tied=STIFFEST),
    "contact-Euler": Way(1, CONTACT.format("Euler"), "Euler", by_contact=True, tied=STIFFEST),
    "contact-default": Way(
        1,
        "as shipped: Euler, the table as a contact with a time constant of 20 ms",
        None,
        by_contact=True,
    ),
}


@final
class MuJoCo(Engine):
    """MuJoCo's rigid-body dynamics in reduced coordinates."""

    interface = 2
    name = "mujoco"
    # Default of the documentation, XML reference, option/timestep.
    stock_timestep = 0.002
    describes = frozenset({"parts", "full tensor", "shape", "joint", "compensated", "urdf"})
    methods = tuple(way.method(name) for name, way in WAYS.items())

    @property
    def version(self) -> str:
        """Version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Compile the scene's MJCF and set its keyframe."""
        return self.open_with(scenario, method, timestep)

    def open_with(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        *,
        left_in: Collection[str] = (),
        defaults: Collection[str] | None = None,  # noqa: ARG002
        description: Description = PLAIN,
    ) -> MuJoCoSession:
        """Open a scene with passes left in or with another description; parameters as in `Engine`.

        Flags are set after compiling, as older versions refuse some of them in MJCF.
        """
        check_not_too_small(scenario)
        way = WAYS[method.name]
        if way.integrator is not None:
            _check_has(way.integrator)
        off = way.switched_off(scenario)
        if method.as_shipped and description == PLAIN:
            left_in = (*switched_off(scenario), CLOCK)
        if description.compensated:
            # Damping is one of the passive forces.
            left_in = ("gravity", "spring", "damper")
        model = copy(_model(scenario, way, description))
        disable(model, (name for name in off if name not in left_in))
        start = model.key(0)
        session = MuJoCoSession(scenario, model, start.qpos, start.qvel, CLOCK in left_in, way.tied)
        session.set_timestep(timestep)
        return session

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """Return the MJCF, and the few calls that step it, as Python."""
        way = WAYS[method.name]
        off = () if method.as_shipped else way.switched_off(scenario)
        moving = 3 if way.by_contact else 3 - sum(scenario.constraint.is_held)
        return script(_text(scenario, timestep, way), off, way.tied, moving)

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """Return the names of the passes that a method switches off, and the clock's name."""
        if method.as_shipped:
            return ()
        way = WAYS[method.name]
        kept = OF_CONTACTS if way.by_contact else ()
        passes = [name for name in way.switched_off(scenario) if name not in kept]
        return (*passes, *([CLOCK] if SHIPPED else ()))

    def at_version(self, version: str) -> Release:
        """Return another version, with its differences according to MuJoCo's changelog."""
        return release(version, self.methods)


def release(version: str, methods: tuple[Method, ...]) -> Release:
    """Return a version of MuJoCo; before 4.0.0, RK4 averaged the stages' rotations."""
    number = numbers_of(version)
    if number < (4,):
        methods = tuple(
            replace(method, order=2, attitude_order=2) if method.name == "RK4" else method
            for method in methods
        )
    parts = ("mujoco", "mujoco-core", "mujoco-studio") if number >= (4,) else ("mujoco",)
    return Release(tuple(f"{part}=={version}" for part in parts), methods, MuJoCo.name)


@lru_cache(maxsize=KEPT)
def _model(scenario: Scenario, way: Way, description: Description) -> Any:
    """Return the compiled model of a scene, with every pass on."""
    if description.urdf:
        integrator = way.integrator or "Euler"
        return compiled(lambda: spec_of_urdf(scenario, integrator, description).compile())
    text = _text(scenario, ANY_TIMESTEP, way, description)
    if not hasattr(getattr(mujoco, "MjsJoint", None), "align"):
        # Versions without this attribute behave as if it were set.
        text = text.replace(' align="false"', "")
    return compiled(lambda: mujoco.MjModel.from_xml_string(text))


def _text(scenario: Scenario, timestep: float, way: Way, description: Description = PLAIN) -> str:
    """Return the MJCF of a scene, with every pass on."""
    alone = way.alone(scenario)
    text = mjcf(alone, timestep, way.integrator, switched_off(alone), description)
    if not way.by_contact:
        return text
    return with_contact(text, scenario, (way.tied * timestep, 1.0) if way.tied else None)


def _check_has(integrator: str) -> None:
    """Raise `UnsupportedError` if this version of MuJoCo has no such integrator."""
    if f"mjINT_{integrator.upper()}" not in mujoco.mjtIntegrator.__members__:
        since = SINCE.get(integrator)
        newer = f"; {since} has" if since else ""
        raise UnsupportedError(
            f"MuJoCo {mujoco.mj_versionString()} has no integrator '{integrator}'{newer}", "effects"
        )
