"""Writes a scene's body as URDF: for PyBullet, and for MuJoCo as another encoding.

URDF describes bodies and joints only. Gravity, other effects, the timestep and the start are set by
the adapters that load it.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from mpmath import mp, mpf

from ...scenarios import Body, Scenario
from ...scenarios.exact import DIGITS, ZERO, Vector
from ...scenarios.gyrostat import Rotor
from .description import PLAIN, Description, parts_of
from .principal_frame import principal_frame, roll_pitch_yaw_of
from .shape import box_sides
from .text import decimals, xml_text

#: Name of the body's link; its frame is the scene's body frame.
BODY_LINK = "top"
#: The name of a link that engines take for the fixed world.
WORLD_LINK = "world"
PIVOT_JOINT = "pivot"
#: Mass and moments of a massless link. They must be stated: engines take a missing mass for 1 kg.
WEIGHTLESS = "0"
#: Limits of a slide, which URDF requires: PyBullet takes a lower limit above the upper for none.
UNLIMITED = {"lower": "1", "upper": "-1", "effort": "0", "velocity": "0"}
#: URDF's names of the entries of a tensor.
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
#: Number of documents that are kept, as a scene's document is the same at every timestep.
KEPT = 16
#: Position, m, or roll, pitch and yaw, rad, of a frame that is that of its parent.
NOWHERE = (0.0, 0.0, 0.0)
#: Axis that is stated for ball and fixed joints, as engines warn if there is none.
ANY_AXIS = (0.0, 0.0, 1.0)


@lru_cache(maxsize=KEPT)
def urdf(
    scenario: Scenario,
    thickness: float = 0.0,
    sphere: tuple[tuple[float, ...], float] | None = None,
    has_box: bool = False,
    description: Description = PLAIN,
    is_loose: bool = False,
) -> str:
    """Return the scene's body, with the joints that hold it, as a URDF document.

    A body on a pivot is connected to a fixed link, the world, by a ``spherical`` joint at its
    origin. A body on a table has such a joint at its tip, with massless links that slide between
    it and the world. A link's frame is at its joint, so that the frame of a held body is at the
    held point. A free body is the only link. (PyBullet would turn a ``floating`` joint into a fixed
    one; MuJoCo welds a single link to the world unless it is given a free joint.)

    The tensor is written as principal moments in a turned inertial frame: PyBullet diagonalises
    a full tensor itself, and only to 1e-10.

    Parameters
    ----------
    thickness : relative margin by which the largest moment stays below the sum of the others, for
        engines that refuse an entirely flat body (see `principal_frame`)
    sphere : centre, m, from the body's origin, body axes, and radius, m, of a collision sphere;
        None for no sphere
    has_box : whether to add a collision box: the uniform box with the body's tensor
    description : how the body is written; only `parts` and `full_tensor` matter here
    is_loose : whether even a held body is the only link, because the adapter holds it in another
        way
    """
    robot = ET.Element("robot", name=scenario.name)
    is_held = not (scenario.constraint.is_free or is_loose)
    held_at = _from(scenario.constraint.lever_exact, scenario.body.com_exact)
    point = held_at if is_held else ZERO
    onto = _add_slides(robot, scenario) if is_held else ""
    carrier = replace(scenario.carrier, com_exact=_from(point, scenario.carrier.com_exact))
    for index, part in enumerate(parts_of(carrier, description.parts)):
        name = f"{BODY_LINK}-{index}" if index else BODY_LINK
        _add_link(robot, name, part.body, thickness, whole=description.full_tensor)
        if part.onto is not None:
            parent = f"{BODY_LINK}-{part.onto}" if part.onto else BODY_LINK
            rpy = roll_pitch_yaw_of(part.q)
            _add_joint(robot, f"to-{name}", "fixed", (parent, name), part.position, rpy=rpy)
    if sphere:
        centre, radius = sphere
        _add_shape(robot, _from(point, centre), (0.0, 0.0, 0.0), "sphere", radius=[radius])
    if has_box:
        _add_box(robot, carrier, thickness)
    if is_held:
        place = NOWHERE if scenario.constraint.is_pivot else scenario.constraint.place_exact
        _add_joint(robot, PIVOT_JOINT, "spherical", (onto, BODY_LINK), place)
    for number, rotor in enumerate(scenario.rotors.each, start=1):
        place = _from(point, rotor.position)
        _add_rotor(robot, number, rotor, place, thickness, has_box)
    return xml_text(robot)


def _from(origin: Vector, place: Iterable[mpf]) -> Vector:
    """Return the vector from `origin` to `place`, m; both are given from the same point."""
    with mp.workdps(DIGITS):
        x, y, z = (of - at for of, at in zip(place, origin, strict=True))
    return (x, y, z)


def _add_slides(robot: ET.Element, scenario: Scenario) -> str:
    """Add a fixed link for the world, and massless links that slide; return the last link's name.

    They are added to `robot`, the URDF's outermost element. There is one sliding link for each axis
    along which the held point may move, each on the one before. For a pivot there is none, and the
    name is that of the fixed link.
    """
    ET.SubElement(robot, "link", name=WORLD_LINK)
    onto = WORLD_LINK
    for axis in np.flatnonzero(np.logical_not(scenario.constraint.is_held)):
        name = f"slide{axis}"
        inertial = ET.SubElement(ET.SubElement(robot, "link", name=name), "inertial")
        ET.SubElement(inertial, "mass", value=WEIGHTLESS)
        ET.SubElement(inertial, "inertia", dict.fromkeys(MOMENTS, WEIGHTLESS))
        _add_joint(robot, f"to-{name}", "prismatic", (onto, name), axis=np.eye(3)[axis])
        ET.SubElement(robot.findall("joint")[-1], "limit", UNLIMITED)
        onto = name
    return onto


def _add_rotor(
    robot: ET.Element,
    number: int,
    rotor: Rotor,
    place: Vector,
    thickness: float,
    has_box: bool,
) -> None:
    """Add a rotor as a link whose frame is at the rotor's com, and add its hinge.

    Parameters
    ----------
    robot : the URDF's outermost element
    number : number of the rotor, from 1
    place : the rotor's com in the frame of the body's link, m
    thickness : relative margin of the triangle inequality (see `urdf`)
    has_box : whether to add a collision box with the rotor's tensor
    """
    name, body = f"rotor{number}", replace(rotor.body, com_exact=ZERO)
    _add_link(robot, name, body, thickness)
    kind = "fixed" if rotor.hinge == "locked" else "continuous"
    axis = [float(component) for component in rotor.axis]
    _add_joint(robot, f"hinge{number}", kind, (BODY_LINK, name), place, axis)
    if has_box:
        _add_box(robot, body, thickness)


def _add_link(
    robot: ET.Element, name: str, body: Body | None, thickness: float, *, whole: bool = False
) -> None:
    """Add a link with the inertia of a body.

    Parameters
    ----------
    robot : the URDF's outermost element
    name : name of the link
    body : mass, com and tensor of the link; if None, the link states no inertia
    thickness : relative margin of the triangle inequality (see `urdf`); unused if `whole`
    whole : whether the tensor is written along the link's axes, with products of inertia; if not,
        the principal moments are written, and the inertial frame is turned
    """
    link = ET.SubElement(robot, "link", name=name)
    if body is None:
        return
    frame = principal_frame(body, thickness)
    inertial = ET.SubElement(link, "inertial")
    rpy = decimals(NOWHERE if whole else frame.rpy_body_axes)
    ET.SubElement(inertial, "origin", xyz=decimals(body.com), rpy=rpy)
    ET.SubElement(inertial, "mass", value=decimals([body.mass]))
    if whole:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = (map(repr, r) for r in body.inertia_com.tolist())
        ET.SubElement(inertial, "inertia", ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)
        return
    ixx, iyy, izz = (decimals([moment]) for moment in frame.moments)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)


def _add_box(robot: ET.Element, body: Body, thickness: float) -> None:
    """Add the uniform box with a body's tensor to the last link, as a collision shape.

    Parameters
    ----------
    robot : the URDF's outermost element
    body : the body, in the link's frame
    thickness : relative margin of the triangle inequality (see `urdf`)
    """
    frame = principal_frame(body, thickness)
    sides = box_sides(body.mass, frame.moments)
    _add_shape(robot, body.com, frame.rpy_body_axes, "box", size=sides)


def _add_shape(
    robot: ET.Element,
    center: Iterable[float],
    rpy: Iterable[float],
    shape: str,
    **sizes: Iterable[float],
) -> None:
    """Add a collision shape to the last link.

    Parameters
    ----------
    robot : the URDF's outermost element
    center : centre of the shape in the link's frame, m
    rpy : roll, pitch and yaw of the shape in the link's frame, rad
    shape : the shape's tag in URDF
    sizes : attributes of this tag, m
    """
    collision = ET.SubElement(robot.findall("link")[-1], "collision")
    ET.SubElement(collision, "origin", xyz=decimals(center), rpy=decimals(rpy))
    numbers = {name: decimals(values) for name, values in sizes.items()}
    ET.SubElement(ET.SubElement(collision, "geometry"), shape, numbers)


def _add_joint(
    robot: ET.Element,
    name: str,
    kind: str,
    links: tuple[str, str],
    place: Iterable[float] = NOWHERE,
    axis: Iterable[float] = ANY_AXIS,
    rpy: Iterable[float] = NOWHERE,
) -> None:
    """Add a joint between two links.

    Parameters
    ----------
    robot : the URDF's outermost element
    name : name of the joint
    kind : URDF's type of joint
    links : names of the parent and the child
    place : origin of the child's frame in the parent's frame, m
    axis : axis of the joint, along the axes of the child's frame
    rpy : roll, pitch and yaw of the child's frame in the parent's frame, rad
    """
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=links[0])
    ET.SubElement(joint, "child", link=links[1])
    ET.SubElement(joint, "origin", xyz=decimals(place), rpy=decimals(rpy))
    ET.SubElement(joint, "axis", xyz=decimals(axis))
