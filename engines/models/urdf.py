"""A scene's body as URDF: what PyBullet loads, and a second way into MuJoCo.

URDF describes bodies and joints only. Gravity, other effects, the timestep and the start are set by
the adapters that load it.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from math import sqrt

from ...scenarios import Scenario
from ...scenarios.effects.rotors import Rotor
from .principal_frame import PrincipalFrame, principal_frame
from .text import decimals, xml_text

#: Name of the body's link; its frame is the scene's body frame.
BODY_LINK = "top"
#: The name that both readers take for the fixed world.
WORLD_LINK = "world"
PIVOT_JOINT = "pivot"
#: m, and rad: where a joint is that is at its link's origin.
NOWHERE = (0.0, 0.0, 0.0)
#: A ball joint has no axis, but readers warn if none is given.
ANY_AXIS = (0.0, 0.0, 1.0)


def urdf(
    scenario: Scenario,
    thickness: float = 0.0,
    sphere: tuple[Iterable[float], float] | None = None,
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
    sphere : centre and radius of a collision sphere, m, body axes
    has_box : whether to add a collision box: the uniform box with the body's tensor
    """
    robot = ET.Element("robot", name=scenario.name)
    if scenario.constraint.is_pivot:
        ET.SubElement(robot, "link", name=WORLD_LINK)
    frame = principal_frame(scenario.carrier, thickness)
    _add_link(robot, BODY_LINK, scenario.carrier.mass, scenario.carrier.com, frame)
    if sphere:
        centre, radius = sphere
        _add_shape(robot, centre, (0.0, 0.0, 0.0), "sphere", radius=[radius])
    if has_box:
        sides = box_sides(scenario.carrier.mass, frame.moments)
        _add_shape(robot, scenario.carrier.com, frame.rpy_body_axes, "box", size=sides)
    if scenario.constraint.is_pivot:
        _add_joint(robot, PIVOT_JOINT, "spherical", (WORLD_LINK, BODY_LINK))
    for number, rotor in enumerate(scenario.rotors.each, start=1):
        _add_rotor(robot, number, rotor, principal_frame(rotor.body, thickness), has_box)
    return xml_text(robot)


def _add_rotor(
    robot: ET.Element, number: int, rotor: Rotor, frame: PrincipalFrame, has_box: bool
) -> None:
    """A link whose frame is at the rotor's centre of mass, and its hinge."""
    name, mass = f"rotor{number}", rotor.body.mass
    _add_link(robot, name, mass, NOWHERE, frame)
    kind = "fixed" if rotor.hinge == "locked" else "continuous"
    axis = [float(component) for component in rotor.axis]
    _add_joint(robot, f"hinge{number}", kind, (BODY_LINK, name), rotor.body.com, axis)
    if has_box:
        sides = box_sides(mass, frame.moments)
        _add_shape(robot, NOWHERE, frame.rpy_body_axes, "box", size=sides)


def _add_link(
    robot: ET.Element, name: str, mass: float, com: Iterable[float], frame: PrincipalFrame
) -> None:
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=decimals(com), rpy=decimals(frame.rpy_body_axes))
    ET.SubElement(inertial, "mass", value=decimals([mass]))
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


def _add_joint(
    robot: ET.Element,
    name: str,
    kind: str,
    links: tuple[str, str],
    place: Iterable[float] = NOWHERE,
    axis: Iterable[float] = ANY_AXIS,
) -> None:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=links[0])
    ET.SubElement(joint, "child", link=links[1])
    ET.SubElement(joint, "origin", xyz=decimals(place), rpy=decimals(NOWHERE))
    ET.SubElement(joint, "axis", xyz=decimals(axis))
