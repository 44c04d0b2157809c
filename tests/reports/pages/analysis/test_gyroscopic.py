"""Engines without the gyroscopic torque are detected by their motions, from made-up runs."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import MadeUp, at_stock, results
from scipy.spatial.transform import Rotation
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.overview.causes import (
    STEADY,
    TELLING,
    turned_in_space,
    without_gyroscopic_torque,
)
from spincheck.reports.results.records import Row
from spincheck.scenarios import Trajectory

RIGHT, WRONG = MadeUp("right", "default", 1), MadeUp("wrong", "default", 1)
#: The one of the made-up scenes whose body is free.
FREE = "made-up-brick"


def turning_steadily(row: Row) -> Row:
    """The run of a body that is free, as if nothing turned its ω."""
    if row.motion is None or row.key.engine != "wrong" or row.key.scenario != FREE:
        return row
    t, omega = row.motion.t, row.motion.omega_body[0]
    start = Rotation.from_quat(row.motion.q_world_body_wxyz[0], scalar_first=True)
    attitudes = start * Rotation.from_rotvec(t[:, None] * omega)
    motion = Trajectory(
        t=t,
        q_world_body_wxyz=attitudes.as_quat(scalar_first=True),
        omega_body=np.tile(omega, (len(t), 1)),
        com_world=row.motion.com_world,
        velocity_world=row.motion.velocity_world,
    )
    return replace(row, motion=motion)


def gathered(*, as_shipped: bool = True):
    stored = at_stock(results(methods=(RIGHT, WRONG)))
    methods = {
        pair: replace(declared, as_shipped=as_shipped) for pair, declared in stored.methods.items()
    }
    return report_data(
        replace(stored, rows=[turning_steadily(row) for row in stored.rows], methods=methods)
    )


def test_the_engine_whose_omega_stays_in_space_is_reported_with_its_error():
    lacking, tried = without_gyroscopic_torque(gathered())
    scene = next(scene for scene in gathered().scenes if scene.name == FREE)
    worst = max(run.series["omega"].max() for run in scene.compared if run.runs.engine == "wrong")
    assert (lacking, tried) == ({"wrong": {FREE: worst}}, 2)


def test_methods_that_are_not_as_shipped_are_not_asked():
    assert without_gyroscopic_torque(gathered(as_shipped=False)) == ({}, 0)


@pytest.mark.parametrize("angle", [STEADY * TELLING / 2, TELLING, 2.0])
def test_the_turn_of_omega_in_space_is_the_largest_angle_from_its_start(angle):
    t = np.linspace(0.0, 1.0, 11)
    attitudes = Rotation.from_rotvec(np.outer(np.sin(np.pi * t) * angle, [1.0, 0.0, 0.0]))
    motion = Trajectory(
        t=t,
        q_world_body_wxyz=attitudes.as_quat(scalar_first=True),
        omega_body=np.tile([0.0, 3.0, 0.0], (len(t), 1)),
        com_world=np.zeros((len(t), 3)),
        velocity_world=np.zeros((len(t), 3)),
    )
    assert turned_in_space(motion) == pytest.approx(angle, rel=1e-12)
