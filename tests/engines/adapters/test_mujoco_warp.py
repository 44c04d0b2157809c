"""What is MuJoCo Warp's alone: what is read back, restarts; skipped if not installed."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from spincheck.engines.checks.read_back import start_state
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.suite.contract_scenes import SCENES, from_elsewhere

pytestmark = pytest.mark.slow

STEPS = np.arange(3)
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


def heavier(model: Any) -> None:
    model.body_mass.fill_(2.0)


def weightless(model: Any) -> None:
    model.opt.gravity.zero_()


def undriven(model: Any) -> None:
    model.dof_armature.zero_()


def damped(model: Any) -> None:
    model.dof_damping.fill_(1e-3)
    model.opt.disableflags = 0


FAULTS: dict[Callable[[Any], None], str] = {
    heavier: "'mass' must read back",
    weightless: "called for but not active: gravity",
    undriven: "rotor 3 with 0 kg m²",
    damped: "drag",
}


@each_case(("plant", "words"), [*FAULTS.items()])
def test_a_planted_fault_fails_the_run(
    plant: Callable[[Any], None], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    warp = installed("mujoco-warp")
    real = warp.open

    def faulty(*arguments: Any) -> Any:
        session: Any = real(*arguments)
        plant(session._world.on_device)
        return session

    with monkeypatch.context() as patch:
        patch.setattr(warp, "open", faulty, raising=False)
        run = warp.run(SCENES["free-rotors"], warp.method("RK4"), 1e-3, STEPS)
    assert run.outcome == "failed"
    assert words in run.reason, run.reason
