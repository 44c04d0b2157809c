"""Reads links and joints of a URDF, and writes the text of the URDF that engines are given."""

import re
from collections.abc import Collection, Iterable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray
from ..checks.read_back import EngineError
from .model_file import Link, ModelFile, Pose, RigidBody, Shape, Span, Stated
from .xml_tree import MAX_DEPTH, Element, ModelFileError, read_bytes, shown

ZEROS = (0.0, 0.0, 0.0)
_TENSOR = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
#: Type of a joint that does not move; every other type does.
FIXED = "fixed"


def urdf_links(robot: Element) -> tuple[Link, ...]:
    """Return the links of a robot, in the file's order.

    Raises
    ------
    ModelFileError
        If there are no links; if a name or value is missing, invalid or stated twice; or if links
        and joints form no tree.
    """
    elements: dict[str, Element] = {}
    for element in robot.all("link"):
        name = element.attributes.get("name", "")
        if not name:
            element.refuse("<link> lacks 'name'")
        if name in elements:
            element.refuse(f"a second link is named {shown(name)}; names must differ")
        elements[name] = element
    if not elements:
        robot.refuse(f"<{robot.tag}> has no <link>: there is nothing to inspect")
    joints = _joints(robot, elements)
    _check_tree(robot, elements, joints)
    return tuple(_link(name, element, joints.get(name)) for name, element in elements.items())


def _joints(robot: Element, links: dict[str, Element]) -> dict[str, tuple[str, Element]]:
    """Return the joint of each link that is the child of a joint, by the name of the child.

    The joint is given by the name of its parent link and its element. `ModelFileError` is raised if
    a joint does not name links of the file, or if a link is the child of two joints.

    Parameters
    ----------
    links : the elements of the links, by name
    """
    joints: dict[str, tuple[str, Element]] = {}
    for joint in robot.all("joint"):
        ends = {}
        for role in ("parent", "child"):
            end = joint.only(role)
            ends[role] = "" if end is None else end.attributes.get("link", "")
            if ends[role] not in links:
                joint.refuse(
                    f"{joint} must name a link of the file as its {role}, got {shown(ends[role])}"
                )
        if ends["child"] in joints:
            joint.refuse(f"{joint}: the link {shown(ends['child'])} hangs on a joint already")
        joints[ends["child"]] = (ends["parent"], joint)
    return joints


def _check_tree(
    robot: Element, links: dict[str, Element], joints: dict[str, tuple[str, Element]]
) -> None:
    """Raise `ModelFileError` unless the links form one tree, at most `MAX_DEPTH` joints deep.

    Parameters
    ----------
    robot : the file's outermost element
    links : the elements of the links, by name
    joints : the name of the parent link, and the joint, by the name of the child link
    """
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
    """Return the link that a `<link>` element describes.

    Parameters
    ----------
    joint : the name of the link's parent, and the element of the joint between the two; None for a
        root
    """
    parent, holder = joint or ("", None)
    inertial = element.only("inertial")
    return Link(
        name=name,
        where=element.where,
        stated=None if inertial is None else _stated(inertial),
        parent=parent,
        pose=Pose() if holder is None else _pose(holder),
        moves=holder is not None and holder.attributes.get("type") != FIXED,
        shapes=tuple(_shape(one) for one in element.children if one.tag in ("collision", "visual")),
        span=element.span,
        joint=(0, 0) if holder is None else holder.span,
    )


def _stated(inertial: Element) -> Stated:
    """Return mass, com and tensor that an `<inertial>` states, in the link's frame.

    It raises `ModelFileError` if the mass, the tensor or a number is missing.
    """
    mass, tensor = inertial.only("mass"), inertial.only("inertia")
    if mass is None or tensor is None:
        lacked = "mass" if mass is None else "inertia"
        inertial.refuse(f"<inertial> lacks <{lacked}>: engines do not fill in the same")
    pose = _pose(inertial)
    unturned = np.array([[tensor.numbers(key, 1)[0] for key in row] for row in _TENSOR])
    inertia = pose.R @ unturned @ pose.R.T
    (kilograms,) = mass.numbers("value", 1)
    return Stated(kilograms, pose.position, (inertia + inertia.T) / 2, unturned=unturned)


def _pose(element: Element) -> Pose:
    """Return the pose that an element's `origin` states, with R = Rz(yaw) Ry(pitch) Rx(roll).

    It is the identity if there is no `origin`.
    """
    origin = element.only("origin")
    if origin is None:
        return Pose()
    rpy = origin.numbers("rpy", 3, ZEROS)
    R = Rotation.from_euler("xyz", rpy).as_matrix() if any(rpy) else np.eye(3)
    return Pose(np.array(origin.numbers("xyz", 3, ZEROS)), R)


def _shape(element: Element) -> Shape:
    """Return the shape that a `<collision>` or `<visual>` element describes."""
    geometry = element.only("geometry")
    solid = geometry.children[0] if geometry is not None and geometry.children else None
    mesh = solid.attributes.get("filename") if solid is not None else None
    half = None if solid is None or mesh is not None else _half_extents(solid)
    box = None
    if half is not None:
        pose = _pose(element)
        # Half the sides, along the link's axes, of the box around the turned box.
        reach = np.abs(pose.R) @ half
        box = np.array([pose.position - reach, pose.position + reach])
    return Shape(box, element.span, mesh, element.tag == "collision")


def _half_extents(solid: Element) -> FloatArray | None:
    """Return half the sides of the box around a shape, along the shape's axes, m, (3,).

    It is None for an unknown kind of shape.
    """
    if solid.tag == "box":
        return np.array(solid.numbers("size", 3)) / 2
    if solid.tag == "sphere":
        return np.full(3, solid.numbers("radius", 1)[0])
    if solid.tag in ("cylinder", "capsule"):
        (radius,), (length,) = solid.numbers("radius", 1), solid.numbers("length", 1)
        ends = radius if solid.tag == "capsule" else 0.0
        return np.array([radius, radius, length / 2 + ends])
    return None


_FILENAME = re.compile(rb"""\bfilename\s*=\s*(?:"[^"]*"|'[^']*')""")
#: Largest size of a mesh, bytes; the largest in public packages have 40 million.
LARGEST_MESH = 1 << 28
#: Spans of a file, and the bytes that replace each.
Edits = list[tuple[Span, bytes]]


def with_meshes(
    model: ModelFile, links: Iterable[Link], endings: Collection[str]
) -> tuple[bytes, dict[str, bytes]]:
    """Return a URDF in which meshes have new names, so that an engine finds no other files.

    Parameters
    ----------
    links : links of which collision meshes are kept
    endings : file endings of the meshes that are kept, in small letters

    Returns
    -------
    data : the file without visual parts, and without collision shapes whose mesh is missing, lies
        outside the model's folders, or is not kept
    meshes : contents of the mesh files, by the names that they have in the returned URDF

    Raises
    ------
    EngineError
        If a mesh cannot be read or is too large.
    """
    wanted = {shape for link in links for shape in link.shapes if shape.ending in endings}
    edits, meshes = _edits(model, model.links, wanted)
    return edited(model.data, edits), meshes


def body_alone(
    model: ModelFile, body: RigidBody, endings: Collection[str] | None = None
) -> tuple[bytes, dict[str, bytes]]:
    """Return a URDF of one rigid body: its links and the joints between them, cut out of a model.

    Their text stays as it is, with three exceptions: visual shapes are removed, and so are
    collision shapes whose mesh is not kept; and kept meshes get new names.

    Parameters
    ----------
    model : the model from which the body is cut out
    endings : file endings of the collision meshes that are kept; if None, all shapes are removed

    Returns
    -------
    The bytes of the URDF; and the contents of the kept mesh files, by the names that they have in
    the URDF

    Raises
    ------
    EngineError
        If a mesh cannot be read or is too large.
    """
    links = [link for link, _ in body.parts]
    shapes = [shape for link in links for shape in link.shapes]
    wanted = {shape for shape in shapes if endings is not None and shape.ending in endings}
    edits, meshes = _edits(model, links, wanted)
    if endings is None:
        edits = [(shape.span, b"") for shape in shapes]
    cut = []
    for start, end in [link.span for link in links] + [link.joint for link in links[1:]]:
        own = [((a - start, b - start), new) for (a, b), new in edits if start <= a < end]
        cut.append(edited(model.data[start:end], own))
    return b"".join([b'<robot name="cut">', *cut, b"</robot>"]), meshes


def edited(data: bytes, edits: Edits) -> bytes:
    """Return a file's bytes with spans of it replaced, as edits state.

    A span inside of another one goes with that; spans must not overlap otherwise.
    """
    parts, at = [], 0
    for (start, end), new in sorted(edits):
        if start >= at:
            parts += [data[at:start], new]
            at = end
    return b"".join([*parts, data[at:]])


def mesh_bytes(model: ModelFile, name: str) -> bytes | None:
    """Return the contents of a mesh that a model names; None if it is not in the model's folders.

    References to materials in an OBJ file are turned into comments, since PyBullet would open these
    files wherever they are.

    Raises
    ------
    EngineError
        If the mesh cannot be read or is too large.
    """
    path = model.folders.find(name)
    if path is None:
        return None
    try:
        data = read_bytes(path, LARGEST_MESH)
    except ModelFileError as error:
        raise EngineError(str(error)) from None
    return data.replace(b"mtllib", b"#") if Path(name).suffix.lower() == ".obj" else data


def _edits(
    model: ModelFile, links: Iterable[Link], wanted: Collection[Shape]
) -> tuple[Edits, dict[str, bytes]]:
    """Return edits of the shapes of some links, and the contents of meshes by their new names.

    An edit is a span of the file, and the bytes that replace it. The edits write new names for the
    meshes of wanted collision shapes. They remove all visual shapes, and collision shapes with any
    other mesh.

    Parameters
    ----------
    wanted : shapes whose meshes are kept
    """
    edits: Edits = []
    meshes: dict[str, bytes] = {}
    for shape in (shape for link in links for shape in link.shapes):
        mesh = None
        if shape.collides and shape.mesh is not None and shape in wanted:
            mesh = mesh_bytes(model, shape.mesh)
        if mesh is not None:
            name = f"mesh-{len(meshes)}{shape.ending}"
            meshes[name] = mesh
            start, end = shape.span
            named = f'filename="{name}"'.encode()
            edits.append((shape.span, _FILENAME.sub(named, model.data[start:end])))
        elif not shape.collides or shape.mesh is not None:
            edits.append((shape.span, b""))
    return edits, meshes
