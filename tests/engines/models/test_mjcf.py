"""The MJCF is the scene, complete: its body, its effects, its start, and nothing more."""

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
from case_loops import each_case
from scipy.spatial.transform import Rotation
from spincheck.engines.models.mjcf import mjcf, start_coordinates, switched_off
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import DRAG, PIVOT, SCENES, TILTED, TORQUE_BODY, scene

EPS = np.finfo(float).eps
#: A 6 × 6 solve, rotations and cross products: some hundred roundings, amplified by the spread of
#: the moments.
ROUNDOFF = 1000 * EPS
TIMESTEP = 1e-3
#: Models of rotors are read back by the contract.
RIGID = [name for name, scene in SCENES.items() if not scene.rotors]
#: `discrete` reports the step map, which is the acceleration only in the limit.
CONTINUOUS = ("Euler", "implicit", "implicitfast", "RK4")


def compiled(text: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


def acceleration_by_hand(scene: Scenario) -> np.ndarray:
    """q̈ at the start from Euler's equations (Goldstein, Classical Mechanics, eq. 5.39).

    About the pivot, or about the com; for a free body the origin's acceleration comes first,
    a_origin = g − ω̇ × c − ω × (ω × c).
    """
    body, omega, com = scene.body, scene.start.omega_body, scene.body.com
    R = Rotation.from_quat(scene.start.q_world_body_wxyz, scalar_first=True).as_matrix()
    pushed = scene.pushed
    torque = pushed["torque_body"] + R.T @ pushed["torque_world"] - pushed["drag"] * omega
    inertia = body.inertia_com
    if scene.constraint.is_pivot:
        inertia = body.inertia_origin
        torque = torque + body.mass * np.cross(com, R.T @ scene.gravity_world)
    torque = torque - np.cross(omega, inertia @ omega)
    if scene.effects.table is not None:
        return acceleration_on_table(scene, R, torque)
    alpha = np.linalg.solve(inertia, torque)
    if scene.constraint.is_pivot:
        return alpha
    swing = np.cross(alpha, com) + np.cross(omega, np.cross(omega, com))
    return np.concatenate([scene.gravity_world - R @ swing, alpha])


def acceleration_on_table(scene: Scenario, R: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Of the tip along the table, and ω̇: from seven equations for the com, ω̇ and the force."""
    body, omega, lever = scene.body, scene.start.omega_body, scene.constraint.lever
    across = np.cross(np.eye(3), lever).T
    equations, given = np.zeros((7, 7)), np.zeros(7)
    # m a = m g + N ẑ;  I ω̇ = torque + N (R ẑ) × lever;  ẑ·a = ẑ·R (ω̇ × lever + ω × (ω × lever)).
    equations[:3, :3], equations[2, 6] = body.mass * np.eye(3), -1.0
    given[:3] = body.mass * scene.gravity_world
    equations[3:6, 3:6], equations[3:6, 6] = body.inertia_com, -np.cross(R[2], lever)
    given[3:6] = torque
    circling = np.cross(omega, np.cross(omega, lever))
    equations[6, 2], equations[6, 3:6] = 1.0, -R[2] @ across
    given[6] = R[2] @ circling
    solved = np.linalg.solve(equations, given)
    tip = solved[:3] - R @ (np.cross(solved[3:6], lever) + circling)
    return np.concatenate([tip[:2], solved[3:6]])


def relative_misfit(model_of: Scenario, hand: Scenario, integrator: str) -> float:
    _, data = compiled(mjcf(model_of, TIMESTEP, integrator))
    wanted = acceleration_by_hand(hand)
    return float(np.abs(data.qacc - wanted).max() / np.abs(wanted).max())


@each_case("integrator", CONTINUOUS)
@each_case("name", RIGID)
def test_the_first_acceleration_is_eulers(name: str, integrator: str) -> None:
    assert relative_misfit(SCENES[name], SCENES[name], integrator) < ROUNDOFF


@each_case("pivot", ["", PIVOT])
@each_case(
    ("effect", "fault"),
    [
        (TORQUE_BODY, TORQUE_BODY.replace("body", "world")),
        (TORQUE_BODY, TORQUE_BODY.replace("0.4", "-0.4")),
        (DRAG, DRAG.replace("0.3", "0.6")),
    ],
)
def test_the_first_acceleration_distinguishes_effects(pivot: str, effect: str, fault: str) -> None:
    right = scene("right", body=TILTED, effects=pivot + effect)
    wrong = scene("wrong", body=TILTED, effects=pivot + fault)
    assert relative_misfit(wrong, right, "RK4") > 1e9 * ROUNDOFF


@each_case("name", RIGID)
def test_numbers_are_read_back_bit_for_bit(name: str) -> None:
    scene = SCENES[name]
    model, data = compiled(mjcf(scene, 0.1 / 3, "RK4"))
    qpos, qvel = start_coordinates(scene)
    assert model.opt.timestep == 0.1 / 3
    assert model.opt.gravity.tolist() == scene.gravity_world.tolist()
    assert model.body_mass[1] == scene.body.mass
    assert model.body_ipos[1].tolist() == scene.body.com.tolist()
    assert data.qvel.tolist() == qvel
    # The compiler normalises the quaternion once more.
    assert np.abs(data.qpos - qpos).max() <= EPS


@each_case("integrator", [*CONTINUOUS, "discrete"])
def test_the_integrator_is_the_one_asked_for(integrator: str) -> None:
    model, _ = compiled(mjcf(SCENES["free"], TIMESTEP, integrator))
    enum = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator.upper()}"]
    assert model.opt.integrator == enum


def test_a_model_that_names_no_integrator_gets_euler_at_2_ms() -> None:
    root = ET.fromstring(mjcf(SCENES["free"], TIMESTEP, "RK4"))
    option = root.find("option")
    assert option is not None
    del option.attrib["integrator"], option.attrib["timestep"]
    model, _ = compiled(ET.tostring(root, encoding="unicode"))
    assert (model.opt.integrator, model.opt.timestep) == (mujoco.mjtIntegrator.mjINT_EULER, 2e-3)


@each_case("name", [*SCENES])
def test_only_passes_that_the_scene_needs_are_left_on(name: str) -> None:
    called_for = SCENES[name].called_for
    torques = {"torque_body", "torque_world"} & called_for
    disabled = switched_off(SCENES[name])
    assert ("gravity" in disabled) == ("gravity" not in called_for)
    assert ("damper" in disabled) == (not {"drag", "pivot"} <= called_for)
    assert ("actuation" in disabled) == (
        not torques and ("drag" not in called_for or "pivot" in called_for)
    )
    assert {"constraint", "contact", "sensor", "spring", "autoreset", "warmstart"} <= set(disabled)


@each_case("name", RIGID)
def test_the_model_has_one_body_no_joint_too_many_and_no_geometry(name: str) -> None:
    model, _ = compiled(mjcf(SCENES[name], TIMESTEP, "RK4"))
    joints = 3 if SCENES[name].effects.table else 1
    assert (model.nbody, model.njnt, model.ngeom, model.nsensor, model.neq) == (2, joints, 0, 0, 0)


def test_a_scene_without_gravity_has_no_gravity_vector() -> None:
    model, _ = compiled(mjcf(SCENES["pivot"], TIMESTEP, "RK4"))
    assert not model.opt.gravity.any()


def test_the_start_of_a_free_body_is_that_of_its_origin_not_of_its_com() -> None:
    scene = SCENES["free-tilted"]
    _, data = compiled(mjcf(scene, TIMESTEP, "RK4"))
    assert np.abs(data.xipos[1] - scene.start.position_world).max() < ROUNDOFF
    assert np.abs(data.qpos[:3] - scene.start.position_world).max() > 1e9 * ROUNDOFF
