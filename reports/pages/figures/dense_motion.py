"""The exact motion as closely sampled as a smooth line takes, whatever a run was sampled at."""

import math

import numpy as np

from ....reference import ExactMotion
from ....scenarios import Trajectory
from ..analysis.report_data import SceneRuns

#: Samples of a path, and of a turn at the fastest rate.
MOST, A_TURN = 500, 24


def dense_motion(scene: SceneRuns) -> Trajectory:
    """The exact motion of the window; of one of many turns, the first `MOST / A_TURN`."""
    assert scene.solved is not None, "what is exact is known of a solved scene"
    end = float(scene.solved.solution.trajectory.t[-1])
    turns = scene.fastest_rate * end / (2 * math.pi)
    shown = min(1.0, MOST / A_TURN / turns) if turns else 1.0
    return ExactMotion(scene.solved.scenario).outline(np.linspace(0.0, shown * end, MOST))
