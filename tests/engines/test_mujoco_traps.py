"""What MuJoCo does to a top when nobody asks: each trap, planted, is caught; unplanted, it is not.

The traps and their sources are listed in docs/engines-mujoco.md.
"""

import copy
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scenes import PIVOT, SCENES, TILTED, TUMBLE, scene
from scipy.spatial.transform import Rotation
from spincheck.engines import EngineError
from spincheck.engines.adapters.mujoco import MuJoCo
from spincheck.engines.adapters.mujoco_urdf import MuJoCoURDF
from spincheck.engines.mjcf import mjcf
from spincheck.engines.mujoco_session import MuJoCoSession
from spincheck.engines.read_back import READ_BACK_SLACK, check_read_back
from spincheck.engines.urdf import BODY_LINK, urdf
from spincheck.scenarios import Scenario, Trajectory, angular_momentum_world, energy

EPS = np.finfo(float).eps
#: A dozen products of rotations and vectors.
ROUNDOFF = 64 * EPS
TIMESTEP = 1e-3
#: With it Euler blows the heavy top up within five seconds.
COARSE_TIMESTEP = 1e-2
TO_BLOW_UP = 500
MUJOCO = MuJoCo()


def session_of(text: str) -> MuJoCoSession:
    model = mujoco.MjModel.from_xml_string(text)
    start = model.key(0)
    return MuJoCoSession(model, start.qpos, start.qvel)


def planted(scene: Scenario, old: str, new: str, integrator: str = "RK4") -> MuJoCoSession:
    """A session whose MJCF has been tampered with."""
    text = mjcf(scene, TIMESTEP, integrator)
    assert old in text
    return session_of(text.replace(old, new))


def read_back(scene: Scenario, session: MuJoCoSession) -> None:
    check_read_back(scene, session.read_body(), session.read_state(), READ_BACK_SLACK)


def motion(scene: Scenario, integrator: str, steps: np.ndarray, timestep: float) -> Trajectory:
    run = MUJOCO.run(scene, MUJOCO.method(integrator), timestep, steps)
    assert run.trajectory is not None
    return run.trajectory


def sample(session: MuJoCoSession) -> Trajectory:
    state = {name: value[None] for name, value in vars(session.read_state()).items()}
    return Trajectory(t=np.zeros(1), **state)


# Reset and warnings


def blown_up(autoreset: str, cwd: Path) -> tuple[MuJoCoSession, float]:
    """The heavy top after it blew up under Euler, and the time its clock should show."""
    text = mjcf(SCENES["heavy-top"], COARSE_TIMESTEP, "Euler")
    session = session_of(text.replace('autoreset="disable"', f'autoreset="{autoreset}"'))
    session.advance(TO_BLOW_UP)
    assert list(cwd.iterdir()) == []
    return session, TO_BLOW_UP * COARSE_TIMESTEP


@pytest.fixture
def cwd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_run_that_blew_up_is_not_reset(cwd: Path) -> None:
    session, time = blown_up("disable", cwd)
    assert session._data.time == pytest.approx(time, abs=COARSE_TIMESTEP / 2)
    with pytest.raises(EngineError, match=r"MuJoCo warned: .* huge value in QACC"):
        session.check()


def test_with_autoreset_a_run_that_blew_up_begins_again_and_is_caught(cwd: Path) -> None:
    session, time = blown_up("enable", cwd)
    assert session._data.time < time / 2
    assert "automatic reset" in session.active()
    with pytest.raises(EngineError, match=r"MuJoCo warned"):
        session.check()


def test_a_reset_without_a_warning_is_caught_by_the_clock() -> None:
    session = session_of(mjcf(SCENES["heavy-top"], TIMESTEP, "RK4"))
    session.advance(10)
    session.check()
    mujoco.mj_resetData(session._model, session._data)
    with pytest.raises(EngineError, match=r"clock must be at 0.01 s, got 0.0 s: it was reset"):
        session.check()


def test_a_warning_nobody_heard_is_caught_by_the_counter() -> None:
    session = session_of(mjcf(SCENES["heavy-top"], TIMESTEP, "RK4"))
    session._data.warning[mujoco.mjtWarning.mjWARN_INERTIA].number = 1
    with pytest.raises(EngineError, match="counted 1 kinds of warning"):
        session.check()


def test_warnings_of_a_bare_step_end_up_in_a_log_file(
    cwd: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    session = session_of(mjcf(SCENES["heavy-top"], TIMESTEP, "RK4"))
    session._data.qvel[0] = np.nan
    mujoco.mj_step(session._model, session._data)
    assert [path.name for path in cwd.iterdir()] == ["MUJOCO_LOG.TXT"]
    assert "WARNING" in capfd.readouterr().err


def test_warnings_of_a_session_end_up_in_its_check_alone(
    cwd: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    session = session_of(mjcf(SCENES["heavy-top"], TIMESTEP, "RK4"))
    session._data.qvel[0] = np.nan
    session.advance(1)
    assert (list(cwd.iterdir()), capfd.readouterr()) == ([], ("", ""))
    with pytest.raises(EngineError, match="huge value in QVEL"):
        session.check()


# What a state is read from


def staleness(integrator: str) -> tuple[float, float, float]:
    """How far the com as read, and MuJoCo's xipos, are from the state; how far a step moves it."""
    session = session_of(mjcf(SCENES["heavy-tilted"], TIMESTEP, integrator))
    session.advance(100)
    state, fresh = session.read_state(), copy.copy(session._data)
    mujoco.mj_forward(session._model, fresh)
    ours, mujocos = (
        float(np.linalg.norm(com_world - fresh.xipos[1]))
        for com_world in (state.com_world, session._data.xipos[1])
    )
    return ours, mujocos, float(np.linalg.norm(state.velocity_world)) * TIMESTEP


@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_the_state_is_read_as_it_is_now(integrator: str) -> None:
    ours, _, _ = staleness(integrator)
    assert ours < ROUNDOFF


def test_derived_data_are_a_step_old_after_a_step_of_euler() -> None:
    _, mujocos, moved = staleness("Euler")
    assert mujocos == pytest.approx(moved, rel=0.1)


def test_derived_data_are_those_of_the_last_stage_after_a_step_of_rk4() -> None:
    _, mujocos, moved = staleness("RK4")
    assert 1e3 * ROUNDOFF < mujocos < 1e-3 * moved


@pytest.mark.parametrize("name", ["free-drag", "heavy-tilted", "everything"])
def test_reading_and_auditing_do_not_disturb_the_run(name: str) -> None:
    watched, alone = (session_of(mjcf(SCENES[name], TIMESTEP, "RK4")) for _ in range(2))
    for _ in range(20):
        watched.advance(1)
        watched.read_state()
        watched.read_body()
        watched.active()
    alone.advance(20)
    wanted = vars(alone.read_state())
    assert all(np.array_equal(getattr(watched.read_state(), key), wanted[key]) for key in wanted)


@pytest.mark.parametrize("name", ["free-tilted", "heavy-tilted"])
def test_velocities_are_those_mujoco_gives_for_the_bodys_com(name: str) -> None:
    session = session_of(mjcf(SCENES[name], TIMESTEP, "RK4"))
    session.advance(100)
    state, fresh = session.read_state(), copy.copy(session._data)
    mujoco.mj_forward(session._model, fresh)
    spatial = np.zeros(6)
    body = mujoco.mjtObj.mjOBJ_BODY
    mujoco.mj_objectVelocity(session._model, fresh, body, 1, spatial, 0)
    omega_world, velocity_world = spatial[:3], spatial[3:]
    R = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
    slack = ROUNDOFF * np.abs(spatial).max()
    assert np.abs(R.apply(state.omega_body) - omega_world).max() < slack
    assert np.abs(state.velocity_world - velocity_world).max() < slack
    # Taken for world axes, ω would be another vector.
    assert np.abs(state.omega_body - omega_world).max() > 1e9 * slack


@pytest.mark.parametrize("name", ["free-tilted", "heavy-tilted"])
def test_a_velocity_read_in_the_wrong_axes_does_not_read_back(name: str) -> None:
    scene = SCENES[name]
    session = session_of(mjcf(scene, TIMESTEP, "RK4"))
    read_back(scene, session)
    R = Rotation.from_quat(scene.start.q_world_body_wxyz, scalar_first=True)
    session._data.qvel[-3:] = R.apply(session._data.qvel[-3:])
    with pytest.raises(EngineError, match="'omega_body' must read back"):
        read_back(scene, session)


def test_the_velocity_of_a_free_joint_is_its_origins_not_the_coms() -> None:
    scene = SCENES["free-tilted"]
    session = session_of(mjcf(scene, TIMESTEP, "RK4"))
    session._data.qvel[:3] = scene.start.velocity_world
    with pytest.raises(EngineError, match="'velocity_world' must read back"):
        read_back(scene, session)


def test_angular_momentum_about_the_pivot_is_not_mujocos_which_is_about_the_com() -> None:
    scene = SCENES["heavy-tilted"]
    session = session_of(mjcf(scene, TIMESTEP, "RK4"))
    session.advance(100)
    state, fresh = session.read_state(), copy.copy(session._data)
    mujoco.mj_forward(session._model, fresh)
    mujoco.mj_subtreeVel(session._model, fresh)
    about_com = fresh.subtree_angmom[1]
    lever = scene.body.mass * np.cross(state.com_world, state.velocity_world)
    (about_pivot,) = angular_momentum_world(scene, sample(session))
    slack = ROUNDOFF * np.abs(about_pivot).max()
    assert np.abs(about_pivot - (about_com + lever)).max() < slack
    assert np.abs(about_pivot - about_com).max() > 1e9 * slack


@pytest.mark.parametrize("name", ["free-falling", "heavy-tilted"])
def test_mujocos_own_energy_is_ours_but_only_where_its_computation_is_on(name: str) -> None:
    scene = SCENES[name]
    session = session_of(mjcf(scene, TIMESTEP, "RK4"))
    session.advance(100)
    assert session._data.energy.tolist() == [0.0, 0.0]
    model, fresh = copy.copy(session._model), copy.copy(session._data)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    mujoco.mj_forward(model, fresh)
    (ours,) = energy(scene, sample(session))
    assert fresh.energy.sum() == pytest.approx(ours, rel=ROUNDOFF)


# What the compiler makes of a body


def test_moments_read_without_their_frame_are_another_tensor() -> None:
    scene = SCENES["heavy-tilted"]
    session = session_of(mjcf(scene, TIMESTEP, "RK4"))
    read_back(scene, session)
    session._model.body_iquat[1] = (1, 0, 0, 0)
    with pytest.raises(EngineError, match="'inertia_com' must read back"):
        read_back(scene, session)


def test_a_free_joint_aligned_with_the_inertial_frame_does_not_read_back() -> None:
    session = planted(SCENES["free-tilted"], 'align="false"', 'align="true"')
    with pytest.raises(EngineError, match="must read back"):
        read_back(SCENES["free-tilted"], session)


@pytest.mark.parametrize(
    ("compiler", "what"),
    [
        ('boundinertia="1.4"', "inertia_com"),
        ('boundmass="2"', "mass"),
        ('settotalmass="9"', "mass"),
    ],
)
@pytest.mark.usefixtures("cwd")
def test_a_compiler_that_alters_the_body_does_not_read_back(compiler: str, what: str) -> None:
    session = planted(SCENES["pivot"], "<worldbody>", f"<compiler {compiler}/><worldbody>")
    with pytest.raises(EngineError, match=f"'{what}' must read back"):
        read_back(SCENES["pivot"], session)


#: Frames in which the full tensor of a flat body is written, and the body itself: 1 + 2 = 3.
FLAT_FRAMES = [rotation.as_matrix() for rotation in Rotation.random(20, rng=0)]
FLAT_MOMENTS = np.diag([1.0, 2.0, 3.0])


def flat_scene(R: np.ndarray) -> Scenario:
    tensor = R @ FLAT_MOMENTS @ R.T
    rows = ((tensor + tensor.T) / 2).tolist()
    return scene("flat", body=f"\nmass = 1.0\ninertia = {rows}\n")


def with_full_tensor(R: np.ndarray, compiler: str) -> mujoco.MjModel:
    """As one would write it by hand: the full tensor, MuJoCo to diagonalise it."""
    root = ET.fromstring(mjcf(flat_scene(R), TIMESTEP, "RK4"))
    inertial = root.find("worldbody/body/inertial")
    assert inertial is not None
    del inertial.attrib["quat"], inertial.attrib["diaginertia"]
    tensor = flat_scene(R).body.inertia_com
    rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    inertial.set("fullinertia", " ".join(repr(float(x)) for x in tensor[rows, columns]))
    root.insert(0, ET.fromstring(f"<compiler {compiler}/>"))
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))


@pytest.mark.parametrize("engine", [MUJOCO, MuJoCoURDF()], ids=lambda engine: engine.name)
def test_flat_bodies_are_accepted_in_any_frame(engine: MuJoCo | MuJoCoURDF) -> None:
    for R in FLAT_FRAMES:
        flat = flat_scene(R)
        with engine.open(flat, engine.method("RK4"), TIMESTEP) as session:
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


def test_an_inertial_frame_lost_on_the_way_through_urdf_does_not_read_back() -> None:
    scene = SCENES["heavy-tilted"]
    root = ET.fromstring(urdf(scene))
    origin = root.find(f"link[@name='{BODY_LINK}']/inertial/origin")
    assert origin is not None
    origin.set("rpy", "0 0 0")
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    start = scene.start
    session = MuJoCoSession(model, start.q_world_body_wxyz.tolist(), start.omega_body.tolist())
    with pytest.raises(EngineError, match="'inertia_com' must read back"):
        read_back(scene, session)


def test_an_only_link_of_a_urdf_is_welded_to_the_world_unless_told_otherwise() -> None:
    assert mujoco.MjModel.from_xml_string(urdf(SCENES["free"])).nv == 0
    engine = MuJoCoURDF()
    with engine.open(SCENES["free"], engine.method("RK4"), TIMESTEP) as session:
        session.advance(10)
        moved = session.read_state().q_world_body_wxyz - SCENES["free"].start.q_world_body_wxyz
    assert np.abs(moved).max() > TIMESTEP


# What the integrators are


def omega(name: str, integrator: str) -> np.ndarray:
    return motion(SCENES[name], integrator, np.arange(0, 101, 10), COARSE_TIMESTEP).omega_body


@pytest.mark.parametrize("name", ["pivot", "pivot-drag", "heavy-tilted"])
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_on_a_pivot_implicitfast_and_discrete_are_euler(name: str, integrator: str) -> None:
    assert np.array_equal(omega(name, integrator), omega(name, "Euler"))
    assert not np.array_equal(omega(name, "implicit"), omega(name, "Euler"))


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_on_a_free_body_implicitfast_and_discrete_are_implicit(integrator: str) -> None:
    assert np.array_equal(omega("free", integrator), omega("free", "implicit"))
    assert not np.array_equal(omega("free", integrator), omega("free", "Euler"))


def energy_changes(integrator: str) -> np.ndarray:
    """Relative change of energy from sample to sample of a free tumble."""
    free = SCENES["free"]
    energies = energy(free, motion(free, integrator, np.arange(0, 101, 10), COARSE_TIMESTEP))
    return np.diff(energies) / energies[0]


def test_implicit_drains_a_tumble_steadily_and_rk4_does_not() -> None:
    # By about (h |ω|)² a step: 1.4e-3 at |ω| = 3.7 rad/s and h = 10 ms.
    per_sample = 10 * (COARSE_TIMESTEP * np.linalg.norm(SCENES["free"].start.omega_body)) ** 2
    drained = energy_changes("implicit")
    assert (drained < 0).all()
    assert -drained.sum() > per_sample / 10
    assert np.abs(energy_changes("RK4")).max() < 1e-3 * per_sample


def attitude_order(attitudes: list[Rotation]) -> float:
    """Signed order from three runs, each with half the timestep of the last."""
    coarse, medium, fine = attitudes
    difference = (coarse.inv() * medium).magnitude() / (medium.inv() * fine).magnitude()
    return float(np.log2(difference))


def uncorrected_rk4(steps: int) -> Rotation:
    """RK4 as MuJoCo had it up to 3.17: the stages' ω averaged as if rotations commuted."""
    body, start = SCENES["free"].body, SCENES["free"].start
    inertia = body.inertia_com
    q, w = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True), start.omega_body

    def alpha(omega: np.ndarray) -> np.ndarray:
        return np.linalg.solve(inertia, -np.cross(omega, inertia @ omega))

    h = 0.5 / steps
    for _ in range(steps):
        stages = [w]
        for fraction in (0.5, 0.5, 1.0):
            stages.append(w + fraction * h * alpha(stages[-1]))
        weights = np.array([1, 2, 2, 1]) / 6
        q = q * Rotation.from_rotvec(h * weights @ np.array(stages))
        w = w + h * weights @ np.array([alpha(stage) for stage in stages])
    return q


def test_attitude_is_of_fourth_order_and_would_be_of_second_without_the_correction() -> None:
    ladder = (32, 64, 128)
    runs = [motion(SCENES["free"], "RK4", np.array([0, n]), 0.5 / n) for n in ladder]
    by_mujoco = attitude_order([run.R_world_body[-1] for run in runs])
    without = attitude_order([uncorrected_rk4(n) for n in ladder])
    assert (round(by_mujoco), round(without)) == (4, 2)


def test_free_drag_leaves_the_translation_alone() -> None:
    """Damping of the free joint itself would brake it too."""
    dragged, undragged = (
        motion(SCENES[name], "RK4", np.array([0, 100]), TIMESTEP)
        for name in ("free-drag", "free-tilted")
    )
    slack = 100 * ROUNDOFF
    assert np.abs(dragged.velocity_world[-1] - undragged.velocity_world[-1]).max() < slack
    assert np.abs(dragged.omega_body[-1] - undragged.omega_body[-1]).max() > 1e9 * slack
    text = mjcf(SCENES["free-tilted"], TIMESTEP, "RK4").replace('damper="disable"', "")
    text = text.replace(
        '<freejoint name="joint" align="false" />', '<joint type="free" damping="0.3"/>'
    )
    damped = session_of(text)
    damped.advance(100)
    braked = damped.read_state().velocity_world - undragged.velocity_world[-1]
    assert np.abs(braked).max() > 1e9 * slack


def test_a_ball_joint_off_the_bodys_origin_is_not_the_pivot() -> None:
    off = scene("off", body=TILTED, start=TUMBLE, effects=PIVOT)
    session = planted(off, 'type="ball"', 'type="ball" pos="0 0 0.01"')
    assert "pivot" not in session.active()
