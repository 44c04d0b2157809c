"""Reads the bodies of an MJCF file, with includes, frames and replicates, and their inertials.

`mujoco.MjSpec` is not used, for three reasons: MuJoCo's own reading is what is checked, a file may
crash it, and it does not keep the elements' places in the file.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray
from .mjcf_files import CheckedFiles
from .model_file import Link, Pose, Stated
from .xml_tree import Element, shown

#: Largest number of bodies, as `replicate` could ask for any number. No robot has so many.
MAX_BODIES = 10_000
#: Tags of elements that generate bodies, which are not read.
MAKERS = ("attach", "composite", "flexcomp", "flex")
ZEROS = (0.0, 0.0, 0.0)
#: Options of MuJoCo's compiler that make its bodies differ from the file's, and what they do.
CHANGING = {
    "boundmass": "raises smaller masses",
    "boundinertia": "raises smaller moments of inertia",
    "balanceinertia": "replaces the moments of tensors that no body has by their mean",
    "settotalmass": "scales all masses and tensors",
}
#: The same in a URDF. In an MJCF this option is common, and its bodies are read as those of shapes.
CHANGING_URDF = CHANGING | {"inertiafromgeom": "computes masses and tensors from shapes"}
#: Least angle between the two axes of `xyaxes`, rad: with a smaller one, rounding would decide.
LEAST_ANGLE = 1e-9


def read_mjcf(root: Element, files: CheckedFiles) -> tuple[tuple[Link, ...], tuple[str, ...]]:
    """Return the bodies of a model, in the file's order, and notes.

    The notes are sentences on what was not read, and on options by which MuJoCo changes bodies.

    Parameters
    ----------
    root : the element `mujoco`; `files` inserts included files into it
    files : checks the files that the model names

    Raises
    ------
    ModelFileError
        If there are no bodies or too many, if a value is missing, is not a number or is stated
        twice, or if `files` refuses a file or the number of elements.
    """
    files.check(root)
    reader = _Reader(root.file, _compiler(root), notes=changing_options(root, CHANGING))
    for world in root.all("worldbody"):
        reader.read(world, "", Pose())
    if not reader.links:
        root.refuse("<mujoco> has no <body>: there is nothing to inspect")
    return tuple(reader.links), tuple(reader.notes)


def changing_options(root: Element, options: Mapping[str, str]) -> list[str]:
    """Return a sentence on each option that makes MuJoCo's bodies differ from the file's.

    Parameters
    ----------
    root : the element `mujoco` of an MJCF, or inside a URDF
    options : what each such option does, in words, by the option's name
    """
    return [
        f"{element.where}: MuJoCo's option {key}={shown(element.attributes[key])} {does}; without "
        "it MuJoCo holds what the file states"
        for element in root.all("compiler")
        for key, does in options.items()
        if _is_set(element, key)
    ]


def _is_set(element: Element, key: str) -> bool:
    """Whether the option `key` of the compiler is on: its value is `true`, or a number above 0."""
    value = element.attributes.get(key, "false")
    return value == "true" or (value not in ("false", "auto") and element.numbers(key, 1)[0] > 0)


@dataclass(frozen=True)
class Compiler:
    """The settings of MuJoCo's compiler that say what the numbers of a file mean.

    Attributes
    ----------
    degrees : whether angles are in degrees
    eulerseq : the axes of the three Euler angles in order; small letters are axes of the frame that
        is being turned, capital letters axes of the parent frame
    from_shapes : whether inertia is computed from shapes even where the file states it
    """

    degrees: bool
    eulerseq: str
    from_shapes: bool


def _compiler(root: Element) -> Compiler:
    """Return the compiler's settings in a file; raise `ModelFileError` if `eulerseq` is invalid."""
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


@dataclass
class _Reader:
    """Reads the bodies of a model by recursion; `MAX_DEPTH` limits how deep elements are nested.

    Attributes
    ----------
    file : name of the model's own file, as `Element.file` has it
    compiler : the settings by which numbers are read
    unnamed : number of bodies without a name so far
    links : the bodies that were read so far
    notes : sentences on what was not read
    """

    file: str
    compiler: Compiler
    unnamed: int = 0
    links: list[Link] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def read(self, element: Element, parent: str, frame: Pose) -> None:
        """Read the bodies inside an element.

        Parameters
        ----------
        element : the element; it has bodies, frames or replicates as children
        parent : name of the body to which these bodies are attached; empty for the world
        frame : pose of the element's frame in the parent's frame
        """
        for child in element.children:
            if child.tag == "body":
                self._body(child, parent, frame)
            elif child.tag == "frame":
                self.read(child, parent, frame.then(_pose(child, self.compiler)))
            elif child.tag == "replicate":
                self._replicate(child, parent, frame)
            elif child.tag in MAKERS:
                self.notes.append(f"{child.where}: bodies that <{child.tag}> makes are not read")

    def _body(self, element: Element, parent: str, frame: Pose) -> None:
        """Read one body and the bodies inside it.

        Parameters
        ----------
        element : the element `body`
        parent : name of the body that it is attached to; empty for the world
        frame : pose, in that body's frame, of the frame in which the element states its own pose
        """
        if len(self.links) == MAX_BODIES:
            element.refuse(f"more than {MAX_BODIES} bodies")
        name = element.attributes.get("name", "")
        if not name:
            self.unnamed += 1
            name = f"(body {self.unnamed})"
        inertials = inertials_of(element)
        if len(inertials) > 1:
            second, _ = inertials[1]
            second.refuse(f"a second <inertial> in {element}: engines do not take the same one")
        by_shapes = self.compiler.from_shapes or (not inertials and _has(element, "geom"))
        self.links.append(
            Link(
                name=name,
                where=element.where,
                stated=None
                if by_shapes or not inertials
                else _stated(*inertials[0], self.compiler),
                parent=parent,
                pose=frame.then(_pose(element, self.compiler)),
                moves=_has(element, "joint", "freejoint"),
                by_shapes=by_shapes,
                makes_others=_has(element, *MAKERS),
                span=element.span if element.file == self.file else (0, 0),
            )
        )
        # The name is set only now, as messages show the element as it is in the file.
        element.attributes["name"] = name
        self.read(element, name, Pose())

    def _replicate(self, element: Element, parent: str, frame: Pose) -> None:
        """Read the bodies inside a `replicate`, and add as many copies as its count says.

        Copies have names of their own. Each is moved by `offset` and turned by `euler` relative to
        the one before, along the axes of that one (MuJoCo's XML reference, *replicate*).

        Parameters
        ----------
        element : the element `replicate`
        parent : name of the body to which these bodies are attached; empty for the world
        frame : pose of the element's frame in the parent's frame
        """
        (count,) = element.numbers("count", 1)
        before, separator = len(self.links), element.attributes.get("sep", "")
        self.read(element, parent, Pose())
        once = self.links[before:]
        del self.links[before:]
        own = {link.name for link in once}
        turn = _by_euler(np.array(element.numbers("euler", 3, ZEROS)), self.compiler).as_matrix()
        step = Pose(np.array(element.numbers("offset", 3, ZEROS)), turn)
        for index in range(int(count)):
            suffix = f"{separator}{index:0{len(str(int(count) - 1))}d}"
            self.links += [
                replace(link, name=link.name + suffix, parent=link.parent + suffix)
                if link.parent in own
                else replace(link, name=link.name + suffix, pose=frame.then(link.pose))
                for link in once
            ]
            frame = frame.then(step)


def inertials_of(body: Element) -> list[tuple[Element, tuple[Element, ...]]]:
    """Return each `inertial` of a body, with the frames that contain it, from the outermost on."""
    found: list[tuple[Element, tuple[Element, ...]]] = [(one, ()) for one in body.all("inertial")]
    for frame in body.all("frame"):
        found += [(one, (frame, *inner)) for one, inner in inertials_of(frame)]
    return found


def _has(element: Element, *tags: str) -> bool:
    """Whether a body has a part with one of the tags, also inside of frames and replicates."""
    return any(
        child.tag in tags or (child.tag in ("frame", "replicate") and _has(child, *tags))
        for child in element.children
    )


def _stated(inertial: Element, frames: tuple[Element, ...], compiler: Compiler) -> Stated:
    """Return mass, com and tensor that an `inertial` states, in the body's frame.

    It raises `ModelFileError` if a number is missing or invalid.

    Parameters
    ----------
    frames : the frames that contain the `inertial`, from the outermost on
    compiler : the settings by which numbers are read
    """
    pose = Pose()
    for element in (*frames, inertial):
        pose = pose.then(_pose(element, compiler))
    if "fullinertia" in inertial.attributes:
        xx, yy, zz, xy, xz, yz = inertial.numbers("fullinertia", 6)
        unturned = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        unturned = np.diag(inertial.numbers("diaginertia", 3))
    inertia = pose.R @ unturned @ pose.R.T
    (mass,) = inertial.numbers("mass", 1)
    return Stated(mass, pose.position, (inertia + inertia.T) / 2, unturned=unturned)


def _pose(element: Element, compiler: Compiler) -> Pose:
    """Return the pose that an element states in its parent's frame; by default the identity.

    `compiler` has the settings by which numbers are read.
    """
    return Pose(np.array(element.numbers("pos", 3, ZEROS)), _rotation(element, compiler))


def _rotation(element: Element, compiler: Compiler) -> FloatArray:
    """Return the rotation matrix that an element states, (3, 3); by default the identity.

    There are five ways to state it (`WAYS`; MuJoCo's XML reference, *Frame orientations*).
    `ModelFileError` is raised if an element states two of them, a vector of zero, or two parallel
    axes. `compiler` has the settings by which numbers are read.
    """
    ways = [key for key in WAYS if key in element.attributes]
    if len(ways) > 1:
        element.refuse(f"{element} gives its rotation twice: '{ways[0]}' and '{ways[1]}'")
    if not ways:
        return np.eye(3)
    length, rotation = WAYS[ways[0]]
    values = np.array(element.numbers(ways[0], length))
    try:
        return rotation(values, compiler).as_matrix()
    except ValueError as rule:
        element.refuse(f"'{ways[0]}' of <{element.tag}> {rule}")


def _unit(vector: FloatArray) -> FloatArray:
    """Return a vector divided by its length, however small; raise ValueError if it is zero."""
    largest = np.abs(vector).max()
    if not largest:
        raise ValueError("must not be zero")
    return np.asarray(vector / largest / np.linalg.norm(vector / largest))


def _by_quat(values: FloatArray, _: Compiler) -> Rotation:
    """Return the rotation of a quaternion, w x y z, whose components are `values`.

    The compiler's settings are ignored.
    """
    return Rotation.from_quat(_unit(values), scalar_first=True)


def _by_axis_angle(values: FloatArray, compiler: Compiler) -> Rotation:
    """Return the rotation about an axis, the first three of `values`, by an angle, the fourth.

    The angle is in degrees if `compiler.degrees` is true, else in rad.
    """
    turn = np.fmod(values[3], 360.0 if compiler.degrees else 2 * np.pi)
    return Rotation.from_rotvec(_unit(values[:3]) * turn, degrees=compiler.degrees)


def _by_euler(values: FloatArray, compiler: Compiler) -> Rotation:
    """Return the rotation by three Euler angles, `values`, about the axes of `Compiler.eulerseq`.

    The angles are in degrees if `compiler.degrees` is true, else in rad. A small letter is an axis
    of the frame as the earlier rotations have turned it, a capital letter an axis of the parent
    frame.
    """
    total = Rotation.identity()
    for letter, angle in zip(compiler.eulerseq, values, strict=True):
        one = Rotation.from_euler(letter.lower(), angle, degrees=compiler.degrees)
        total = total * one if letter.islower() else one * total
    return total


def _by_xy(values: FloatArray, _: Compiler) -> Rotation:
    """Return the rotation that takes x to the first of two vectors, and y into their plane.

    The angle between y and the second vector is less than 90°. `values` has the six components of
    the vectors; the compiler's settings are ignored.
    """
    x, y = _unit(values[:3]), _unit(values[3:])
    across = y - (y @ x) * x
    if np.linalg.norm(across) < LEAST_ANGLE:
        raise ValueError("must be two axes that are not parallel")
    y = across / np.linalg.norm(across)
    return Rotation.from_matrix(np.column_stack([x, y, np.cross(x, y)]))


def _by_z(values: FloatArray, _: Compiler) -> Rotation:
    """Return the smallest rotation that takes z to a vector; about x if the vector is along −z.

    `values` has the vector's components; the compiler's settings are ignored.
    """
    x, y, z = _unit(values)
    sine = np.hypot(x, y)
    axis = np.array([-y / sine, x / sine, 0.0]) if sine else np.array([1.0, 0.0, 0.0])
    return Rotation.from_rotvec(axis * np.arctan2(sine, z))


#: The attributes that state a rotation, each with how many numbers it has and the function that
#: converts these to the rotation.
WAYS: dict[str, tuple[int, Callable[[FloatArray, Compiler], Rotation]]] = {
    "quat": (4, _by_quat),
    "axisangle": (4, _by_axis_angle),
    "euler": (3, _by_euler),
    "xyaxes": (6, _by_xy),
    "zaxis": (3, _by_z),
}
