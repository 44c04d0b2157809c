"""Engines without the gyroscopic torque are detected by their motions, from made-up runs."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import MadeUp, at_stock, results
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.overview.causes import (
    STEADY,
    TELLING,
    turned_in_space,
    without_gyroscopic_torque,
)
from spincheck.reports.results.records import Row
from spincheck.scenarios import FloatArray, Trajectory

RIGHT, WRONG = MadeUp("right", "default", 1), MadeUp("wrong", "default", 1)
#: The one of the made-up scenes whose body is free.
FREE = "made-up-brick"


def moving(t: FloatArray, attitudes: Rotation, omega: ArrayLike) -> Trajectory:
    """In place, at a steady ω."""
    still = np.zeros((len(t), 3))
    q = attitudes.as_quat(scalar_first=True)
    return Trajectory(t, q, np.tile(omega, (len(t), 1)), still, still)


def turning_steadily(row: Row) -> Row:
    """The run of a body that is free, as if nothing turned its ω."""
    if row.motion is None or row.key.engine != "wrong" or row.key.scenario != FREE:
        return row
    t, omega = row.motion.t, row.motion.omega_body[0]
    start = Rotation.from_quat(row.motion.q_world_body_wxyz[0], scalar_first=True)
    attitudes = start * Rotation.from_rotvec(t[:, None] * omega)
    return replace(row, motion=moving(t, attitudes, omega))


def gathered(*, as_shipped: bool = True):
    stored = at_stock(results(methods=(RIGHT, WRONG)))
    methods = {
        pair: replace(declared, as_shipped=as_shipped) for pair, declared in stored.methods.items()
    }
    rows = list(map(turning_steadily, stored.rows))
    return report_data(replace(stored, rows=rows, methods=methods))


def test_the_engine_whose_omega_stays_in_space_is_reported_with_its_error_if_as_shipped():
    lacking, tried = without_gyroscopic_torque(gathered())
    scene = next(scene for scene in gathered().scenes if scene.name == FREE)
    worst = max(run.series["omega"].max() for run in scene.compared if run.runs.engine == "wrong")
    assert (lacking, tried) == ({"wrong": {FREE: worst}}, 2)
    assert without_gyroscopic_torque(gathered(as_shipped=False)) == ({}, 0)


@pytest.mark.parametrize("angle", [STEADY * TELLING / 2, TELLING, 2.0])
def test_the_turn_of_omega_in_space_is_the_largest_angle_from_its_start(angle):
    t = np.linspace(0.0, 1.0, 11)
    attitudes = Rotation.from_rotvec(np.outer(np.sin(np.pi * t) * angle, [1.0, 0.0, 0.0]))
    motion = moving(t, attitudes, [0.0, 3.0, 0.0])
    assert turned_in_space(motion) == pytest.approx(angle, rel=1e-12)
