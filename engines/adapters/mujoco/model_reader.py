"""Reads a user's URDF or MJCF with MuJoCo's compiler."""

import contextlib
import tempfile
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import mujoco
from spincheck.engine import BodyReading, EngineError

from ....scenarios.users_models import ModelFile, Shape, unnamed
from ...users_models import Advice, Configuration, ModelReader, RefusalAdvice, with_meshes
from .coordinates import WORLD, one_body

#: Endings of meshes that MuJoCo reads.
MESHES = frozenset((".obj", ".stl", ".msh"))


@final
class MuJoCoModelReader(ModelReader):
    """MuJoCo's compiler, as it is and with nothing fused.

    Meshes are read only for links whose inertia comes from them; they do not affect a stated one.
    """

    name = "mujoco"
    formats = frozenset({"urdf", "mjcf"})
    configurations = (
        Configuration("as-is", "compiled with the file's own settings"),
        Configuration("unfused", "shapes stripped off a URDF, fusestatic = false"),
    )
    advice = MappingProxyType(
        {
            "sum": Advice(
                "keep links from being fused",
                '<mujoco><compiler fusestatic="false"/></mujoco>',
                is_mended=True,
            )
        }
    )
    refusals = (
        RefusalAdvice(
            ("A + B >= C", "positive eigenvalues"),
            "impossible",
            Advice("correct the tensors that no body has"),
        ),
        RefusalAdvice(
            ("mjMINVAL",),
            "massless",
            Advice(
                "give links that move a mass and a tensor; this option gives them small ones",
                '<mujoco><compiler boundmass="1e-6" boundinertia="1e-9"/></mujoco>',
            ),
        ),
    )

    @property
    def version(self) -> str:
        """Version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Compile it."""
        try:
            # MuJoCo writes a log of its warnings into the current folder.
            with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
                compiled = _compiled(model, unfused=configuration == "unfused")
        except (ValueError, mujoco.FatalError) as error:
            words = "; ".join(str(error).removeprefix("Error: ").split("\n"))
            raise EngineError(f"MuJoCo refuses the file: {words}") from None
        return {
            compiled.body(body).name: one_body(compiled, body)
            for body in range(WORLD + 1, compiled.nbody)
        }


def _compiled(model: ModelFile, *, unfused: bool) -> Any:
    spec = _urdf(model) if model.format == "urdf" else spec_of_mjcf(model)
    name_bodies(spec)
    if unfused:
        spec.compiler.fusestatic = False
        if model.format == "urdf":
            _strip(spec)
    return spec.compile()


def _urdf(model: ModelFile) -> Any:
    """The file with the meshes that it takes an inertia from, under names that lose no folder."""
    stateless = {s.span for link in model.links if link.stated is None for s in link.shapes}

    def usable(shape: Shape) -> bool:
        return shape.span in stateless and Path(shape.mesh or "").suffix.lower() in MESHES

    data, meshes = with_meshes(model, usable)
    assets = {name: path.read_bytes() for name, path in meshes.items()}
    return mujoco.MjSpec.from_string(data.decode(errors="replace"), assets=assets)


def spec_of_mjcf(model: ModelFile) -> Any:
    """The file without visual parts, and without meshes that no inertia comes from."""
    spec = mujoco.MjSpec.from_file(str(model.folders.own / model.path.name))
    explicit = spec.compiler.inertiafromgeom != mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for geom in list(spec.geoms):
        needless = explicit and geom.parent.explicitinertial
        if geom.meshname and (needless or not _is_there(model, spec, geom)):
            spec.delete(geom)
    for drawn in (*spec.geoms, *spec.sites, *spec.tendons, *spec.flexes):
        drawn.material = ""
    used = {geom.meshname for geom in spec.geoms}
    unused = [mesh for mesh in spec.meshes if mesh.name not in used]
    for part in (*spec.skins, *unused, *spec.materials, *spec.textures):
        spec.delete(part)
    return spec


def _is_there(model: ModelFile, spec: Any, geom: Any) -> bool:
    """Whether a geom has no mesh file, or one inside the model's folders."""
    mesh = spec.mesh(geom.meshname)
    if mesh is None or not mesh.file:
        return mesh is not None
    return model.folders.find(str(Path(spec.compiler.meshdir, mesh.file))) is not None


def name_bodies(spec: Any) -> None:
    """Give names to bodies without one, by their order, as the file's reader does."""
    nameless = [body for body in spec.bodies if not body.name]
    for number, body in enumerate(nameless, 1):
        body.name = unnamed(number)


def _strip(spec: Any) -> None:
    """Remove shapes and joints: MuJoCo accepts a body without inertia if it cannot move."""
    for part in (*spec.geoms, *spec.equalities, *spec.joints):
        spec.delete(part)
