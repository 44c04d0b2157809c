"""The exact motion, sampled closely enough for a smooth line."""

import math

import numpy as np

from ....reference import ExactMotion
from ....scenarios import Trajectory
from ..analysis.report_data import SceneRuns

#: Largest number of samples of a path; samples a turn at the fastest rate.
MOST, A_TURN = 500, 24


def dense_motion(scene: SceneRuns) -> Trajectory:
    """The exact motion of the window; if it has more than `MOST / A_TURN` turns, only that many."""
    end = float(scene.exact.solution.trajectory.t[-1])
    turns = scene.fastest_rate * end / (2 * math.pi)
    shown = min(1.0, MOST / A_TURN / turns) if turns else 1.0
    return ExactMotion(scene.exact.scenario).outline(np.linspace(0.0, shown * end, MOST))
