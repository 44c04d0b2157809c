"""The lines of docs/how-to/gradients.md for each engine give what the engine's adapter gives."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from library_scenes import library_scene
from spincheck.engine import in_chart, numbers_by_chart
from spincheck.reports.harness.gradients.jacobians import stepped_by_rate

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[4] / "docs/how-to/gradients.md"
TIMESTEP = 1e-3


def block_of(title: str) -> str:
    """The lines below the name of an engine."""
    after = PAGE.read_text(encoding="utf-8").partition(f"\n**{title}**")[2]
    return after.partition("```python\n")[2].partition("```")[0]


def of_mujoco(session: Any) -> dict[str, Any]:
    import mujoco

    return {"mujoco": mujoco, "model": session.model, "data": session.data}


def of_mjx(session: Any) -> dict[str, Any]:
    import jax
    from mujoco import mjx

    world = session._world
    return {"mjx": mjx, "jax": jax, "jnp": jax.numpy, "model": world.model, "data": world.data()}


def of_brax(session: Any) -> dict[str, Any]:
    import jax

    # As its users have it; MJX's adapter may have changed it in this process.
    jax.config.update("jax_enable_x64", False)
    world = session.world
    names = {"pipeline": world.pipeline, "jax": jax, "jnp": jax.numpy, "system": world.system}
    return names | {"q": world.state.q, "qd": world.state.qd}


def of_drake(session: Any) -> dict[str, Any]:
    import pydrake.all

    world = session.world
    joint = {"joint_index": world.joint.index()}
    own = {name: getattr(world, name) for name in ("plant", "context", "body")}
    return vars(pydrake.all) | own | joint


def of_newton(session: Any) -> dict[str, Any]:
    import newton
    import warp

    world = session.world
    builder = world.builder()
    world.add_scene(builder, world.scene)
    builder.color()
    motion = session.frame.motion(session.read_state())
    q, qd = (np.array(one, np.float32) for one in world.coordinates(world.scene, motion))
    return {"newton": newton, "wp": warp, "builder": builder, "q": q, "qd": qd}


def of_pin(session: Any) -> dict[str, Any]:
    import pinocchio

    names = ("model", "data", "q", "v")
    return {"pinocchio": pinocchio} | {name: getattr(session.world, name) for name in names}


#: By name on the page: the engine, method, scene, the reader's own names, and the derivative.
BLOCKS: dict[str, tuple[str, str, str, Callable[[Any], dict[str, Any]], str]] = {
    "MuJoCo": ("mujoco", "Euler", "fast-top", of_mujoco, "mjd_transitionFD, centred"),
    "MJX": ("mjx", "Euler", "fast-top", of_mjx, "jacfwd"),
    "Brax": ("brax", "generalized", "t-handle", of_brax, "jacfwd"),
    "Drake": ("drake", "discrete", "t-handle", of_drake, "AutoDiff of the discrete update"),
    "Newton": ("newton", "featherstone", "t-handle", of_newton, "Warp's tape"),
    "Pinocchio": ("pin", "RK4", "fast-top", of_pin, "computeABADerivatives"),
}


@pytest.mark.filterwarnings("ignore:Accessing `ncon` directly:DeprecationWarning")
@each_case("title", list(BLOCKS))
def test_the_lines_of_the_page_give_the_derivative(title: str) -> None:
    """All but rounding in the engine's numbers, which are of 24 bits in Brax and Newton."""
    name, method, scene, own_names, derivative = BLOCKS[title]
    engine, scenario = installed(name), library_scene(scene)
    session: Any
    with engine.open(scenario, engine.method(method), TIMESTEP) as session:
        names = {"np": np, "in_chart": in_chart, "numbers_by_chart": numbers_by_chart}
        names |= own_names(session) | {"timestep": TIMESTEP}
        exec(compile(block_of(title), str(PAGE), "exec"), names)
        if title == "Newton":
            motion = session.frame.motion(session.read_state())
            names["jacobian"] = session._tape._in_chart(motion, names["then"], names["rows"])
        found = np.asarray(names["jacobian"], dtype=float)
        wanted = session.derivatives()[derivative].compute()
        if len(wanted) == 3:
            wanted = stepped_by_rate(wanted, session.read_state().omega_body, TIMESTEP)
    rounding = np.sqrt(engine.ulp)
    assert np.abs(found - wanted).max() < rounding
    assert np.abs(wanted - np.eye(6)).max() > rounding
