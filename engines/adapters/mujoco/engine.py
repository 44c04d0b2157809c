"""MuJoCo, with scenes as MJCF: each of its integrators is a method."""

from collections.abc import Collection
from copy import copy
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np
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

from ...models.mjcf import JOINT, armature, mjcf, switched_off
from ...models.mjcf_contact import PASSES, off_its_table, with_contact
from ...models.text import python_text
from ...models.urdf import BODY_LINK, urdf
from ...version_numbers import numbers_of
from ...world_session import run_script
from . import clock
from .clock import CLOCK
from .editable import free, set_scene, spec_of_urdf, with_start
from .session import MuJoCoSession, check_not_too_small, compiled
from .world import disable

#: First version of MuJoCo with the newest integrator, `discrete`, from the changelog.
SINCE = "3.13.0"
#: Largest number of compiled models that are cached: all timesteps of a ladder use the same model.
KEPT = 16
#: Timestep of a compiled model, s, before that of the run is set.
ANY_TIMESTEP = 1e-3
#: Relative margin by which a URDF's principal moments must fulfil the triangle inequality
#: A + B >= C. MuJoCo's reader of URDF diagonalises the tensor again, with errors of up to 12 ulp a
#: moment, and without a margin refuses every third flat body.
READER_ROUNDOFF = 3 * 12 * float(np.finfo(float).eps)
#: Shortest time constant of a contact that MuJoCo considers stable, in timesteps.
STIFFEST = 2.0
#: Passes that are switched off for a body on a contact, so that a step depends on the state alone.
OF_CONTACTS = ("warmstart",)
#: Prefix of the names of methods that hold a body on a table by a contact. All other methods hold
#: it by two slides and a ball joint.
BY_CONTACT = "contact-"
#: Word that methods as shipped have in their names in place of an integrator's name.
SHIPPED = "default"


def setup(integrator: str) -> str:
    """Return the lines, in MJCF and alternatively in Python, by which users choose an integrator.

    `integrator` is the integrator's name in MJCF.
    """
    return f"""\
<option integrator="{integrator}" timestep="TIMESTEP"/>

model.opt.integrator = mujoco.mjtIntegrator.mjINT_{integrator.upper()}
model.opt.timestep = TIMESTEP"""


CONTACT_SETUP = """
# of the plane and of the sphere at the tip, whenever the timestep is set:
model.geom_solref[:, 0] = 2 * TIMESTEP"""
CONTACT = "{}, the table as a contact as stiff as the timestep allows"
_MADE = """\
{mjcf}
model = mujoco.MjModel.from_xml_string(MJCF)
# What this scene has no use for; not every version of MuJoCo has all of it.
disable(model, {off!r})
set_timestep(model, TIMESTEP, {tied!r})
data = at_start(model)"""
_STATE = f"""\
joint = data.joint("{JOINT}")
return joint.qpos[-4:].copy(), joint.qvel[-3:].copy()"""


def _method(name: str, order: int, summary: str) -> Method:
    """Return a method, with the effects that its joints and contacts can simulate.

    Parameters
    ----------
    name : the integrator's name in MJCF, or `SHIPPED`; if it begins with `BY_CONTACT`, a contact
        holds the body on its table
    order : declared order of accuracy, of ω and of the attitude
    summary : the method in a few words
    """
    integrator, is_contact = name.removeprefix(BY_CONTACT), name.startswith(BY_CONTACT)
    return Method(
        name,
        order,
        order,
        summary,
        COMMON_EFFECTS | ({"table"} if is_contact else {"table", "rotors"}),
        requires=frozenset({"table"} if is_contact else ()),
        as_shipped=integrator == SHIPPED,
        setup="" if integrator == SHIPPED else setup(integrator) + CONTACT_SETUP * is_contact,
    )


@final
class MuJoCo(Engine):
    """The engine MuJoCo: rigid-body dynamics in reduced coordinates."""

    interface = 2
    name = "mujoco"
    # The default of option/timestep in MuJoCo's XML reference.
    stock_timestep = 0.002
    describes = frozenset({"parts", "full tensor", "shape", "joint", "compensated", "urdf"})
    # Orders are those of MuJoCo's documentation, "Numerical integration", and changelog 4.0.0, item
    # 5; they were confirmed by measurement (docs/measured/engines-mujoco.md).
    methods = (
        _method("Euler", 1, "semi-implicit Euler, joint damping implicit"),
        _method("implicitfast", 1, "implicit in velocity; gyroscopic terms of free bodies only"),
        _method("implicit", 1, "implicit in velocity, gyroscopic terms included"),
        _method("RK4", 4, "Runge-Kutta of fourth order"),
        _method("discrete", 1, "implicit in velocity and position, one solve with the constraints"),
        _method("default", 1, "as shipped: Euler, with every pass on"),
        _method("contact-RK4", 2, CONTACT.format("RK4")),
        _method("contact-Euler", 1, CONTACT.format("Euler")),
        _method(
            "contact-default",
            1,
            "as shipped: Euler, the table as a contact with a time constant of 20 ms",
        ),
    )

    @property
    def version(self) -> str:
        """The version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Compile the scene's MJCF, whose keyframe is the start; return a session at the start.

        Raises
        ------
        UnsupportedError
            If this version of MuJoCo lacks the integrator, or a mass or moment is too small for
            MuJoCo.
        EngineError
            If the compiler refuses the model, or warns.
        """
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
        """Open a scene with unneeded parts of a step left in, or another description of the body.

        `left_in` has the names, as `left_out` returns them, of the parts that are left in;
        `description` says how the body is written into the model; `defaults` is ignored. `left_in`
        is ignored for a method as shipped, which leaves in all passes. It is also ignored if the
        description has compensated gravity, which needs the passes of gravity, springs and dampers.
        Flags are set after compiling, because older versions refuse some of them in MJCF. The
        errors are those of `open`.
        """
        check_not_too_small(scenario)
        integrator, off = _integrator(method), _switched_off(scenario, method)
        if integrator and f"mjINT_{integrator.upper()}" not in mujoco.mjtIntegrator.__members__:
            raise UnsupportedError(
                f"MuJoCo {self.version} has no integrator '{integrator}'; {SINCE} has", "effects"
            )
        if integrator is None:
            left_in = (*switched_off(scenario), CLOCK)
        if description.compensated:
            # The compensating forces need all three: up to 3.3.0 springs and dampers share a flag.
            left_in = ("gravity", "spring", "damper")
        model = copy(_model(scenario, method, description))
        if description.urdf:
            set_scene(model, scenario, integrator or "Euler")
        disable(model, (name for name in off if name not in left_in))
        session = MuJoCoSession(scenario, model, CLOCK in left_in, _tied(method))
        session.set_timestep(timestep)
        return session

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """Return a Python script with the scene's MJCF and the few calls that step it."""
        made = _MADE.format(
            mjcf=python_text("MJCF", _text(scenario, timestep, method)),
            off=() if method.as_shipped else _switched_off(scenario, method),
            tied=_tied(method),
        )
        world = Path(__file__).with_name("world.py")
        return run_script(world, made, _STATE, "mujoco.mj_step(model, data, count)")

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """Return the names of the passes (parts of a step) that a method switches off, and `CLOCK`.

        `CLOCK`, the clock that MuJoCo reads in every step, is named only if MuJoCo's package
        installs one. The tuple is empty for a method as shipped. In a method with a contact the
        passes `OF_CONTACTS` are not named, because switching them off changes the motion.
        """
        if method.as_shipped:
            return ()
        kept = OF_CONTACTS if _is_by_contact(method) else ()
        passes = [name for name in _switched_off(scenario, method) if name not in kept]
        return (*passes, *([CLOCK] if clock.SHIPPED else ()))

    def at_version(self, version: str) -> Release:
        """Return what to install for a version of MuJoCo, and the methods with their orders in it.

        The orders follow from MuJoCo's changelog.
        """
        return release(version, self.methods)


def release(version: str, methods: tuple[Method, ...]) -> Release:
    """Return what to install for a version of MuJoCo, and the methods with their orders in it.

    Before 4.0.0, RK4 averaged the rotations of its stages, which made it of second order.

    Parameters
    ----------
    version : the version, such as 3.1.6
    methods : the methods, with their orders in the newest version
    """
    number = numbers_of(version)
    if number < (4,):
        methods = tuple(
            replace(method, order=2, attitude_order=2) if method.name == "RK4" else method
            for method in methods
        )
    parts = ("mujoco", "mujoco-core", "mujoco-studio") if number >= (4,) else ("mujoco",)
    return Release(tuple(f"{part}=={version}" for part in parts), methods, MuJoCo.name)


def _integrator(method: Method) -> str | None:
    """Return MJCF's name of a method's integrator; None for a method as shipped."""
    return None if method.as_shipped else method.name.removeprefix(BY_CONTACT)


def _is_by_contact(method: Method) -> bool:
    """Whether a method holds a body on a table by a contact."""
    return "table" in method.requires


def _tied(method: Method) -> float:
    """Return the time constant of a method's contacts, in timesteps; 0 to keep the model's own."""
    return STIFFEST if _is_by_contact(method) and not method.as_shipped else 0.0


def _alone(scenario: Scenario, method: Method) -> Scenario:
    """Return the scene without its table if the method has a contact for it, else the scene."""
    return off_its_table(scenario) if _is_by_contact(method) else scenario


def _switched_off(scenario: Scenario, method: Method) -> tuple[str, ...]:
    """Return MuJoCo's names of the parts of a step that a method does not need for a scene."""
    needed = PASSES if _is_by_contact(method) else ()
    return tuple(name for name in switched_off(_alone(scenario, method)) if name not in needed)


@lru_cache(maxsize=KEPT)
def _model(scenario: Scenario, method: Method, description: Description) -> Any:
    """Return the compiled model of a scene, with every pass (part of a step) on.

    The body is written as `description` says. The model is cached: callers must copy it before they
    change it.
    """
    if description.urdf:
        return compiled(lambda: _of_urdf(scenario, description))
    text = _text(scenario, ANY_TIMESTEP, method, description)
    if not hasattr(getattr(mujoco, "MjsJoint", None), "align"):
        # Versions without this attribute never align a free joint.
        text = text.replace(' align="false"', "")
    return compiled(lambda: mujoco.MjModel.from_xml_string(text))


def _of_urdf(scenario: Scenario, description: Description) -> Any:
    """Return the compiled model of a scene's URDF, with additions that URDF cannot state.

    The body is written as `description` says. The additions are the free joint of a free body, and
    the armatures of driven rotors.
    """
    spec = spec_of_urdf(urdf(scenario, READER_ROUNDOFF, description=description))
    if scenario.constraint.is_free:
        free(spec.body(BODY_LINK))
    for number, rotor in enumerate(scenario.rotors.each, start=1):
        if rotor.hinge != "locked":
            spec.joint(f"hinge{number}").armature = armature(rotor)
    return with_start(spec)


def _text(
    scenario: Scenario, timestep: float, method: Method, description: Description = PLAIN
) -> str:
    """Return the MJCF of a scene, in which no pass (part of a step) is switched off.

    The body is written as `description` says.
    """
    alone = _alone(scenario, method)
    text = mjcf(alone, timestep, _integrator(method), switched_off(alone), description)
    return with_contact(text, scenario) if _is_by_contact(method) else text
