"""A scene as MJCF, complete: loaded by any MuJoCo program, its keyframe 0 is the start.

The file holds the effects the scene calls for and nothing else. What MuJoCo would compute by
default for contacts, constraints, sensors and the like is switched off.
"""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache

import numpy as np
from mpmath import mp

from ...scenarios import Body, Scenario
from ...scenarios.effects.rotors import Rotor
from ...scenarios.exact import DIGITS, cross, rotate
from .principal_frame import principal_frame
from .text import decimals, xml_text

BODY = "top"
JOINT = "joint"
ROTOR = "rotor"
#: Inertia of a drive that keeps a rotor's spin, in moments of the rotor: the spin changes by an ulp
#: of what ω does.
DRIVE = 2.0**50
START_KEY = "start"
BODY_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
NO_FORCE = (0.0, 0.0, 0.0)

#: Number of scenes whose start is kept: computing it in extended precision takes long.
RECENT = 64

#: Flags that are on in MuJoCo by default and that no scene needs. The remaining ones (filterparent,
#: nativeccd, multiccd) choose how contacts are found, if there are any.
NEVER_CALLED_FOR = (
    "constraint",
    "equality",
    "frictionloss",
    "limit",
    "contact",
    "spring",
    "clampctrl",
    "warmstart",
    "refsafe",
    "sensor",
    "midphase",
    "island",
    "autoreset",
)


def mjcf(
    scenario: Scenario,
    timestep: float,
    integrator: str | None,
    left_in: Collection[str] = (),
) -> str:
    """The scene as an MJCF document.

    Parameters
    ----------
    timestep : s
    integrator : as MuJoCo spells it; None for its default
    left_in : passes that stay on, as by default, though the scene does not need them; names out of
        `switched_off`
    """
    root = ET.Element("mujoco", model=scenario.name)
    option = ET.SubElement(
        root,
        "option",
        timestep=decimals([timestep]),
        gravity=decimals(scenario.gravity_world),
    )
    if integrator is not None:
        option.set("integrator", integrator)
    if disabled := [name for name in switched_off(scenario) if name not in left_in]:
        ET.SubElement(option, "flag", dict.fromkeys(disabled, "disable"))
    _add_body(ET.SubElement(root, "worldbody"), scenario)
    if actuators := list(_actuators(scenario)):
        ET.SubElement(root, "actuator").extend(actuators)
    qpos, qvel = start_coordinates(scenario)
    keys = ET.SubElement(root, "keyframe")
    ET.SubElement(keys, "key", name=START_KEY, qpos=decimals(qpos), qvel=decimals(qvel))
    return xml_text(root)


def switched_off(scenario: Scenario) -> tuple[str, ...]:
    """MuJoCo's names of the passes that the scene does not need."""
    effects = scenario.called_for
    joint_damping = "drag" in effects and not scenario.constraint.is_free
    needed = {
        "gravity": "gravity" in effects,
        "damper": joint_damping,
        # Implicit joint damping is what MuJoCo's Euler does with a damper.
        "eulerdamp": joint_damping,
        "actuation": any(True for _ in _actuators(scenario)),
    }
    return NEVER_CALLED_FOR + tuple(name for name, is_needed in needed.items() if not is_needed)


@lru_cache(maxsize=RECENT)
def start_coordinates(scenario: Scenario) -> tuple[list[float], list[float]]:
    """qpos and qvel at t = 0.

    A ball joint's are the attitude (w, x, y, z) and ω in body axes; angles and spins of rotors that
    turn come last. A free joint's begin with the
    position and velocity of the body frame's origin, not of the com, in world axes
    (MuJoCo documentation, "Floating objects"), and those of slides with the tip's.
    """
    start, constraint, rotors = scenario.start, scenario.constraint, scenario.rotors
    q, omega_body, lever = start.q_exact, start.omega_body_exact, constraint.lever_exact
    moves = [axis for axis in range(3) if not constraint.is_held[axis]]
    spins = rotors.start_spins[rotors.is_turning].tolist()
    with mp.workdps(DIGITS):
        arm_world = rotate(q, lever)
        swing_world = rotate(q, cross(omega_body, lever))
        place = [float(start.position_world[k] - arm_world[k]) for k in moves]
        speed = [float(start.velocity_world[k] - swing_world[k]) for k in moves]
    return (
        [*place, *map(float, q), *([0.0] * len(spins))],
        [*speed, *map(float, omega_body), *spins],
    )


def _add_body(world: ET.Element, scenario: Scenario) -> None:
    element = ET.SubElement(world, "body", name=BODY)
    if scenario.constraint.is_free:
        # Aligned with the inertial frame, qpos and qvel would be along other axes.
        ET.SubElement(element, "freejoint", name=JOINT, align="false")
    else:
        _add_joints(element, scenario)
    _add_inertia(element, scenario.carrier)
    for number, rotor in enumerate(scenario.rotors.each, start=1):
        part = ET.SubElement(element, "body", name=f"{ROTOR}{number}")
        if rotor.hinge != "locked":
            hinge = ET.SubElement(part, "joint", name=f"hinge{number}", type="hinge")
            hinge.set("axis", decimals(map(float, rotor.axis)))
            hinge.set("pos", decimals(rotor.body.com))
            hinge.set("armature", decimals([armature(rotor)]))
        _add_inertia(part, rotor.body)


def armature(rotor: Rotor) -> float:
    """Inertia against a change of the spin relative to the body, kg m²: of a drive, all of it."""
    return DRIVE * float(rotor.along) if rotor.hinge == "driven" else 0.0


def _add_inertia(element: ET.Element, body: Body) -> None:
    frame = principal_frame(body)
    ET.SubElement(
        element,
        "inertial",
        mass=decimals([body.mass]),
        pos=decimals(body.com),
        quat=decimals(frame.q_body_axes_wxyz),
        diaginertia=decimals(frame.moments),
    )


def _add_joints(element: ET.Element, scenario: Scenario) -> None:
    """A ball joint at the point that is held, on a slide along each axis that it may move along."""
    constraint, point = scenario.constraint, scenario.body.com - scenario.constraint.lever
    if not constraint.is_pivot:
        place = np.array(constraint.place_exact, dtype=float)
        element.set("pos", decimals(place - point))
        for axis, is_held in zip(BODY_AXES, constraint.is_held, strict=True):
            if not is_held:
                ET.SubElement(element, "joint", type="slide", axis=decimals(axis))
    joint = ET.SubElement(element, "joint", name=JOINT, type="ball")
    if point.any():
        joint.set("pos", decimals(point))
    if scenario.drag:
        joint.set("damping", decimals([scenario.drag]))


def _actuators(scenario: Scenario) -> Iterator[ET.Element]:
    """Torques that are no joint damping: constant ones, and the drag of a free body.

    A free joint's damping would slow its translation too, hence three servos, one a body axis.
    """
    effects = scenario.called_for
    if "torque_body" in effects:
        yield _actuator(scenario, "joint", scenario.torque_body, constant=1.0)
    if "torque_world" in effects:
        # The parent's axes, which are the world's.
        yield _actuator(scenario, "jointinparent", scenario.torque_world, constant=1.0)
    if "drag" in effects and scenario.constraint.is_free:
        for axis in BODY_AXES:
            yield _actuator(scenario, "joint", axis, per_velocity=-scenario.drag)


def _actuator(
    scenario: Scenario,
    transmission: str,
    axis: Iterable[float],
    constant: float = 0.0,
    per_velocity: float = 0.0,
) -> ET.Element:
    """A torque (constant + per_velocity · ω·axis) along `axis`, independent of control signals."""
    # A free joint's gear begins with a force.
    is_free = scenario.constraint.is_free
    gear = f"{decimals(NO_FORCE)} {decimals(axis)}" if is_free else decimals(axis)
    return ET.Element(
        "general",
        {transmission: JOINT},
        gear=gear,
        gainprm="0",
        biastype="affine",
        biasprm=decimals([constant, 0.0, per_velocity]),
    )
