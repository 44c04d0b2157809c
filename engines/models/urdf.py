"""A scene's body as URDF: what PyBullet loads, and a second way into MuJoCo.

URDF describes bodies and joints only. Gravity, other effects, the timestep and the start are set by
the adapters that load it.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable

from ...scenarios import Body, Scenario
from .description import PLAIN, Description, Part, parts_of
from .principal_frame import principal_frame, roll_pitch_yaw_of
from .shape import box_of
from .text import decimals, xml_text

#: Name of the body's link; its frame is the scene's body frame.
BODY_LINK = "top"
#: The name that both readers take for the fixed world.
WORLD_LINK = "world"
PIVOT_JOINT = "pivot"


def urdf(
    scenario: Scenario,
    thickness: float = 0.0,
    shape_radius: float = 0.0,
    has_box: bool = False,
    description: Description = PLAIN,
) -> str:
    """The scene's body, and its pivot where there is one, as a URDF document.

    A pivoted body hangs by a ``spherical`` joint at its own origin on a fixed link at the world's
    origin. A free body is the only link. (PyBullet would turn a ``floating`` joint into a fixed
    one; MuJoCo welds a single link to the world unless it is given a free joint.)

    The tensor is written as principal moments in a turned inertial frame: PyBullet diagonalises
    a full tensor itself, and only to 1e-10.

    Parameters
    ----------
    thickness : as in `principal_frame`, for a reader that refuses an entirely flat body
    shape_radius : m, of a collision sphere about the com; none if zero
    has_box : whether to add a collision box: the uniform box with the body's tensor
    description : how the body is written: its parts, and whether tensors are whole
    """
    robot = ET.Element("robot", name=scenario.name)
    if scenario.constraint.is_pivot:
        ET.SubElement(robot, "link", name=WORLD_LINK)
    for index, part in enumerate(parts_of(scenario.body, description.parts)):
        name = f"{BODY_LINK}-{index}" if index else BODY_LINK
        link = ET.SubElement(robot, "link", name=name)
        if part.body is not None:
            _add_inertial(link, part.body, thickness, whole=description.full_tensor)
        if part.onto is not None:
            _add_weld(robot, name, part)
    if shape_radius:
        _add_shape(robot, scenario.body.com, (0.0, 0.0, 0.0), "sphere", radius=[shape_radius])
    if has_box:
        frame = principal_frame(scenario.body, thickness)
        box = box_of(scenario.body.mass, frame.moments)
        _add_shape(robot, scenario.body.com, frame.rpy_body_axes, "box", size=box.sides)
    if scenario.constraint.is_pivot:
        _add_pivot(robot)
    return xml_text(robot)


def _add_inertial(link: ET.Element, body: Body, thickness: float, *, whole: bool) -> None:
    frame = principal_frame(body, thickness)
    inertial = ET.SubElement(link, "inertial")
    rpy = decimals((0.0, 0.0, 0.0) if whole else frame.rpy_body_axes)
    ET.SubElement(inertial, "origin", xyz=decimals(body.com), rpy=rpy)
    ET.SubElement(inertial, "mass", value=decimals([body.mass]))
    if whole:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = (
            [repr(i) for i in r] for r in body.inertia_com.tolist()
        )
        ET.SubElement(inertial, "inertia", ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)
        return
    ixx, iyy, izz = (decimals([moment]) for moment in frame.moments)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)


def _add_weld(robot: ET.Element, name: str, part: Part) -> None:
    parent = f"{BODY_LINK}-{part.onto}" if part.onto else BODY_LINK
    joint = ET.SubElement(robot, "joint", name=f"to-{name}", type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=name)
    rpy = decimals(roll_pitch_yaw_of(part.q))
    ET.SubElement(joint, "origin", xyz=decimals(part.position), rpy=rpy)


def _add_shape(
    robot: ET.Element,
    center: Iterable[float],
    rpy: Iterable[float],
    shape: str,
    **sizes: Iterable[float],
) -> None:
    collision = ET.SubElement(robot.findall("link")[-1], "collision")
    ET.SubElement(collision, "origin", xyz=decimals(center), rpy=decimals(rpy))
    numbers = {name: decimals(values) for name, values in sizes.items()}
    ET.SubElement(ET.SubElement(collision, "geometry"), shape, numbers)


def _add_pivot(robot: ET.Element) -> None:
    joint = ET.SubElement(robot, "joint", name=PIVOT_JOINT, type="spherical")
    ET.SubElement(joint, "parent", link=WORLD_LINK)
    ET.SubElement(joint, "child", link=BODY_LINK)
    ET.SubElement(joint, "origin", xyz="0 0 0", rpy="0 0 0")
    # A ball joint has no axis, but readers warn if none is given.
    ET.SubElement(joint, "axis", xyz="0 0 1")
