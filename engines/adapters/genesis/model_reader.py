"""Reads a user's URDF or MJCF with Genesis's importers."""

import tempfile
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import numpy as np
from spincheck.engine import BodyReading, EngineError

from ...users_models import Advice, Configuration, ModelFile, ModelReader, laid_out
from ...world_parts import matrix
from .caches import kernels_kept

UNMERGED = "unmerged"
#: Mass, kg, that Genesis gives to links without mass: the machine epsilon of single precision.
PLACEHOLDER = float(np.finfo(np.float32).eps)
IMPOSSIBLE = Advice("correct the masses and tensors that no body has", concerns="impossible")


@final
class GenesisModelReader(ModelReader):
    """A reader of model files by `gs.morphs.URDF` and `gs.morphs.MJCF` of Genesis.

    Meshes are read only for links whose inertia comes from them.
    """

    name = "genesis"
    is_optional = True
    formats = frozenset({"urdf", "mjcf"})
    configurations = (
        Configuration("as-is", "gs.morphs.URDF or MJCF, their axes kept (align = False)"),
        Configuration(UNMERGED, "the same with merge_fixed_links = False, of a URDF"),
    )
    refusals = MappingProxyType({"A+B>=C": (IMPOSSIBLE,), "not positive definite": (IMPOSSIBLE,)})

    @property
    def version(self) -> str:
        """The version of the installed distribution."""
        return version("genesis-world")

    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Return the bodies of a Genesis scene that is built from a file, by their links' names.

        `configuration` is the name of one of the reader's `configurations`.
        """
        with kernels_kept(), tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            gs: Any = import_module(f"{__package__}.world").gs
            path = laid_out(model, Path(folder))
            there = gs.Scene(show_viewer=False)
            try:
                if model.format == "urdf":
                    merged = configuration != UNMERGED
                    morph = gs.morphs.URDF(file=path, align=False, merge_fixed_links=merged)
                else:
                    morph = gs.morphs.MJCF(file=path, align=False)
                there.add_entity(morph)
                there.build()
                return _bodies(there.rigid_solver)
            # An importer may raise anything; the first line of the message says what is wrong.
            except Exception as error:
                words = str(error).partition("\n")[0].replace(f"{folder}/", "")
                words = words or type(error).__name__
                raise EngineError(f"Genesis refuses the file: {words}") from None
            finally:
                there.destroy()


def _bodies(solver: Any) -> dict[str, BodyReading]:
    """Return the bodies of a built scene, by the names of their links.

    A mass that Genesis has given to a link without mass (`PLACEHOLDER`) is returned as 0.
    """
    links = solver.dyn_info.links
    arrays = (getattr(links, f"inertial_{name}") for name in ("mass", "pos", "quat", "i"))
    rows = zip(*(array.to_numpy().astype(float) for array in arrays), strict=True)
    bodies = {}
    for link, (mass, com, q, tensor) in zip(solver.links, rows, strict=True):
        R = matrix(q / np.linalg.norm(q))
        total = float(mass) if mass > PLACEHOLDER else 0.0
        bodies[link.name] = BodyReading(total, com, R @ tensor @ R.T)
    return bodies
