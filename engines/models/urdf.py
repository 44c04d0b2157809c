"""A scene's body as URDF: what PyBullet loads, and a second way into MuJoCo.

URDF describes bodies and joints only. Gravity, other effects, the timestep and the start are set by
the adapters that load it.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from math import sqrt

from ...scenarios import Scenario
from .principal_frame import principal_frame
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
    """
    robot = ET.Element("robot", name=scenario.name)
    if scenario.constraint.is_pivot:
        ET.SubElement(robot, "link", name=WORLD_LINK)
    _add_body(robot, scenario, thickness)
    if shape_radius:
        _add_shape(robot, scenario.body.com, (0.0, 0.0, 0.0), "sphere", radius=[shape_radius])
    if has_box:
        frame = principal_frame(scenario.body, thickness)
        sides = box_sides(scenario.body.mass, frame.moments)
        _add_shape(robot, scenario.body.com, frame.rpy_body_axes, "box", size=sides)
    if scenario.constraint.is_pivot:
        _add_pivot(robot)
    return xml_text(robot)


def _add_body(robot: ET.Element, scenario: Scenario, thickness: float) -> None:
    body, frame = scenario.body, principal_frame(scenario.body, thickness)
    link = ET.SubElement(robot, "link", name=BODY_LINK)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=decimals(body.com), rpy=decimals(frame.rpy_body_axes))
    ET.SubElement(inertial, "mass", value=decimals([body.mass]))
    ixx, iyy, izz = (decimals([moment]) for moment in frame.moments)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)


def box_sides(mass: float, moments: Iterable[float]) -> list[float]:
    """Sides of the uniform box with these principal moments, m; of a flat body one is zero.

    From I₁ = m (b² + c²) / 12 and so on; the triangle inequality makes the squares positive.
    """
    moments = list(moments)
    return [sqrt(max(0.0, 6 * (sum(moments) - 2 * own) / mass)) for own in moments]


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
