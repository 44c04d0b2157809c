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
from .clock import CLOCK
from .script import script
from .session import MuJoCoSession, check_not_too_small, compiled, left_out
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


@dataclass(frozen=True)
class Way:
    """How a method steps a body and holds it.

    Attributes
    ----------
    integrator : as MJCF names it; None for MuJoCo's default
    by_contact : whether a table is a contact instead of joints
    tied : timesteps that a contact's time constant is; 0 for MuJoCo's own
    description : how the model writes the body
    """

    integrator: str | None
    by_contact: bool = False
    tied: float = 0.0
    description: Description = PLAIN


#: What alters the motion of a body on a contact: off, so that a step depends on the state alone.
OF_CONTACTS = ("warmstart",)
#: Timesteps: the shortest time constant that MuJoCo takes a contact to be stable with.
STIFFEST = 2.0
#: Methods that are not an integrator on joints.
WAYS = {
    "default": Way(None),
    "contact-Euler": Way("Euler", by_contact=True, tied=STIFFEST),
    "contact-RK4": Way("RK4", by_contact=True, tied=STIFFEST),
    "contact-default": Way(None, by_contact=True),
}
#: Of a table by contact.
BY_CONTACT = COMMON_EFFECTS | {"table"}
#: What joints can be of: a table is two slides under a ball, a rotor's hinge is a hinge.
EFFECTS = BY_CONTACT | {"rotors"}
ON_TABLE = frozenset({"table"})
CONTACT_SETUP = """\
{setup}
# of the plane and of the sphere at the tip, whenever the timestep is set:
model.geom_solref[:, 0] = 2 * TIMESTEP"""


def _method(name: str, order: int, summary: str) -> Method:
    return Method(name, order, order, summary, EFFECTS, setup=setup(name))


def _by_contact(integrator: str, order: int) -> Method:
    return Method(
        f"contact-{integrator}",
        order,
        order,
        f"{integrator}, the table as a contact as stiff as the timestep allows",
        BY_CONTACT,
        requires=ON_TABLE,
        setup=CONTACT_SETUP.format(setup=setup(integrator)),
    )


@final
class MuJoCo(Engine):
    """MuJoCo's rigid-body dynamics in reduced coordinates."""

    interface = 1
    name = "mujoco"
    steps_in = "mj_step"
    # Documentation, XML reference, option/timestep.
    stock_timestep = 0.002
    describes = frozenset({"parts", "full tensor", "shape", "joint", "compensated", "urdf"})
    # Orders: MuJoCo documentation, "Numerical integration" and changelog 4.0.0, item 5; measured
    # in docs/measured/engines-mujoco.md.
    methods = (
        _method("Euler", 1, "semi-implicit Euler, joint damping implicit"),
        _method("implicitfast", 1, "implicit in velocity; gyroscopic terms of free bodies only"),
        _method("implicit", 1, "implicit in velocity, gyroscopic terms included"),
        _method("RK4", 4, "Runge-Kutta of fourth order"),
        _method("discrete", 1, "implicit in velocity and position, one solve with the constraints"),
        Method(
            "default",
            1,
            1,
            "as shipped: Euler, with every pass on",
            EFFECTS,
            as_shipped=True,
        ),
        _by_contact("RK4", 2),
        _by_contact("Euler", 1),
        Method(
            "contact-default",
            1,
            1,
            "as shipped: Euler, the table as a contact with a time constant of 20 ms",
            BY_CONTACT,
            requires=ON_TABLE,
            as_shipped=True,
        ),
    )

    @property
    def version(self) -> str:
        """Version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Compile the scene's MJCF and set its keyframe."""
        left_in = left_out(scenario) if method.as_shipped else ()
        return self.open_with(scenario, method, timestep, left_in=left_in)

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
        way = _way(method)
        if way.integrator is not None:
            _check_has(way.integrator)
        if description != PLAIN:
            way = replace(way, description=description)
        if description.compensated:
            # Among the passive forces.
            left_in = ("gravity", "spring", "damper")
        model = copy(_model(scenario, way))
        disable(model, (name for name in _switched_off(scenario, method) if name not in left_in))
        start = model.key(0)
        session = MuJoCoSession(scenario, model, start.qpos, start.qvel, CLOCK in left_in, way.tied)
        session.set_timestep(timestep)
        return session

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """The MJCF, and the few calls that step it."""
        way, off = _way(method), () if method.as_shipped else _switched_off(scenario, method)
        moving = 3 if way.by_contact else 3 - sum(scenario.constraint.is_held)
        return script(_text(scenario, timestep, way), off, way.tied, moving)

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """The passes that are switched off, and the clock."""
        if method.as_shipped:
            return ()
        if not _way(method).by_contact:
            return left_out(scenario)
        kept = (*PASSES, *OF_CONTACTS)
        return tuple(name for name in left_out(off_its_table(scenario)) if name not in kept)

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


def _way(method: Method) -> Way:
    return WAYS.get(method.name, Way(method.name))


def _switched_off(scenario: Scenario, method: Method) -> tuple[str, ...]:
    """The passes that a method does not need."""
    if not _way(method).by_contact:
        return switched_off(scenario)
    return tuple(name for name in switched_off(off_its_table(scenario)) if name not in PASSES)


@lru_cache(maxsize=KEPT)
def _model(scenario: Scenario, way: Way) -> Any:
    """The compiled scene, with every pass on."""
    if way.description.urdf:
        integrator, description = way.integrator or "Euler", way.description
        return compiled(lambda: spec_of_urdf(scenario, integrator, description).compile())
    text = _text(scenario, ANY_TIMESTEP, way)
    if not hasattr(getattr(mujoco, "MjsJoint", None), "align"):
        # Versions without the attribute behave as if it were set.
        text = text.replace(' align="false"', "")
    return compiled(lambda: mujoco.MjModel.from_xml_string(text))


def _text(scenario: Scenario, timestep: float, way: Way) -> str:
    """The scene as MJCF, with every pass on."""
    alone = off_its_table(scenario) if way.by_contact else scenario
    text = mjcf(alone, timestep, way.integrator, switched_off(alone), way.description)
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
