"""Files at halved timesteps are judged as the steps of the engine that made them are."""

from dataclasses import replace

import numpy as np
import pytest
from faulty_mujoco import FaultyMuJoCo, PlantedFault
from kinds_of_engines import required_engines
from library_scenes import library_scene
from spincheck.engines import Method
from spincheck.reference import solve
from spincheck.reports.harness.judging import judge
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.recorded.files.read import read_recording
from spincheck.reports.harness.recorded.files.recording import RecordingError
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.recorded_ladder import study_of_files
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS
from studies import verdict_of

HEADS = "t,qw,qx,qy,qz,wx,wy,wz,x,y,z,vx,vy,vz"


def write(folder, motion, timestep, precision="double"):
    path = folder / f"{timestep!r}.csv"
    states = [motion.q_world_body_wxyz, motion.omega_body, motion.com_world, motion.velocity_world]
    header = f"# timestep = {timestep!r}\n# precision = {precision}\n{HEADS}"
    table = np.column_stack([motion.t, *states])
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header=header, comments="")
    return path


PAIRS = [
    pytest.param(engine, method, id=f"{engine.name}-{method.name}")
    for engine in required_engines()
    for method in engine.methods
    if not method.as_shipped
]


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "method"), PAIRS)
def test_the_verdict_is_the_engine_s_own(tmp_path, engine, method: Method):
    """But for what no file shows: whether a step depends on the state alone."""
    scene = library_scene("fast-top")
    if engine.unsupported(scene, method):
        pytest.skip(engine.unsupported(scene, method))
    study = convergence_study_of(scene, engine, method, prepare(scene, (), QUICK_STEPS))
    own = verdict_of(study)
    files = [write(tmp_path, row.motion, row.timestep) for row in study.rows if row.motion]
    motions = [judged_motion(scene, read_recording(path)) for path in files]
    judged = judge(study_of_files(scene, motions, min(method.order, method.attitude_order)).records)
    assert judged.verdict == own.verdict, judged.reason


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "method"),
    [
        (PlantedFault("gravity", 1e-2), "RK4"),
        (PlantedFault("moment", 1e-2), "RK4"),
        pytest.param(
            *(PlantedFault("moment", 1e-1), "Euler"),
            marks=pytest.mark.xfail(reason="64 limits 60 standard errors off are each likely"),
        ),
    ],
)
def test_files_of_an_engine_with_a_fault_disagree(tmp_path, fault, method):
    scene, engine = library_scene("nutation-loops"), FaultyMuJoCo(fault)
    chosen = engine.method(method)
    # Steps are not looked at, so that all runs are made.
    solved = replace(prepare(scene, (), QUICK_STEPS), places=None)
    study = convergence_study_of(scene, engine, chosen, solved)
    verdict_of(study)
    files = [write(tmp_path, row.motion, row.timestep) for row in study.rows if row.motion]
    motions = [judged_motion(scene, read_recording(path)) for path in files]
    judged = judge(study_of_files(scene, motions, chosen.order).records)
    assert judged.verdict == "disagrees", judged.reason


@pytest.mark.parametrize(
    ("timestep", "begin", "words"),
    [
        (0.004, 0.0, r"must be halved from file to file, got 0\.01 and"),
        (0.005, 0.01, "must share two sample times"),
    ],
)
def test_files_that_are_no_ladder_are_refused(tmp_path, timestep, begin, words):
    scene = library_scene("fast-top")
    motions = []
    for dt, first in ((0.01, 0.0), (timestep, begin)):
        motion = solve(scene, first + np.linspace(0, 1, 11)).trajectory
        motions.append(judged_motion(scene, read_recording(write(tmp_path, motion, dt))))
    with pytest.raises(RecordingError, match=words):
        judge(study_of_files(scene, motions, 1).records)
