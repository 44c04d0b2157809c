"""MuJoCo from the scene's URDF instead of MJCF: the same body, read by MuJoCo's URDF reader.

Only the reader differs from the MJCF adapter, so any difference between the two is due to MuJoCo's
URDF reader.
"""

from collections.abc import Collection
from copy import copy
from functools import lru_cache
from typing import Any, final

import mujoco
import numpy as np

from ....scenarios import Scenario
from ...engine import Engine, Method
from ...models.mjcf import start_coordinates, switched_off
from ...models.urdf import BODY_LINK, urdf
from .audit import disable
from .clock import CLOCK
from .engine import KEPT, MuJoCo
from .session import MuJoCoSession, check_not_too_small, compiled, left_out

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
        return _open(scenario, method, timestep, left_in=())

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:  # noqa: ARG002
        """The passes that are switched off, and the clock."""
        return left_out(scenario)

    def open_unpruned(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        left_in: Collection[str] | None = None,
    ) -> MuJoCoSession:
        """As `open`, with passes left on, to time what they cost."""
        kept = left_out(scenario) if left_in is None else left_in
        return _open(scenario, method, timestep, kept)


def _open(
    scenario: Scenario, method: Method, timestep: float, left_in: Collection[str]
) -> MuJoCoSession:
    check_not_too_small(scenario)
    model = copy(_model(scenario))
    model.opt.timestep = timestep
    model.opt.gravity = scenario.gravity_world
    model.opt.integrator = mujoco.mjtIntegrator.__members__[f"mjINT_{method.name}"]
    disable(model, (name for name in switched_off(scenario) if name not in left_in))
    return MuJoCoSession(scenario, model, *start_coordinates(scenario), CLOCK in left_in)


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
