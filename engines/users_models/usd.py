"""Reads the rigid bodies of a USD file in text form: UsdPhysics' MassAPI and joints.

OpenUSD parses the file, which may name no other files. Units, scales and axes are applied here.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray, printable
from .model_file import Link, Pose, Stated
from .xml_tree import ModelFileError, shown

#: File endings of USD, and the first bytes of a file in text form, the only form that is read.
ENDINGS = frozenset((".usd", ".usda", ".usdc", ".usdz"))
TEXT = b"#usda"


def usd_links(path: Path, data: bytes) -> tuple[tuple[Link, ...], tuple[str, ...]]:
    """Return a file's rigid bodies, named by their paths, and sentences on what was not read.

    The bodies are in the file's order. `data` has the file's bytes, and `path` is for messages.

    Raises
    ------
    ModelFileError
        If OpenUSD is not installed or cannot read the file, if it is binary or names other files,
        or if its joints form no tree.
    """
    file = printable(str(path))
    if not data.startswith(TEXT):
        raise ModelFileError(
            f"{file}: USD is read as text, in one file: usdcat --flatten FILE -o robot.usda"
        )
    try:
        usd = {name: import_module(f"pxr.{name}") for name in ("Sdf", "Usd", "UsdGeom", "Gf")}
        physics: Any = import_module("pxr.UsdPhysics")
    except ImportError:
        raise ModelFileError(
            f"{file}: OpenUSD, which reads it, is not installed; pip install 'newton[importers]'"
        ) from None
    try:
        layer = usd["Sdf"].Layer.CreateAnonymous(".usda")
        layer.ImportFromString(data.decode(errors="replace"))
    # OpenUSD has an exception of its own, whose text is many lines long.
    except Exception as error:
        (*_, words) = str(error).strip().splitlines() or [type(error).__name__]
        raise ModelFileError(f"{file}: no USD: {words.strip()}") from None
    if others := layer.GetCompositionAssetDependencies():
        raise ModelFileError(
            f"{file}: it is made of other files too, such as {shown(others[0])}; flatten it first: "
            "usdcat --flatten FILE -o robot.usda"
        )
    stage = usd["Usd"].Stage.Open(layer)
    metre = float(usd["UsdGeom"].GetStageMetersPerUnit(stage))
    kilogram = float(physics.GetStageKilogramsPerUnit(stage))
    bodies = [one for one in stage.Traverse() if one.HasAPI(physics.RigidBodyAPI)]
    if not bodies:
        raise ModelFileError(
            f"{file}: no prim has PhysicsRigidBodyAPI: there is nothing to inspect"
        )
    joints = _joints(stage, physics, metre)
    links, notes = [], []
    for body in bodies:
        name, mass = str(body.GetPath()), physics.MassAPI(body)
        parent, pose, moves = joints.get(name, ("", Pose(), True))
        stated = None
        if body.HasAttribute("newton:inertia"):
            notes.append(f"{name}: Newton's own attribute newton:inertia is not read")
        elif body.HasAPI(physics.MassAPI):
            world = usd["UsdGeom"].Xformable(body).ComputeLocalToWorldTransform(0.0)
            scale = np.array(usd["Gf"].Transform(world).GetScale())
            stated = _stated(mass, metre, kilogram, scale)
        links.append(
            Link(name, f"{file}: {name}", stated, parent, pose, moves, by_shapes=stated is None)
        )
    _check_tree(file, links)
    return tuple(links), tuple(notes)


def _stated(mass: Any, metre: float, kilogram: float, scale: FloatArray) -> Stated | None:
    """Return mass, com and tensor that a MassAPI states, in SI units; None if it lacks any of them.

    Engines compute from shapes what is lacking.

    Parameters
    ----------
    mass : the MassAPI of a prim
    metre : the file's unit of length, m
    kilogram : the file's unit of mass, kg
    scale : factors by which the prim's axes are scaled, (3,)
    """
    value = float(mass.GetMassAttr().Get() or 0.0)
    moments = np.array(mass.GetDiagonalInertiaAttr().Get() or (0.0,) * 3, dtype=float)
    com = mass.GetCenterOfMassAttr()
    if not (value and moments.any() and com.HasAuthoredValue()):
        return None
    axes = mass.GetPrincipalAxesAttr().Get()
    q_wxyz = np.array([axes.GetReal(), *axes.GetImaginary()]) if axes else np.zeros(4)
    R = Rotation.from_quat(q_wxyz, scalar_first=True).as_matrix() if q_wxyz.any() else np.eye(3)
    unturned = np.diag(moments) * kilogram * metre**2
    inertia = R @ unturned @ R.T
    # The com is stated in the prim's own space, which is stretched by the prim's scale.
    place = np.array(com.Get(), dtype=float) * scale * metre
    return Stated(value * kilogram, place, (inertia + inertia.T) / 2, unturned=unturned)


def _joints(stage: Any, physics: Any, metre: float) -> dict[str, tuple[str, Pose, bool]]:
    """Return the joints of a stage, by the path of the child body.

    A joint is given by three values: the path of the parent body, the pose of the child in the
    parent's frame if all joint coordinates are zero, and whether the child can move. Joints to the
    world are left out. If a child has several joints, the first is returned.

    Parameters
    ----------
    physics : the module `pxr.UsdPhysics`
    metre : the file's unit of length, m
    """
    joints: dict[str, tuple[str, Pose, bool]] = {}
    for prim in stage.Traverse():
        if not prim.IsA(physics.Joint):
            continue
        joint = physics.Joint(prim)
        ends = [rel.GetTargets() for rel in (joint.GetBody0Rel(), joint.GetBody1Rel())]
        if not (ends[0] and ends[1]):
            continue
        outer = _frame(joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr(), metre)
        inner = _frame(joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr(), metre)
        back = Pose(-inner.R.T @ inner.position, inner.R.T)
        moves = not prim.IsA(physics.FixedJoint)
        joints.setdefault(str(ends[1][0]), (str(ends[0][0]), outer.then(back), moves))
    return joints


def _frame(place: Any, turn: Any, metre: float) -> Pose:
    """Return the pose of a joint's frame in a body.

    Parameters
    ----------
    place, turn : the attributes of the prim that state position and rotation of the frame
    metre : the file's unit of length, m
    """
    q = turn.Get()
    R = Rotation.from_quat([q.GetReal(), *q.GetImaginary()], scalar_first=True).as_matrix()
    return Pose(np.array(place.Get(), dtype=float) * metre, R)


def _check_tree(file: str, links: list[Link]) -> None:
    """Raise `ModelFileError` if parents lead from a body back to itself.

    `file` is the file's name, for the message; `links` are its bodies.
    """
    parents = {link.name: link.parent for link in links}
    for link in links:
        seen, at = {link.name}, link.parent
        while at:
            if at in seen:
                raise ModelFileError(f"{file}: joints form a ring at {shown(at)}")
            seen.add(at)
            at = parents.get(at, "")
