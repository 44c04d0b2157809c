"""Reads a user's URDF or MJCF with MuJoCo's compiler."""

import tempfile
from contextlib import chdir
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import mujoco
from spincheck.engine import BodyReading, EngineError

from ...users_models import Advice, Configuration, ModelFile, ModelReader, laid_out
from .coordinates import WORLD, one_body

#: File endings of the meshes that MuJoCo reads.
MESHES = frozenset((".obj", ".stl", ".msh"))
IMPOSSIBLE = Advice("correct the masses and tensors that no body has", concerns="impossible")
MASSLESS = Advice(
    "give links that move a mass and a tensor; this option gives them small ones",
    '<mujoco><compiler boundmass="1e-6" boundinertia="1e-9"/></mujoco>',
    concerns="massless",
)
#: MuJoCo's mjEPS, the least eigenvalue of a full tensor; of other numbers, mjMINVAL is the least.
LEAST = 1e-14
SMALL = Advice(
    f"state larger masses and tensors: MuJoCo takes none below {LEAST:g} kg or kg m², though a "
    "body may have them",
    concerns="small",
    least=LEAST,
)
FUSED = Advice(
    "keep links from being fused",
    '<mujoco><compiler fusestatic="false"/></mujoco>',
    is_mended=True,
)


@final
class MuJoCoModelReader(ModelReader):
    """A reader of model files by MuJoCo's compiler.

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
            "A + B >= C": (IMPOSSIBLE,),
            "positive eigenvalues": (IMPOSSIBLE, SMALL),
            "mjMINVAL": (MASSLESS, IMPOSSIBLE, SMALL),
        }
    )

    @property
    def version(self) -> str:
        """The version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Compile a file; return its bodies, by the names of their links.

        A body is returned without the children that hang on it. `configuration` is the name of one
        of the reader's `configurations`.
        """
        try:
            # A temporary current folder, because MuJoCo writes a log of its warnings there.
            with tempfile.TemporaryDirectory() as folder, chdir(folder):
                compiled = _compiled(model, Path(folder), unfused=configuration == "unfused")
        except (ValueError, mujoco.FatalError) as error:
            words = "; ".join(str(error).removeprefix("Error: ").split("\n"))
            raise EngineError(f"MuJoCo refuses the file: {words}") from None
        return {
            compiled.body(body).name: one_body(compiled, body)
            for body in range(WORLD + 1, compiled.nbody)
        }


def _compiled(model: ModelFile, folder: Path, *, unfused: bool) -> Any:
    """Return the compiled model of a file.

    Parameters
    ----------
    folder : an existing folder, into which the model's files are written
    unfused : whether the model must have a body for each link; the model of a URDF then has no
        shapes, joints or equality constraints
    """
    spec = spec_of(model, folder)
    if unfused:
        spec.compiler.fusestatic = False
    if unfused and model.format == "urdf":
        # MuJoCo accepts a body without inertia only if it cannot move.
        for part in (*spec.geoms, *spec.equalities, *spec.joints):
            spec.delete(part)
    return spec.compile()


def spec_of(model: ModelFile, folder: Path) -> Any:
    """Return the editable model of a file, without visual parts of an MJCF.

    Only meshes from which an inertia is computed are kept. The model's files are written into
    `folder`, which must exist until the model is compiled.
    """
    spec = mujoco.MjSpec.from_file(laid_out(model, folder, MESHES))
    if model.format == "mjcf":
        _strip_drawn(model, spec)
    return spec


def _strip_drawn(model: ModelFile, spec: Any) -> None:
    """Remove from an editable model visual parts, and meshes from which no inertia is computed."""
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
    """Whether a mesh can be compiled: it names no file, or one of the model's files."""
    return mesh is not None and (not mesh.file or mesh.file in model.files)
