"""Files at halved timesteps are judged as the engine's own ladder is, to the last bit."""

from pathlib import Path

import numpy as np
import pytest
from kinds_of_engines import required_engines
from library_scenes import library_scene
from spincheck.engines import Method
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.judging import judge
from spincheck.reports.harness.ladder import QUICK_STEPS
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.read import read_recording
from spincheck.reports.harness.recorded.recorded_ladder import study_of_files
from spincheck.reports.harness.recorded.recording import RecordingError
from spincheck.reports.harness.study import convergence_study_of, run_and_judge

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
    scene = library_scene("fast-top")
    if engine.unsupported(scene, method):
        pytest.skip(engine.unsupported(scene, method))
    study = convergence_study_of(scene, engine, method, prepare(scene, (), QUICK_STEPS))
    study.places = None
    own = run_and_judge(study, InProcess())
    files = [write(tmp_path, row.motion, row.timestep) for row in study.rows]
    motions = [judged_motion(scene, read_recording(path)) for path in files]
    judged = judge(study_of_files(scene, motions, min(method.order, method.attitude_order)).records)
    assert judged.verdict == own.verdict
    # Attitudes are normalised when they are read: an ulp, of errors of some 1e-10.
    assert judged.order == pytest.approx(own.order, abs=1e-6)
    assert judged.limit_error == pytest.approx(own.limit_error, rel=1e-6, abs=1e-15)


@pytest.fixture
def two(tmp_path):
    scene = library_scene("fast-top")
    from spincheck.reference import solve

    def recorded(timestep, times):
        path = write(tmp_path, solve(scene, times).trajectory, timestep)
        return judged_motion(scene, read_recording(Path(path)))

    return scene, recorded


def test_timesteps_that_are_not_halved_are_refused(two):
    scene, recorded = two
    motions = [recorded(dt, np.linspace(0, 1, 11)) for dt in (0.01, 0.004)]
    with pytest.raises(RecordingError, match=r"must be halved from file to file, got 0\.01 and"):
        judge(study_of_files(scene, motions, 1).records)


def test_files_without_common_times_are_refused(two):
    scene, recorded = two
    motions = [recorded(0.01, np.linspace(0, 1, 11)), recorded(0.005, np.linspace(0.01, 1.01, 11))]
    with pytest.raises(RecordingError, match="must share sample times"):
        judge(study_of_files(scene, motions, 1).records)
