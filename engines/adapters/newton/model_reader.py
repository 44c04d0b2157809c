"""Reads a user's URDF, MJCF or USD with Newton's importers."""

import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import numpy as np
from spincheck.engine import BodyReading, EngineError

from ...users_models import Advice, Configuration, ModelFile, ModelReader, laid_out
from ...warp_kernels import kernels_kept

COLLAPSED = "collapsed"
#: Advice with which each link keeps its own tensor, so that the whole body's is right, too.
KEPT = Advice("import it without collapse_fixed_joints: Newton then has a fixed joint for each")


@final
class NewtonModelReader(ModelReader):
    """A reader of model files by `add_urdf`, `add_mjcf` and `add_usd` of Newton's `ModelBuilder`.

    Meshes of a URDF are read only for links that state no inertia; visual shapes of an MJCF are
    left out.
    """

    name = "newton"
    is_optional = True
    formats = frozenset({"urdf", "mjcf", "usd"})
    configurations = (
        Configuration("as-is", "add_urdf, add_mjcf or add_usd, with their defaults"),
        Configuration(COLLAPSED, "collapse_fixed_joints = True", advice={"sum": KEPT}),
    )

    @property
    def version(self) -> str:
        """The version of the installed package."""
        return version("newton")

    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Return the bodies of Newton's finalized model of a file, by the names of their links.

        `configuration` is the name of one of the reader's `configurations`.
        """
        with kernels_kept(), tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            import newton

            builder, path = newton.ModelBuilder(), laid_out(model, Path(folder))
            collapsed = configuration == COLLAPSED
            try:
                if model.format == "mjcf":
                    builder.add_mjcf(path, collapse_fixed_joints=collapsed, parse_visuals=False)
                else:
                    add = builder.add_urdf if model.format == "urdf" else builder.add_usd
                    add(path, collapse_fixed_joints=collapsed)
                built = builder.finalize(device="cpu")
            # An importer may raise anything; the first line of the message says what is wrong.
            except Exception as error:
                words = str(error).partition("\n")[0] or type(error).__name__
                raise EngineError(f"Newton refuses the file: {words}") from None
        return _bodies(built, model)


def _bodies(built: Any, model: ModelFile) -> dict[str, BodyReading]:
    """Return the bodies of a finalized model, by the names of their links.

    Newton labels a body with a path that ends with the link's name, in which "-" may have become
    "_". Bodies whose label does not end with a link's name are left out.
    """
    names = {link.name.replace("-", "_"): link.name for link in model.links}
    names |= {link.name: link.name for link in model.links}
    arrays = (built.body_mass, built.body_com, built.body_inertia)
    numbers = zip(*(array.numpy().astype(float) for array in arrays), strict=True)
    bodies = {}
    for label, (mass, com, inertia) in zip(built.body_label, numbers, strict=True):
        ends = [name for name in names if label == name or label.endswith(f"/{name}")]
        if ends:
            bodies[names[max(ends, key=len)]] = BodyReading(float(mass), com, np.array(inertia))
    return bodies
