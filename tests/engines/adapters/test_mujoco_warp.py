"""What is MuJoCo Warp's alone: first steps, restarts; skipped if not installed.

Faults are planted in its models in `test_optional_rotors`.
"""

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from spincheck.engines.checks.read_back import start_state
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.suite.contract_scenes import SCENES, from_elsewhere

pytestmark = pytest.mark.slow

HELD = ("free-tilted-plate", "free-torque-world", "everything", "pivot-rotors", "table-rotors")


@each_case(
    ("method", "name"),
    [(method, name) for method in ("RK4", "implicitfast", "discrete") for name in HELD],
)
def test_its_first_steps_are_those_of_the_equations_of_motion(method: str, name: str) -> None:
    warp = installed("mujoco-warp")
    assert physics_in_words(warp, SCENES[name], warp.method(method)) == ""


@each_case("name", ["everything", "free-rotors"])
def test_a_restart_is_the_scene_opened_there(name: str) -> None:
    warp = installed("mujoco-warp")
    here, one = SCENES[name], warp.method("RK4")
    elsewhere = from_elsewhere(here)
    with warp.open(here, one, 2e-3) as session, warp.open(elsewhere, one, 1e-3) as there:
        session.advance(5)
        session.restart(start_state(elsewhere), 1e-3)
        for each in (session, there):
            each.advance(5)
        for first, second in zip(
            session.read_state().columns, there.read_state().columns, strict=True
        ):
            assert np.allclose(first, second, rtol=64 * warp.ulp, atol=64 * warp.ulp), name
