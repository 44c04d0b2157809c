"""Reads a user's URDF or MJCF with MuJoCo's compiler."""

import tempfile
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import mujoco
from spincheck.engine import BodyReading, EngineError

from ...users_models import (
    Advice,
    Configuration,
    ModelFile,
    ModelReader,
    Shape,
    mesh_bytes,
    unnamed,
    with_meshes,
)
from .coordinates import WORLD, one_body

#: File endings of the meshes that MuJoCo reads.
MESHES = frozenset((".obj", ".stl", ".msh"))
IMPOSSIBLE = Advice("correct the tensors that no body has", concerns="impossible")
FUSED = Advice(
    "keep links from being fused",
    '<mujoco><compiler fusestatic="false"/></mujoco>',
    is_mended=True,
)


@final
class MuJoCoModelReader(ModelReader):
    """MuJoCo's compiler with its default settings, except that no bodies are fused.

    Meshes are read only for links whose inertia comes from them; they do not affect a stated
    inertia.
    """

    name = "mujoco"
    formats = frozenset({"urdf", "mjcf"})
    configurations = (
        Configuration("as-is", "compiled with the file's own settings", advice={"sum": FUSED}),
        Configuration("unfused", "shapes stripped off a URDF, fusestatic = false"),
    )
    refusals = MappingProxyType(
        {
            "A + B >= C": IMPOSSIBLE,
            "positive eigenvalues": IMPOSSIBLE,
            "mjMINVAL": Advice(
                "give links that move a mass and a tensor; this option gives them small ones",
                '<mujoco><compiler boundmass="1e-6" boundinertia="1e-9"/></mujoco>',
                concerns="massless",
            ),
        }
    )

    @property
    def version(self) -> str:
        """Version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Return the bodies of the compiled file, by name."""
        try:
            # In a folder of its own, because MuJoCo writes a log of its warnings into the current
            # folder.
            with tempfile.TemporaryDirectory() as folder, chdir(folder):
                compiled = _compiled(model, unfused=configuration == "unfused")
        except (ValueError, mujoco.FatalError) as error:
            words = "; ".join(str(error).removeprefix("Error: ").split("\n"))
            raise EngineError(f"MuJoCo refuses the file: {words}") from None
        return {
            compiled.body(body).name: one_body(compiled, body)
            for body in range(WORLD + 1, compiled.nbody)
        }


def _compiled(model: ModelFile, *, unfused: bool) -> Any:
    opened = _urdf(model) if model.format == "urdf" else spec_of_mjcf(model)
    with opened as spec:
        name_bodies(spec)
        if unfused:
            spec.compiler.fusestatic = False
            if model.format == "urdf":
                _strip(spec)
        return spec.compile()


@contextmanager
def _urdf(model: ModelFile) -> Iterator[Any]:
    """Yield the model of a URDF with only the meshes that an inertia comes from, renamed.

    The new names have no folders, since MuJoCo drops folders from names.
    """
    stateless = {s.span for link in model.links if link.stated is None for s in link.shapes}

    def usable(shape: Shape) -> bool:
        return shape.span in stateless and Path(shape.mesh or "").suffix.lower() in MESHES

    data, meshes = with_meshes(model, usable)
    yield mujoco.MjSpec.from_string(data.decode(errors="replace"), assets=meshes)


@contextmanager
def spec_of_mjcf(model: ModelFile) -> Iterator[Any]:
    """Yield the model of an MJCF file without visual parts and meshes that no inertia comes from.

    It is read from the checked text, in a folder that holds all that it may read; compile it inside
    the block.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for name, file in model.files.items():
            data = file.encode() if isinstance(file, str) else mesh_bytes(model, str(file))
            if data is not None:
                Path(folder, name).write_bytes(data)
        text = Path(folder, "model.xml")
        text.write_text(model.checked, encoding="utf-8")
        spec = mujoco.MjSpec.from_file(str(text))
        _strip_drawn(model, spec)
        yield spec


def _strip_drawn(model: ModelFile, spec: Any) -> None:
    explicit = spec.compiler.inertiafromgeom != mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for geom in list(spec.geoms):
        needless = explicit and geom.parent.explicitinertial
        if geom.meshname and (needless or not _is_there(model, spec.mesh(geom.meshname))):
            spec.delete(geom)
    for drawn in (*spec.geoms, *spec.sites, *spec.tendons, *spec.flexes):
        drawn.material = ""
    used = {geom.meshname for geom in spec.geoms}
    unused = [mesh for mesh in spec.meshes if mesh.name not in used]
    for part in (*spec.skins, *unused, *spec.materials, *spec.textures):
        spec.delete(part)


def _is_there(model: ModelFile, mesh: Any) -> bool:
    """Whether a mesh names no file, or one inside the model's folders."""
    return mesh is not None and (not mesh.file or mesh.file in model.files)


def name_bodies(spec: Any) -> None:
    """Name bodies that have no name by their order, as spincheck's own reader of the file does."""
    nameless = [body for body in spec.bodies if not body.name]
    for number, body in enumerate(nameless, 1):
        body.name = unnamed(number)


def _strip(spec: Any) -> None:
    """Remove shapes and joints: MuJoCo accepts a body without inertia only if it cannot move."""
    for part in (*spec.geoms, *spec.equalities, *spec.joints):
        spec.delete(part)
