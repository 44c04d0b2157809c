"""MuJoCo from the scene's URDF instead of MJCF: the same body, read by MuJoCo's URDF reader.

Only the reader differs from the MJCF adapter, so any difference between the two is due to MuJoCo's
URDF reader.
"""

from collections.abc import Collection
from functools import lru_cache
from typing import Any, final

import mujoco
import numpy as np

from ....scenarios import Scenario
from ...engine import Engine, Method
from ...models.urdf import BODY_LINK, urdf
from .engine import KEPT, MuJoCo, open_as_read
from .session import MuJoCoSession, compiled, left_out

#: The reader diagonalises the principal moments again, with errors of up to 12 ulp, and then
#: refuses every third flat body because it breaks the triangle inequality.
READER_ROUNDOFF = 64 * float(np.finfo(float).eps)


@final
class MuJoCoURDF(Engine):
    """MuJoCo's URDF reader."""

    name = "mujoco-urdf"
    # URDF cannot express it.
    stock_timestep = MuJoCo.stock_timestep
    # Faults of the reader show with any integrator, best with the most accurate one.
    methods = (
        Method(
            "RK4",
            4,
            4,
            "Runge-Kutta of fourth order, on the body as read from URDF",
            frozenset({"gravity", "pivot"}),
            reader=True,
        ),
    )

    @property
    def version(self) -> str:
        """Version of the library, which may differ from the package's."""
        return str(mujoco.mj_versionString())

    def open(self, scenario: Scenario, method: Method, timestep: float) -> MuJoCoSession:
        """Read the URDF, then set on the model what URDF cannot express."""
        return self.open_with(scenario, method, timestep, ())

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:  # noqa: ARG002
        """The passes that are switched off, and the clock."""
        return left_out(scenario)

    def open_with(
        self, scenario: Scenario, method: Method, timestep: float, left_in: Collection[str]
    ) -> MuJoCoSession:
        """As `open`, with some passes on."""
        return open_as_read(scenario, lambda: _model(scenario), method, timestep, left_in)


@lru_cache(maxsize=KEPT)
def _model(scenario: Scenario) -> Any:
    """The compiled body, as it was read."""
    text = urdf(scenario, READER_ROUNDOFF)
    return compiled(lambda: _spec(text, scenario.constraint.is_pivot).compile())


def _spec(text: str, has_pivot: bool) -> Any:
    """The URDF as an editable model (MjSpec); a free body gets a free joint, which URDF lacks."""
    spec = mujoco.MjSpec.from_string(text)
    if not has_pivot:
        # By default the reader fuses a single link with the world.
        spec.compiler.fusestatic = False
        spec.body(BODY_LINK).add_freejoint(align=False)
    return spec
