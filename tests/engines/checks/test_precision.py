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


def single(q_wxyz: np.ndarray) -> np.ndarray:
    return q_wxyz.astype(np.float32).astype(float)


#: As an integrator's that does not normalise, up to what rounding to 24 bits would be.
DRIFT = np.linspace(0.0, float(np.finfo(np.float32).eps), len(TURNING))
ATTITUDES = {
    "rounded to 24 bits": (single(TURNING), True),
    "in double precision": (TURNING, False),
    "of a norm that drifts": (TURNING * (1 + DRIFT)[:, None], False),
    "too few": (single(TURNING[: FEWEST - 1]), False),
}


@pytest.mark.parametrize(("q_wxyz", "is_single"), ATTITUDES.values(), ids=ATTITUDES)
def test_attitudes_rounded_to_24_bits_are_recognised(q_wxyz: np.ndarray, is_single: bool) -> None:
    states = State(q_wxyz, *3 * [NOTHING[: len(q_wxyz)]])
    assert ("held in 24 bits" in single_precision(states)) == is_single


@pytest.mark.needs_pybullet
@pytest.mark.parametrize("name", ["mujoco", "pybullet"])
def test_engines_of_double_precision_are_not_taken_for_others(name: str) -> None:
    engine, scenario = engines()[name], library_scene("fast-top")
    for method in engine.methods:
        run = engine.run(scenario, method, 2.0**-11, np.arange(0, 1024, 8))
        assert "24 bits" not in run.reason, method.name
