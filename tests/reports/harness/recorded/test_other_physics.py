"""Other physics of real engines, and clamps, are named with their numbers, and no integrator is."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import why_missing
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.scenarios import Scenario, Trajectory, load
from spincheck.scenarios.scenario import with_tables
from spincheck.suite import SCENES
from stepped import METHODS, SteppedEngine

pytestmark = pytest.mark.slow

TUMBLING, TOP, FAST = (
    load(SCENES / f"{name}.toml") for name in ("free-asymmetric", "heavy-top", "fast-sphere")
)


def clamped(limit: Callable[[np.ndarray], np.ndarray]) -> Trajectory:
    motion = solve(FAST, np.linspace(0.0, FAST.window.duration, 201)).trajectory
    return replace(motion, omega_body=limit(motion.omega_body))


#: Of a sphere that is faster at some samples; other physics: `reported_faults`, `invented_faults`.
CLAMPED: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "each component of ω in body axes is clamped to 350 rad/s": (
        lambda omega: np.clip(omega, -350.0, 350.0)
    ),
}


def explained(
    scenario: Scenario, motion: Trajectory, timestep: float, order: int = 1
) -> tuple[str, ...]:
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    recording = Recording(Path("motion.csv"), arrays, {"timestep": repr(timestep)})
    return judged_motion(scenario, recording, order).explained_by


@each_case("words", [*CLAMPED])
def test_a_clamp_is_named_with_its_number(words: str) -> None:
    (found,) = explained(FAST, clamped(CLAMPED[words]), 1e-5)
    assert found.startswith(words)


@each_case("order", [0, 1, 2])
@each_case("timestep", [0.001, 0.01, 0.05])
def test_what_an_integrator_does_is_no_other_physics(order: int, timestep: float) -> None:
    for scenario in (TUMBLING, TOP):
        steps = round(scenario.window.duration / timestep)
        every = max(1, round(0.005 / timestep))
        run = SteppedEngine().run(scenario, METHODS[order], timestep, np.arange(0, steps, every))
        assert run.trajectory is not None
        words = " ".join(explained(scenario, run.trajectory, timestep))
        assert "as if" not in words
        assert "clamped" not in words


def test_other_gravity_by_the_stated_method_is_no_longer_timestep() -> None:
    """Some method of the same order with five times the timestep would make the motion as well."""
    scenario, timestep = library_scene("spherical-pendulum"), 0.004
    stronger = tuple(1.02 * np.array(scenario.effects.gravity.acceleration))
    gravity = scenario.effects.gravity.model_copy(update={"acceleration": stronger})
    other = with_tables(scenario, effects=scenario.effects.model_copy(update={"gravity": gravity}))
    steps = round(scenario.window.duration / timestep)
    samples = np.arange(0, steps + 1, steps // 200)
    run = SteppedEngine().run(other, METHODS[1], timestep, samples)
    (words,) = explained(scenario, run.trajectory, timestep, 2)
    assert words.startswith("it moves as if gravity were 1.02")


REAL = {
    "pybullet default": (TUMBLING, "L were slowed by 0.04 + 0.04 ‖ω‖ /s"),
    "cannon-es point": (TUMBLING, "there were no gyroscopic torque"),
    "havok plain": (TUMBLING, "there were no gyroscopic torque"),
    "havok plain on a pivot": (TOP, "there were no gyroscopic torque"),
    "jolt default": (TUMBLING, "there were no gyroscopic torque", "L were slowed by 0.05 /s"),
    "physx default": (FAST, "‖ω‖ is clamped to 100 rad/s"),
}


@pytest.mark.parametrize("name", REAL)
def test_faults_of_real_engines_are_named(name: str) -> None:
    engine, method, *_ = name.split()
    if reason := why_missing(engine):
        pytest.skip(reason)
    scenario, words, *others = REAL[name]
    timestep = scenario.window.duration / 1000
    samples = np.arange(0, 1001, 5)
    run = engines()[engine].run(scenario, engines()[engine].method(method), timestep, samples)
    assert run.trajectory is not None
    found = explained(scenario, run.trajectory, timestep)
    assert words in found[0]
    for more in found[1:]:
        assert any(one in more for one in ("at 0.002 s makes", *others))
    assert len(found) > len(others)
