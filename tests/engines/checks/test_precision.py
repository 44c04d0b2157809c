"""States held in single precision are recognised by the rounding of the attitude's norm."""

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.checks.precision import FEWEST, single_precision
from spincheck.engines.checks.read_back import State

ANGLES = np.linspace(0.0, 3.0, 200)
TURNING = np.column_stack([np.cos(ANGLES), 0.6 * np.sin(ANGLES), 0 * ANGLES, 0.8 * np.sin(ANGLES)])
NOTHING = np.zeros((len(ANGLES), 3))


def states(q_wxyz: np.ndarray) -> State:
    return State(q_wxyz, *3 * [NOTHING[: len(q_wxyz)]])


def test_attitudes_rounded_to_24_bits_are_recognised() -> None:
    rounded = TURNING.astype(np.float32).astype(float)
    assert "held in 24 bits" in single_precision(states(rounded))


def test_attitudes_in_double_precision_are_not() -> None:
    assert single_precision(states(TURNING)) == ""


def test_a_norm_that_drifts_is_not() -> None:
    """As an integrator's that does not normalise, up to what rounding to 24 bits would be."""
    drift = np.linspace(0.0, float(np.finfo(np.float32).eps), len(TURNING))
    assert single_precision(states(TURNING * (1 + drift)[:, None])) == ""


def test_too_few_samples_say_nothing() -> None:
    rounded = TURNING[: FEWEST - 1].astype(np.float32).astype(float)
    assert single_precision(states(rounded)) == ""


@pytest.mark.needs_pybullet
@pytest.mark.parametrize("name", ["mujoco", "pybullet"])
def test_engines_of_double_precision_are_not_taken_for_others(name: str) -> None:
    engine, scenario = engines()[name], library_scene("fast-top")
    for method in engine.methods:
        run = engine.run(scenario, method, 2.0**-11, np.arange(0, 1024, 8))
        assert "24 bits" not in run.reason, method.name
