"""What an MJCF file states: `body/inertial`, after includes, frames and replicates."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..float_array import FloatArray
from .mjcf_bounds import include_and_check
from .model_file import IDENTITY, Folders, Link, Pose, Stated
from .xml_tree import Element, numbers, shown, vector

#: More bodies than any robot has; `replicate` can ask for any number.
MAX_BODIES = 10_000
#: Elements that generate bodies.
MAKERS = ("attach", "composite", "flexcomp", "flex")
ZEROS = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Compiler:
    """The settings of MuJoCo's compiler that say what the numbers of a file mean."""

    degrees: bool
    eulerseq: str
    from_shapes: bool


def read_mjcf(root: Element, folders: Folders) -> tuple[tuple[Link, ...], tuple[str, ...]]:
    """The bodies of a model, in the file's order, and what was not read of it.

    Raises
    ------
    ModelFileError
        If a number is not one, an include lies outside the folders, or there are too many bodies.
    """
    include_and_check(root, folders)
    reader = _Reader(_compiler(root))
    for world in root.all("worldbody"):
        reader.read(world, "", IDENTITY)
    if not reader.links:
        root.refuse("<mujoco> has no <body>: there is nothing to inspect")
    return tuple(reader.links), tuple(reader.notes)


def _compiler(root: Element) -> Compiler:
    settings: dict[str, str] = {}
    for element in root.all("compiler"):
        settings |= element.attributes
    sequence = settings.get("eulerseq", "xyz")
    if len(sequence) != 3 or set(sequence) - set("xyzXYZ"):
        root.refuse(f"'eulerseq' must be three of x, y, z, X, Y, Z, got {shown(sequence)}")
    return Compiler(
        degrees=settings.get("angle", "degree") == "degree",
        eulerseq=sequence,
        from_shapes=settings.get("inertiafromgeom") == "true",
    )


class _Reader:
    """Walks a world's bodies; their nesting is bounded by that of the elements."""

    def __init__(self, compiler: Compiler) -> None:
        self._compiler = compiler
        self._unnamed = 0
        self.links: list[Link] = []
        self.notes: list[str] = []

    def read(self, element: Element, parent: str, frame: Pose) -> None:
        """The bodies of an element.

        Parameters
        ----------
        parent : name of the body that they hang on; empty for the world
        frame : of the element in the parent's
        """
        for child in element.children:
            if child.tag == "body":
                self._body(child, parent, frame)
            elif child.tag == "frame":
                self.read(child, parent, frame.then(_pose(child, self._compiler)))
            elif child.tag == "replicate":
                self._replicate(child, parent, frame)
            elif child.tag in MAKERS:
                self.notes.append(f"{child.where}: bodies that <{child.tag}> makes are not read")

    def _body(self, element: Element, parent: str, frame: Pose) -> None:
        if len(self.links) == MAX_BODIES:
            element.refuse(f"more than {MAX_BODIES} bodies")
        name = element.attributes.get("name") or self._next_unnamed()
        inertial = element.only("inertial")
        by_shapes = self._compiler.from_shapes or (inertial is None and _has_shapes(element))
        self.links.append(
            Link(
                name=name,
                where=element.where,
                stated=None if inertial is None or by_shapes else _stated(inertial, self._compiler),
                parent=parent,
                pose=frame.then(_pose(element, self._compiler)),
                moves=any(child.tag in ("joint", "freejoint") for child in element.children),
                span=(element.start, element.end),
                by_shapes=by_shapes,
            )
        )
        self.read(element, name, IDENTITY)

    def _replicate(self, element: Element, parent: str, frame: Pose) -> None:
        count = int(vector(element, "count", 1)[0])
        before, separator = len(self.links), element.attributes.get("sep", "")
        self.read(element, parent, frame)
        once = self.links[before:]
        del self.links[before:]
        own = {link.name for link in once}
        for index in range(count):
            suffix = f"{separator}{index:0{len(str(count - 1))}d}"
            self.links += [
                replace(
                    link,
                    name=link.name + suffix,
                    parent=link.parent + suffix if link.parent in own else link.parent,
                )
                for link in once
            ]

    def _next_unnamed(self) -> str:
        self._unnamed += 1
        return unnamed(self._unnamed)


def _has_shapes(element: Element) -> bool:
    return any(
        child.tag == "geom" or (child.tag in ("frame", "replicate") and _has_shapes(child))
        for child in element.children
    )


def unnamed(number: int) -> str:
    """What the n-th body without a name is called."""
    return f"(body {number})"


def _stated(inertial: Element, compiler: Compiler) -> Stated:
    pose = _pose(inertial, compiler)
    if "fullinertia" in inertial.attributes:
        xx, yy, zz, xy, xz, yz = vector(inertial, "fullinertia", 6)
        unturned = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        unturned = np.diag(vector(inertial, "diaginertia", 3))
    inertia = pose.R @ unturned @ pose.R.T
    mass = vector(inertial, "mass", 1)[0]
    return Stated(mass, pose.position, (inertia + inertia.T) / 2, unturned)


def _pose(element: Element, compiler: Compiler) -> Pose:
    return Pose(np.array(vector(element, "pos", 3, ZEROS)), _rotation(element, compiler))


def _rotation(element: Element, compiler: Compiler) -> FloatArray:
    """The rotation, given in one of MJCF's five ways (XML reference, *Frame orientations*)."""
    stated_keys = [key for key in _BY if key in element.attributes]
    if len(stated_keys) > 1:
        element.refuse(
            f"{element} gives its rotation twice: '{stated_keys[0]}' and '{stated_keys[1]}'"
        )
    if not stated_keys:
        return np.eye(3)
    length, build = _BY[stated_keys[0]]
    values = np.array(numbers(element, stated_keys[0], element.attributes[stated_keys[0]], length))
    if not values.any() and stated_keys[0] != "euler":
        element.refuse(f"'{stated_keys[0]}' of <{element.tag}> must not be zero")
    return build(values, compiler).as_matrix()


def _by_quat(values: FloatArray, compiler: Compiler) -> Rotation:  # noqa: ARG001
    return Rotation.from_quat(values, scalar_first=True)


def _by_axis_angle(values: FloatArray, compiler: Compiler) -> Rotation:
    axis = values[:3] / np.linalg.norm(values[:3])
    return Rotation.from_rotvec(axis * values[3], degrees=compiler.degrees)


def _by_euler(values: FloatArray, compiler: Compiler) -> Rotation:
    """Small letters turn with the frame, capitals stay."""
    total = Rotation.identity()
    for letter, angle in zip(compiler.eulerseq, values, strict=True):
        one = Rotation.from_euler(letter.lower(), angle, degrees=compiler.degrees)
        total = total * one if letter.islower() else one * total
    return total


def _by_xy(values: FloatArray, compiler: Compiler) -> Rotation:  # noqa: ARG001
    x = values[:3] / np.linalg.norm(values[:3])
    y = values[3:] - (values[3:] @ x) * x
    y /= np.linalg.norm(y)
    return Rotation.from_matrix(np.column_stack([x, y, np.cross(x, y)]))


def _by_z(values: FloatArray, compiler: Compiler) -> Rotation:  # noqa: ARG001
    """The least rotation that takes z there."""
    z = values / np.linalg.norm(values)
    axis = np.cross([0.0, 0.0, 1.0], z)
    sine = float(np.linalg.norm(axis))
    if sine == 0:
        axis, sine = np.array([1.0, 0.0, 0.0]), 1.0 if z[2] < 0 else 0.0
        return Rotation.from_rotvec(np.pi * axis * sine)
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, z[2]))


_BY = {
    "quat": (4, _by_quat),
    "axisangle": (4, _by_axis_angle),
    "euler": (3, _by_euler),
    "xyaxes": (6, _by_xy),
    "zaxis": (3, _by_z),
}
