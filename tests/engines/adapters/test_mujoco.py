"""MuJoCo, by MJCF and by URDF, beyond the contract: one body either way, honest failures."""

import mujoco
import numpy as np
import pytest
from library_scenes import library
from scipy.spatial.transform import Rotation
from spincheck.engines import Engine, EngineError, Run
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.mujoco.session import MuJoCoSession, compiled
from spincheck.engines.checks.read_back import READ_BACK_SLACK, UnsupportedError, differences
from spincheck.engines.encodings import ENCODINGS, EncodedEngine
from spincheck.engines.models.description import PLAIN, Description
from spincheck.engines.models.urdf import urdf
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import SCENES, SPUN_UP, scene

EPS = np.finfo(float).eps
#: A dozen products of rotations and vectors.
ROUNDOFF = 64 * EPS
MUJOCO = MuJoCo()
RK4 = MUJOCO.method("RK4")
BY_URDF = EncodedEngine(MUJOCO, "urdf")
AS_URDF = Description(urdf=True)
READERS = pytest.mark.parametrize("engine", [MUJOCO, BY_URDF], ids=["MJCF", "URDF"])
TIMESTEP = 1e-3
STEPS = np.arange(0, 101, 20)


def run(engine: Engine, name: str, timestep: float = TIMESTEP) -> Run:
    return engine.run(SCENES[name], RK4, timestep, STEPS)


def columns(run: Run) -> np.ndarray:
    """Everything a trajectory holds, side by side."""
    motion = run.trajectory
    assert motion is not None
    return np.hstack(
        [motion.q_world_body_wxyz, motion.omega_body, motion.com_world, motion.velocity_world]
    )


@pytest.mark.parametrize("name", ["free-tilted", "free-falling", "pivot-plate", "heavy-tilted"])
def test_urdf_and_mjcf_are_one_body(name: str) -> None:
    by_mjcf = columns(run(MUJOCO, name))
    difference = np.abs(columns(run(BY_URDF, name)) - by_mjcf).max()
    # Each step repeats the round-off of the tensor, which the URDF reader diagonalises again.
    roundoff = STEPS[-1] * 16 * EPS * np.abs(by_mjcf).max()
    assert difference < roundoff
    other_scene = columns(run(MUJOCO, "free"))
    assert np.abs(other_scene - by_mjcf).max() > 1e9 * roundoff


@READERS
@pytest.mark.parametrize(
    "body",
    ["\nmass = 1.0\ninertia = [1e-18, 1e-18, 1e-18]\n", "\nmass = 1e-18\ninertia = [1, 1, 1]\n"],
    ids=["inertia", "mass"],
)
def test_a_body_too_small_for_the_compiler_is_unsupported(engine: Engine, body: str) -> None:
    done = engine.run(scene("tiny", body=body), RK4, TIMESTEP, STEPS)
    assert (done.outcome, done.cause) == ("unsupported", "body")
    assert "scale the scene up" in done.reason


def test_what_the_compiler_refuses_is_reported_in_its_words() -> None:
    # No body has such moments: one exceeds the sum of the others.
    inertial = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/>"
    text = f"<mujoco><worldbody><body><freejoint/>{inertial}</body></worldbody></mujoco>"
    with pytest.raises(EngineError, match=r"MuJoCo's compiler: .*inertia"):
        compiled(lambda: mujoco.MjModel.from_xml_string(text))


def read_back(scene: Scenario, session: MuJoCoSession) -> None:
    """What the run loop does before the first step."""
    held = session.read_body(), session.read_state()
    assert [one.complaint for one in differences(scene, *held, READ_BACK_SLACK)] == []


def test_urdf_is_read_as_every_scene_of_the_library_states_its_body() -> None:
    able = [one for one in library() if not ENCODINGS["urdf"].why_not(MUJOCO, one)]
    assert len(able) > len(library()) / 2
    refused = set()
    for scenario in able:
        try:
            with MUJOCO.open_with(scenario, RK4, TIMESTEP, description=AS_URDF) as session:
                read_back(scenario, session)
        except UnsupportedError:
            refused.add(scenario.name)
    # Below what MuJoCo's compiler takes.
    assert refused == {"dust-grain", "mems-top", "micrometre-top"}


def test_a_start_beyond_what_mujoco_allows_diverges_in_its_words() -> None:
    fast = SPUN_UP.replace("40.0", "1e11")
    done = MUJOCO.run(
        scene("fast", start=fast, duration=1e-3), MUJOCO.method("RK4"), TIMESTEP, STEPS
    )
    assert done.outcome == "diverged"
    assert "huge value in QVEL" in done.reason


def test_the_version_is_the_librarys() -> None:
    assert MUJOCO.version == mujoco.__version__


@READERS
def test_a_compiler_that_only_warns_fails_the_run_too(engine: Engine) -> None:
    # About its origin the body's mass matrix is singular in double precision.
    far = "\nmass = 1e8\ninertia = [1e-9, 1e-9, 1e-9]\ncom = [3.0, 4.0, 5.0]\n"
    done = engine.run(scene("far", body=far), RK4, TIMESTEP, STEPS)
    assert done.outcome == "failed"
    assert "Inertia matrix is too close to singular" in done.reason


# Bodies that its compilers alter

#: Frames in which the full tensor of a flat body is written, and the body itself: 1 + 2 = 3.
FLAT_FRAMES = [rotation.as_matrix() for rotation in Rotation.random(20, rng=0)]
FLAT_MOMENTS = np.diag([1.0, 2.0, 3.0])


def flat_scene(R: np.ndarray) -> Scenario:
    tensor = R @ FLAT_MOMENTS @ R.T
    rows = ((tensor + tensor.T) / 2).tolist()
    return scene("flat", body=f"\nmass = 1.0\ninertia = {rows}\n")


def with_full_tensor(R: np.ndarray, compiler: str) -> mujoco.MjModel:
    """As one would write it by hand: the full tensor, MuJoCo to diagonalise it."""
    tensor = flat_scene(R).body.inertia_com[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    entries = " ".join(map(repr, tensor.tolist()))
    inertial = f'<inertial pos="0 0 0" mass="1" fullinertia="{entries}"/>'
    bodies = f"<worldbody><body><freejoint/>{inertial}</body></worldbody>"
    return mujoco.MjModel.from_xml_string(f"<mujoco><compiler {compiler}/>{bodies}</mujoco>")


@pytest.mark.parametrize("description", [PLAIN, AS_URDF], ids=["MJCF", "URDF"])
def test_flat_bodies_are_accepted_in_any_frame(description: Description) -> None:
    for R in FLAT_FRAMES:
        flat = flat_scene(R)
        with MUJOCO.open_with(flat, RK4, TIMESTEP, description=description) as session:
            read_back(flat, session)


def is_refused(R: np.ndarray) -> bool:
    try:
        with_full_tensor(R, "")
    except ValueError as error:
        return "inertia must satisfy A + B >= C" in str(error)
    return False


def test_full_tensors_of_flat_bodies_are_refused_in_some_frames() -> None:
    refused = [R for R in FLAT_FRAMES if is_refused(R)]
    assert 0 < len(refused) < len(FLAT_FRAMES)


def test_balanceinertia_would_make_balls_of_them() -> None:
    models = [with_full_tensor(R, 'balanceinertia="true"') for R in FLAT_FRAMES]
    balls = [model for model in models if np.ptp(model.body_inertia[1]) < ROUNDOFF]
    assert 0 < len(balls) < len(FLAT_FRAMES)


def test_an_only_link_of_a_urdf_is_welded_to_the_world_unless_told_otherwise() -> None:
    assert mujoco.MjModel.from_xml_string(urdf(SCENES["free"])).nv == 0
    free = SCENES["free"]
    with MUJOCO.open_with(free, RK4, TIMESTEP, description=AS_URDF) as session:
        session.advance(10)
        moved = session.read_state().q_world_body_wxyz - free.start.q_world_body_wxyz
    assert np.abs(moved).max() > TIMESTEP
