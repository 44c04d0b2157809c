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

#: The version that introduced an integrator (changelog).
SINCE = {"discrete": "3.13.0"}
#: Number of compiled models kept: a ladder uses each at every timestep.
KEPT = 16
#: s, timestep of a compiled model before that of the run is set.
ANY_TIMESTEP = 1e-3


def setup(integrator: str) -> str:
    """An integrator in MJCF, and set on a model."""
    return f"""\
<option integrator="{integrator}" timestep="TIMESTEP"/>

model.opt.integrator = mujoco.mjtIntegrator.mjINT_{integrator.upper()}
model.opt.timestep = TIMESTEP"""


#: Timesteps: the shortest time constant that MuJoCo takes a contact to be stable with.
STIFFEST = 2.0
#: What alters the motion of a body on a contact: off, so that a step depends on the state alone.
OF_CONTACTS = ("warmstart",)
CONTACT_SETUP = """
# of the plane and of the sphere at the tip, whenever the timestep is set:
model.geom_solref[:, 0] = 2 * TIMESTEP"""


@dataclass(frozen=True)
class Way:
    """How a method steps a body and holds it.

    Attributes
    ----------
    order : of accuracy, in ω and attitude
    integrator : as MJCF names it; None for MuJoCo as shipped
    by_contact : whether a table is a contact; otherwise it is two slides under a ball joint
    tied : timesteps that a contact's time constant is; 0 for MuJoCo's own
    """

    order: int
    summary: str
    integrator: str | None
    by_contact: bool = False
    tied: float = 0.0

    def method(self, name: str) -> Method:
        """The method, with what its joints and contacts can be of: a rotor's hinge is a hinge."""
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
        """The scene with what joints hold: a body on a contact is free."""
        return off_its_table(scenario) if self.by_contact else scenario

    def switched_off(self, scenario: Scenario) -> tuple[str, ...]:
        """The passes that the method does not need, by MuJoCo's names."""
        passes = switched_off(self.alone(scenario))
        return tuple(name for name in passes if not (self.by_contact and name in PASSES))


CONTACT = "{}, the table as a contact as stiff as the timestep allows"
# Orders: MuJoCo documentation, "Numerical integration" and changelog 4.0.0, item 5; measured in
# docs/measured/engines-mujoco.md.
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
    # Documentation, XML reference, option/timestep.
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
        """As `open`; flags are set after compiling, as older versions refuse some in MJCF."""
        check_not_too_small(scenario)
        way = WAYS[method.name]
        if way.integrator is not None:
            _check_has(way.integrator)
        off = way.switched_off(scenario)
        if method.as_shipped and description == PLAIN:
            left_in = (*switched_off(scenario), CLOCK)
        if description.compensated:
            # Among the passive forces.
            left_in = ("gravity", "spring", "damper")
        model = copy(_model(scenario, way, description))
        disable(model, (name for name in off if name not in left_in))
        start = model.key(0)
        session = MuJoCoSession(scenario, model, start.qpos, start.qvel, CLOCK in left_in, way.tied)
        session.set_timestep(timestep)
        return session

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """The MJCF, and the few calls that step it."""
        way = WAYS[method.name]
        off = () if method.as_shipped else way.switched_off(scenario)
        moving = 3 if way.by_contact else 3 - sum(scenario.constraint.is_held)
        return script(_text(scenario, timestep, way), off, way.tied, moving)

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """The passes of MuJoCo that are switched off, and its timers."""
        if method.as_shipped:
            return ()
        way = WAYS[method.name]
        kept = OF_CONTACTS if way.by_contact else ()
        passes = [name for name in way.switched_off(scenario) if name not in kept]
        return (*passes, *([CLOCK] if SHIPPED else ()))

    def at_version(self, version: str) -> Release:
        """Another version; its differences are from MuJoCo's changelog."""
        return release(version, self.methods)


def release(version: str, methods: tuple[Method, ...]) -> Release:
    """A version of MuJoCo: until 4.0.0, RK4 averaged the stages' rotations."""
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
    """The compiled scene, with every pass on."""
    if description.urdf:
        integrator = way.integrator or "Euler"
        return compiled(lambda: spec_of_urdf(scenario, integrator, description).compile())
    text = _text(scenario, ANY_TIMESTEP, way, description)
    if not hasattr(getattr(mujoco, "MjsJoint", None), "align"):
        # Versions without the attribute behave as if it were set.
        text = text.replace(' align="false"', "")
    return compiled(lambda: mujoco.MjModel.from_xml_string(text))


def _text(scenario: Scenario, timestep: float, way: Way, description: Description = PLAIN) -> str:
    """The scene as MJCF, with every pass on."""
    alone = way.alone(scenario)
    text = mjcf(alone, timestep, way.integrator, switched_off(alone), description)
    if not way.by_contact:
        return text
    return with_contact(text, scenario, (way.tied * timestep, 1.0) if way.tied else None)


def _check_has(integrator: str) -> None:
    """Raise where this version of MuJoCo has no such integrator."""
    if f"mjINT_{integrator.upper()}" not in mujoco.mjtIntegrator.__members__:
        since = SINCE.get(integrator)
        newer = f"; {since} has" if since else ""
        raise UnsupportedError(
            f"MuJoCo {mujoco.mj_versionString()} has no integrator '{integrator}'{newer}", "effects"
        )
