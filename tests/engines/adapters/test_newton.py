"""What is Newton's and MuJoCo Warp's alone; each skipped if not installed.

Newton's solvers, recorded steps and defaults; first steps and restarts of both. Faults are planted
in their models in `test_rotors_of_engines`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from spincheck.engines import Engine
from spincheck.engines.checks.read_back import start_state
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import SCENES, from_elsewhere, scene

pytestmark = pytest.mark.slow

TIMESTEP = 2.0**-10
STEPS = np.arange(3)
#: What is held and what acts: on free bodies, on pivots, with rotors.
FREE = ("free-tilted-plate", "free-falling")
HELD = (*FREE, "heavy-top", "everything")
HELD_BY_WARP = ("free-torque-world", "everything", "pivot-rotors", "table-rotors")
#: By engine and method: the scenes of which all steps are those of the equations of motion.
FAITHFUL = {
    **dict.fromkeys(
        [("newton", method) for method in ("mujoco-rk4", "featherstone", "steel")],
        (*HELD, "free-rotors"),
    ),
    ("newton", "mujoco-euler"): HELD,
    ("newton", "semi-implicit"): FREE,
    **dict.fromkeys(
        [("mujoco-warp", method) for method in ("RK4", "implicitfast", "discrete")],
        ("free-tilted-plate", *HELD_BY_WARP),
    ),
}
EVERYTHING = SCENES["everything"]


@pytest.fixture
def newton() -> Engine:
    return installed("newton")


def opened(newton: Engine, method: str, name: str) -> Any:
    return newton.open(SCENES[name], newton.method(method), TIMESTEP)


@each_case(
    ("engine", "method", "name"),
    [(*who, name) for who, names in FAITHFUL.items() for name in names],
)
def test_its_first_steps_are_those_of_the_equations_of_motion(
    engine: str, method: str, name: str
) -> None:
    one = installed(engine)
    assert physics_in_words(one, SCENES[name], one.method(method)) == ""


@each_case("name", ["heavy-top", "everything"])
def test_springs_in_place_of_a_pivot_blow_up_at_long_timesteps(newton: Engine, name: str) -> None:
    """SemiImplicit holds a pivot by springs. Its steps are said to overflow, not to be right."""
    words = physics_in_words(newton, SCENES[name], newton.method("semi-implicit"))
    assert words.endswith("ends in numbers whose squares overflow")


@each_case(
    ("method", "damping"),
    [("default", 0.0), ("steel-default", 0.05), ("semi-implicit-default", 0.05), ("xpbd", 0.0)],
)
def test_as_shipped_it_damps_where_its_sources_say_so(method: str, damping: float) -> None:
    newton = installed("newton")
    run = newton.run(SCENES["free"], newton.method(method), TIMESTEP, STEPS)
    assert ("damping" in run.reason) == (damping > 0), method
    with opened(newton, method, "free") as session:
        assert session._damping() == pytest.approx(damping, rel=newton.ulp)
    held = newton.run(SCENES["heavy-top"], newton.method("steel-default"), TIMESTEP, STEPS)
    assert held.reason == "", "Steel damps free bodies alone"


def test_featherstones_damping_is_used_nowhere(newton: Engine) -> None:
    """So that it has no method as shipped; another solver's changes its motion."""
    for method, is_used in (("featherstone", False), ("semi-implicit", True)):
        ends = []
        for damping in (0.0, 5.0):
            with opened(newton, method, "free") as session:
                session.world.solver.angular_damping = damping
                session.world.graphs.clear()
                session.restart(start_state(SCENES["free"]))
                session.advance(9)
                ends.append(session.read_state().omega_body)
        assert np.array_equal(*ends) != is_used, method


@each_case("method", ["mujoco-rk4", "featherstone", "steel", "semi-implicit", "xpbd"])
def test_recorded_launches_are_the_step_and_a_restart_the_scene_opened_there(method: str) -> None:
    """To the last bit."""
    newton = installed("newton")
    with opened(newton, method, "everything") as session:
        session.advance(20)
        recorded = session.world.motion()
        session.restart(start_state(EVERYTHING))
        for _ in range(20):
            session.world.step(TIMESTEP)
        assert np.array_equal(recorded, session.world.motion()), method
    restarted, there = restarted_and_opened(newton, method, EVERYTHING)
    assert all(np.array_equal(*pair) for pair in zip(restarted, there, strict=True)), method


def restarted_and_opened(engine: Engine, method: str, scene: Scenario) -> list[Sequence[Any]]:
    """What is read after some steps of a session that was restarted elsewhere, and opened there."""
    one, elsewhere = engine.method(method), from_elsewhere(scene)
    with engine.open(scene, one, 2e-3) as session, engine.open(elsewhere, one, 1e-3) as there:
        session.advance(5)
        session.restart(start_state(elsewhere), 1e-3)
        for each in (session, there):
            each.advance(5)
        return [session.read_state().columns, there.read_state().columns]


@each_case("name", ["everything", "free-rotors"])
def test_a_restart_of_mujoco_warp_is_the_scene_opened_there(name: str) -> None:
    warp = installed("mujoco-warp")
    restarted, there = restarted_and_opened(warp, "RK4", SCENES[name])
    for pair in zip(restarted, there, strict=True):
        assert np.allclose(*pair, rtol=64 * warp.ulp, atol=64 * warp.ulp), name


SPUN = scene(
    "spun",
    body="\nmass = 1.0\ninertia = [0.002, 0.003, 0.004]\n",
    start="\nquaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\nomega_body = [0.1, 6.0, 0.2]\n",
)
GROWN_STEPS = 2000


def growth_a_step(newton: Engine, method: str, timestep: float) -> tuple[float, float]:
    """Growth of |L| a step, relative, and what two turns of ω by each attitude stretch it by.

    `wp.quat_rotate` stretches along the axis by 2|q|² - 1, across it by less.
    """
    inertia, stretch = np.diag(SPUN.body.inertia_com), 0.0
    with newton.open(SPUN, newton.method(method), timestep) as session:
        at_first = np.linalg.norm(inertia * session.read_state().omega_body)
        for _ in range(GROWN_STEPS):
            session.advance(1)
            motion = session.snapshot()
            w, xyz, omega = motion[0] ** 2, motion[1:4], motion[4:7]
            x = xyz @ xyz
            share = (xyz @ omega) ** 2 / (x * (omega @ omega))
            across = np.hypot(2 * w - 1, 2 * np.sqrt(w * x)) - 1
            stretch += 2 * (share * 2 * (w + x - 1) + (1 - share) * across)
        grown = np.linalg.norm(inertia * session.read_state().omega_body) / at_first - 1
    return grown / GROWN_STEPS, stretch / GROWN_STEPS


def test_turning_omega_to_body_axes_and_back_makes_it_grow_with_each_step(newton: Engine) -> None:
    """But not Featherstone's, which turns nothing. At 1 ms other methods' own errors hide it.

    SemiImplicit and XPBD turn it in `integrate_rigid_body`, for MuJoCo Newton's own kernels do.
    """
    short = [(method, 2.5e-4) for method in ("mujoco-rk4", "semi-implicit", "xpbd")]
    for method, timestep in [("mujoco-rk4", 1e-3), *short]:
        grown, stretch = growth_a_step(newton, method, timestep)
        assert grown > newton.ulp
        assert grown == pytest.approx(stretch, rel=0.25)
    grown, _ = growth_a_step(newton, "featherstone", 2.5e-4)
    assert abs(grown) < newton.ulp / 4


#: A torque of 100 N m, and drag that leaves a millionth of it.
NEARLY_BALANCED = scene(
    "nearly-balanced",
    body="\nmass = 1.0\ninertia = [0.2, 0.3, 0.4]\n",
    start="\nquaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\nomega_body = [0.0, 0.0, 99.9999]\n",
    effects="\n[effects.drag]\nrotational = 1.0\n[effects.torque]\nbody = [0.0, 0.0, 100.0]\n",
)


def test_drag_that_nearly_balances_a_torque_is_not_called_another_torque(newton: Engine) -> None:
    """Each is rounded by its own size, which is more than what is left of both."""
    with newton.open(NEARLY_BALANCED, newton.method("featherstone"), TIMESTEP) as session:
        assert session.active() == {"drag", "torque_body"}
        # Teeth: a part in ten thousand of the torque more is another.
        session.scene["torque_body"] = [0.0, 0.0, 100.01]
        session.world.scene = session.scene | {"torque_body": [0.0, 0.0, 100.0]}
        assert any("a torque of" in name for name in session.active())
