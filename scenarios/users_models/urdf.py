"""What a URDF states: `link/inertial`, and the joints that say which links move together."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..float_array import FloatArray
from .model_file import IDENTITY, Link, Pose, Shape, Stated
from .xml_tree import MAX_DEPTH, Element, number, shown, vector

ZEROS = (0.0, 0.0, 0.0)
_TENSOR = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
#: The word for a joint that does not move; every other kind does.
FIXED = "fixed"


def urdf_links(robot: Element) -> tuple[Link, ...]:
    """The links of a robot, in the file's order.

    Raises
    ------
    ModelFileError
        If a number is not one, or links and joints make no tree.
    """
    elements: dict[str, Element] = {}
    for element in robot.all("link"):
        name = _name(element)
        if name in elements:
            element.refuse(f"a second link is named {shown(name)}; names must differ")
        elements[name] = element
    if not elements:
        robot.refuse(f"<{robot.tag}> has no <link>: there is nothing to inspect")
    joints = _joints(robot, elements)
    _check_tree(robot, elements, joints)
    return tuple(_link(name, element, joints.get(name)) for name, element in elements.items())


def _name(element: Element) -> str:
    name = element.attributes.get("name", "")
    if not name:
        element.refuse(f"<{element.tag}> lacks 'name'")
    return name


def _joints(robot: Element, links: dict[str, Element]) -> dict[str, tuple[str, Element]]:
    """The parent's name and the joint, by the child's name."""
    joints: dict[str, tuple[str, Element]] = {}
    for joint in robot.all("joint"):
        ends = []
        for role in ("parent", "child"):
            end = joint.only(role)
            name = "" if end is None else end.attributes.get("link", "")
            if name not in links:
                joint.refuse(
                    f"{joint} must name a link of the file as its {role}, got {shown(name)}"
                )
            ends.append(name)
        parent, child = ends
        if child in joints:
            joint.refuse(f"{joint}: the link {shown(child)} hangs on a joint already")
        joints[child] = (parent, joint)
    return joints


def _check_tree(
    robot: Element, links: dict[str, Element], joints: dict[str, tuple[str, Element]]
) -> None:
    roots = [name for name in links if name not in joints]
    if len(roots) > 1:
        links[roots[1]].refuse(
            f"links {shown(roots[0])} and {shown(roots[1])} both hang on no joint; engines want "
            "one root"
        )
    depths = dict.fromkeys(roots, 0)
    for name in links:
        path: dict[str, None] = {}
        while name not in depths:
            if name in path:
                robot.refuse(f"joints lead from the link {shown(name)} back to itself")
            path[name] = None
            name = joints[name][0]
        for below in reversed(path):
            depths[below] = depths[joints[below][0]] + 1
            if depths[below] > MAX_DEPTH:
                links[below].refuse(f"links hang on each other more than {MAX_DEPTH} deep")


def _link(name: str, element: Element, joint: tuple[str, Element] | None) -> Link:
    parent, holder = joint or ("", None)
    return Link(
        name=name,
        where=element.where,
        stated=_stated(element.only("inertial")),
        parent=parent,
        pose=IDENTITY if holder is None else _pose(holder),
        moves=holder is not None and holder.attributes.get("type") != FIXED,
        shapes=_shapes(element),
        span=(element.start, element.end),
        joint=(0, 0) if holder is None else (holder.start, holder.end),
    )


def _stated(inertial: Element | None) -> Stated | None:
    if inertial is None:
        return None
    mass, tensor = inertial.only("mass"), inertial.only("inertia")
    for part, what in ((mass, "mass"), (tensor, "inertia")):
        if part is None:
            inertial.refuse(f"<inertial> lacks <{what}>: engines do not fill in the same")
    assert mass is not None
    assert tensor is not None
    pose = _pose(inertial)
    unturned = np.array([[number(tensor, key) for key in row] for row in _TENSOR])
    with np.errstate(over="ignore", invalid="ignore"):
        inertia = pose.R @ unturned @ pose.R.T
        inertia = (inertia + inertia.T) / 2
    if not np.isfinite(inertia).all():
        inertial.refuse("the inertia is too large to be computed with")
    return Stated(number(mass, "value"), pose.position, inertia, unturned)


def _pose(element: Element) -> Pose:
    """The pose in the element's `origin`; R = Rz(yaw) Ry(pitch) Rx(roll)."""
    origin = element.only("origin")
    if origin is None:
        return IDENTITY
    rpy = vector(origin, "rpy", 3, ZEROS)
    R = np.eye(3) if not any(rpy) else Rotation.from_euler("xyz", rpy).as_matrix()
    return Pose(np.array(vector(origin, "xyz", 3, ZEROS)), R)


def _shapes(link: Element) -> tuple[Shape, ...]:
    shapes = []
    for element in link.children:
        if element.tag not in ("collision", "visual"):
            continue
        geometry = element.only("geometry")
        solid = geometry.children[0] if geometry is not None and geometry.children else None
        mesh = solid.attributes.get("filename") if solid is not None else None
        half = None if solid is None or mesh is not None else _half_extents(solid)
        low = high = None
        if half is not None:
            pose = _pose(element)
            # Of a turned box, the box around it.
            reach = np.abs(pose.R) @ half
            low, high = pose.position - reach, pose.position + reach
        span = (element.start, element.end)
        shapes.append(Shape(low, high, span, mesh, element.tag == "collision"))
    return tuple(shapes)


def _half_extents(solid: Element) -> FloatArray | None:
    """Half a box around a shape, along its own axes, m; None of a kind that is not known."""
    if solid.tag == "box":
        return np.array(vector(solid, "size", 3)) / 2
    if solid.tag == "sphere":
        return np.full(3, number(solid, "radius"))
    if solid.tag in ("cylinder", "capsule"):
        radius, length = number(solid, "radius"), number(solid, "length")
        ends = radius if solid.tag == "capsule" else 0.0
        return np.array([radius, radius, length / 2 + ends])
    return None
