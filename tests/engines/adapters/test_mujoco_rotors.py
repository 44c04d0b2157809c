"""Rotors on hinges in engines: the published figure, and faint faults of hinges that are found.

That engines hold, step and restart them right is verified by the contract (`free-rotors`,
`pivot-rotors`); coarser faults of hinges are planted in `test_optional_rotors`.
"""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library_scene
from spincheck.engines import Engine, engines
from spincheck.engines.adapters.mujoco.engine import ANY_TIMESTEP
from spincheck.engines.adapters.mujoco.session import MuJoCoSession
from spincheck.engines.models.mjcf import mjcf
from spincheck.reference import solve
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.scenarios import Scenario, errors_between

BOX = "wheel-in-a-box"
#: Steps of 2 ms to 5 s, every tenth of a second.
SAMPLES, STEP = np.arange(0, 2501, 50), 2e-3


def test_semi_implicit_euler_is_43_degrees_off_where_rk4_is_on_a_flywheel_at_300_rad_a_second() -> (
    None
):
    """Known of MuJoCo from before: 0.745 rad after 5 s at 2 ms, RK4 below 4e-8."""
    scene, engine = library_scene(BOX), engines()["mujoco"]
    exact = solve(scene, SAMPLES * STEP).trajectory
    off = {}
    for name in ("Euler", "RK4"):
        run = engine.run(scene, engine.method(name), STEP, SAMPLES)
        assert run.trajectory is not None
        off[name] = errors_between(scene, run.trajectory, exact).attitude
    assert round(off["Euler"], 3) == 0.745
    assert off["RK4"] < 4e-8


Plant = Callable[[mujoco.MjModel], object]


def opened(monkeypatch: pytest.MonkeyPatch, plant: Plant) -> Engine:
    """MuJoCo with a fault in its compiled models."""
    engine = engines()["mujoco"]

    def open_planted(scenario: Scenario, method: object, timestep: float) -> MuJoCoSession:
        model = mujoco.MjModel.from_xml_string(mjcf(scenario, ANY_TIMESTEP, "RK4"))
        plant(model)
        model.opt.timestep = timestep
        return MuJoCoSession(scenario, model, model.key(0).qpos, model.key(0).qvel)

    monkeypatch.setattr(engine, "open", open_planted, raising=False)
    return engine


@each_case(
    ("fault", "words"),
    {
        "none": ("", ""),
        "a millionth of N m s": ("faint damping", "I dω/dt"),
        "a hundredth of the rotor's moment": ("faint armature", "I dω/dt"),
        "a ten thousandth of its momentum": (
            "faint moment",
            "behaves as if the rotors had 1.0001 times their angular momentum",
        ),
    },
)
def test_single_steps_show_a_faint_fault_of_a_hinge(
    fault: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def plant(model: mujoco.MjModel) -> None:
        model.dof_damping[6] = 1e-6 * (fault == "faint damping")
        model.dof_armature[6] = 1e-5 * (fault == "faint armature")
        model.body_inertia[2][2] *= 1 + 1e-4 * (fault == "faint moment")
        model.opt.disableflags = 0

    engine, scene = opened(monkeypatch, plant), library_scene(BOX)
    found = physics_in_words(engine, scene, engine.method("RK4"))
    assert words in found
    assert bool(found) == bool(fault)
