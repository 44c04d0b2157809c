"""Writes a scene as a complete MJCF, which any MuJoCo program loads; its keyframe 0 is the start.

The file has the effects that the scene calls for and nothing else. What MuJoCo would compute by
default for contacts, constraints, sensors and the like is switched off.
"""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from math import prod

import numpy as np
from mpmath import mp

from ...scenarios import Body, Scenario
from ...scenarios.exact import DIGITS, cross, rotate
from ...scenarios.gyrostat import Rotor
from ..world_parts import DRIVE
from .description import (
    COMPENSATED,
    PLAIN,
    TURN,
    Description,
    Joint,
    away_from,
    parts_of,
)
from .hinged import hinged
from .principal_frame import principal_frame
from .shape import box_sides
from .text import decimals, xml_text

BODY = "top"
JOINT = "joint"
ROTOR = "rotor"
START_KEY = "start"
BODY_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
NO_FORCE = (0.0, 0.0, 0.0)

#: Number of scenes whose start is kept, as computing it in extended precision takes long.
RECENT = 64

#: MuJoCo's flags that are on by default and that no scene needs. Not listed are filterparent,
#: nativeccd and multiccd, which only choose how contacts are found.
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
    description: Description = PLAIN,
) -> str:
    """Return the scene as an MJCF document.

    Parameters
    ----------
    timestep : length of the steps, s
    integrator : MuJoCo's name of the integrator; None for MuJoCo's default
    left_in : MuJoCo's names of parts of a step that stay on although the scene does not need them;
        all others of the names that `switched_off` returns are switched off
    description : how the body is written into the model
    """
    root = ET.Element("mujoco", model=scenario.name)
    option = ET.SubElement(
        root,
        "option",
        timestep=decimals([timestep]),
        gravity=decimals(COMPENSATED if description.compensated else scenario.gravity_world),
    )
    if integrator is not None:
        option.set("integrator", integrator)
    if disabled := [name for name in switched_off(scenario) if name not in left_in]:
        ET.SubElement(option, "flag", dict.fromkeys(disabled, "disable"))
    _add_body(ET.SubElement(root, "worldbody"), scenario, description)
    if actuators := list(_actuators(scenario)):
        ET.SubElement(root, "actuator").extend(actuators)
    qpos, qvel = start_coordinates(scenario)
    if description.joint == "hinges":
        qpos, qvel = (part.tolist() for part in hinged(qpos, qvel))
    keys = ET.SubElement(root, "keyframe")
    ET.SubElement(keys, "key", name=START_KEY, qpos=decimals(qpos), qvel=decimals(qvel))
    return xml_text(root)


def switched_off(scenario: Scenario) -> tuple[str, ...]:
    """Return MuJoCo's names, such as "contact", of the parts of a step that a scene does not need.

    They are the names of its flags (attributes of `flag` in MJCF).
    """
    effects = scenario.called_for
    joint_damping = "drag" in effects and not scenario.constraint.is_free
    needed = {
        "gravity": "gravity" in effects,
        "damper": joint_damping,
        # By default MuJoCo's Euler integrates the damping of joints implicitly.
        "eulerdamp": joint_damping,
        "actuation": any(True for _ in _actuators(scenario)),
    }
    return NEVER_CALLED_FOR + tuple(name for name, is_needed in needed.items() if not is_needed)


@lru_cache(maxsize=RECENT)
def start_coordinates(scenario: Scenario) -> tuple[list[float], list[float]]:
    """Return MuJoCo's qpos and qvel at t = 0, in SI units, for a free joint or a ball joint.

    qpos has the attitude, w x y z, and qvel has ω in body axes. Before them, a free body has the
    position and velocity of its origin, not of the com, in world axes (MuJoCo documentation,
    "Floating objects"); a body on a table has the position and velocity of its tip along the slides
    instead. Angles and spins of the rotors that turn come last.
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


def _add_body(world: ET.Element, scenario: Scenario, description: Description) -> None:
    """Add a scene's body, with its parts, joints and rotors, to an MJCF's `worldbody`, `world`.

    `description` says how the body is written.
    """
    elements: list[ET.Element] = []
    for part in parts_of(scenario.carrier, description.parts):
        if part.onto is None:
            element = ET.SubElement(world, "body", name=BODY)
            _add_joints(element, scenario, description.joint)
        else:
            place = {"pos": decimals(part.position), "quat": decimals(part.q)}
            name = f"{BODY}-{len(elements)}"
            element = ET.SubElement(elements[part.onto], "body", {"name": name, **place})
        if part.body is not None:
            _add_inertia(element, part.body, description)
        elements.append(element)
    for number, rotor in enumerate(scenario.rotors.each, start=1):
        part_of_body = ET.SubElement(elements[0], "body", name=f"{ROTOR}{number}")
        if rotor.hinge != "locked":
            hinge = ET.SubElement(part_of_body, "joint", name=f"hinge{number}", type="hinge")
            hinge.set("axis", decimals(map(float, rotor.axis)))
            hinge.set("pos", decimals(rotor.body.com))
            hinge.set("armature", decimals([armature(rotor)]))
        _add_inertia(part_of_body, rotor.body)
        elements.append(part_of_body)
    if description.compensated:
        for element in elements:
            element.set("gravcomp", "1")


def armature(rotor: Rotor) -> float:
    """Return the inertia of the drive of a rotor's hinge, kg m²; 0 if the hinge is not driven.

    It is so large that the rotor's spin does not change noticeably.
    """
    return DRIVE * float(rotor.along) if rotor.hinge == "driven" else 0.0


def _add_inertia(element: ET.Element, body: Body, description: Description = PLAIN) -> None:
    """Add a body's inertia to an element: an `inertial`, or, if `description.shape` is true, a box.

    `description` says how the body is written into the model.
    """
    frame = principal_frame(body)
    pos, quat = decimals(body.com), decimals(frame.q_body_axes_wxyz)
    if description.joint == "aligned":
        # The scene's body axes are principal axes here. The inertial frame is put elsewhere in the
        # element, and by `align` MuJoCo moves the element's frame to it.
        pos, quat = decimals(away_from(body)), decimals(TURN)
    if description.shape:
        sides = box_sides(body.mass, frame.moments)
        geom = {"type": "box", "size": decimals(side / 2 for side in sides)}
        density = decimals([body.mass / prod(sides)])
        unseen = {"contype": "0", "conaffinity": "0"}
        ET.SubElement(
            element, "geom", {**geom, **unseen, "density": density, "pos": pos, "quat": quat}
        )
        return
    inertial = ET.SubElement(element, "inertial", mass=decimals([body.mass]), pos=pos)
    if description.full_tensor:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia_com
        inertial.set("fullinertia", decimals([xx, yy, zz, xy, xz, yz]))
        return
    inertial.set("quat", quat)
    inertial.set("diaginertia", decimals(frame.moments))


def _add_joints(element: ET.Element, scenario: Scenario, kind: Joint) -> None:
    """Add the joints on which the body moves.

    A free body has a free joint, unless `kind` asks for other joints. Otherwise there are slides
    along the axes along which the body may move, and then a ball joint, or three hinges, at the
    held point.

    Parameters
    ----------
    element : the body's element
    kind : the kind of joint (`Description.joint`)
    """
    constraint, point = scenario.constraint, scenario.body.com - scenario.constraint.lever
    if constraint.is_free and kind in ("own", "aligned"):
        # If MuJoCo aligns the joint with the inertial frame, qpos and qvel are along its axes.
        align = "true" if kind == "aligned" else "false"
        ET.SubElement(element, "freejoint", name=JOINT, align=align)
        return
    if not constraint.is_pivot:
        place = np.array(constraint.place_exact, dtype=float)
        element.set("pos", decimals(place - point))
        for axis, is_held in zip(BODY_AXES, constraint.is_held, strict=True):
            if not is_held:
                ET.SubElement(element, "joint", type="slide", axis=decimals(axis))
    if kind == "hinges":
        for axis in reversed(BODY_AXES):
            ET.SubElement(element, "joint", type="hinge", axis=decimals(axis))
        return
    joint = ET.SubElement(element, "joint", name=JOINT, type="ball")
    if point.any():
        joint.set("pos", decimals(point))
    if scenario.pushed["drag"]:
        joint.set("damping", decimals([scenario.pushed["drag"]]))


def _actuators(scenario: Scenario) -> Iterator[ET.Element]:
    """Yield actuators for the torques that joint damping cannot exert.

    These are the constant torques, and the drag on a free body. Damping of its free joint would
    slow the translation too, so that there are three actuators instead, one for each body axis.
    """
    effects = scenario.called_for
    if "torque_body" in effects:
        yield _actuator(scenario, "joint", scenario.pushed["torque_body"], constant=1.0)
    if "torque_world" in effects:
        # The actuator's axis is in the parent's axes, which are the world's.
        yield _actuator(scenario, "jointinparent", scenario.pushed["torque_world"], constant=1.0)
    if "drag" in effects and scenario.constraint.is_free:
        for axis in BODY_AXES:
            yield _actuator(scenario, "joint", axis, per_velocity=-scenario.pushed["drag"])


def _actuator(
    scenario: Scenario,
    transmission: str,
    axis: Iterable[float],
    constant: float = 0.0,
    per_velocity: float = 0.0,
) -> ET.Element:
    """Return an actuator that exerts the torque (constant + per_velocity · ω·axis) along `axis`.

    It acts on the joint of the scene's body, and does not depend on control signals.

    Parameters
    ----------
    transmission : MuJoCo's name of the transmission, which tells the axes that `axis` refers to
    axis : vector along the torque; its length multiplies the torque
    constant : the part of the torque that does not depend on ω, N m
    per_velocity : the factor of ω·axis in the torque, N m s
    """
    # The first three numbers of a free joint's gear are those of a force.
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
