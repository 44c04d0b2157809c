"""PyBullet's model of a body: what it reads, in which frames, and what it ignores."""

import tempfile
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pybullet as p
import pytest
from pybullet_planted import (
    MAXIMAL,
    MULTIBODY,
    STEPS,
    TIMESTEP,
    opened,
    rotor,
    run,
)
from scipy.spatial.transform import Rotation
from spincheck.engines import Method
from spincheck.engines.adapters.pybullet import load as pybullet_load
from spincheck.engines.adapters.pybullet import session, worlds
from spincheck.engines.checks.read_back import READ_BACK_SLACK
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps
#: A few products of rotations a step, over `STEPS`.
ROUND_OFF = 16 * EPS * STEPS[-1]


# The model file


@pytest.fixture
def one_place(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    places = SimpleNamespace(TemporaryDirectory=lambda **_: nullcontext(str(tmp_path)))
    monkeypatch.setattr(pybullet_load, "tempfile", places)


def test_no_file_of_a_world_is_left_where_its_process_may_be_killed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Workers are killed, and run nothing at their exit."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with opened(SCENES["free-tilted"], MULTIBODY):
        assert [*tmp_path.iterdir()] == []


@pytest.mark.usefixtures("one_place")
def test_a_file_is_read_though_another_world_has_read_one_of_its_name(monkeypatch) -> None:
    monkeypatch.setattr(worlds, "_empty", [])
    assert run(SCENES["free-tilted"], MULTIBODY).outcome == "ok"
    worlds._empty.clear()
    assert run(SCENES["free"], MULTIBODY).outcome == "ok"


@pytest.mark.usefixtures("one_place")
def test_a_world_that_has_read_another_of_its_name_does_not_read_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shared = p.connect(p.DIRECT)
    monkeypatch.setattr(session, "take_world", lambda: shared)
    monkeypatch.setattr(session, "give_back", lambda _: None)
    run(SCENES["free-tilted"], MULTIBODY)
    result = run(SCENES["free"], MULTIBODY)
    monkeypatch.undo()
    p.disconnect(shared)
    assert result.outcome == "failed"
    assert result.reason.startswith("'mass' must read back as")


# Frames


def test_a_spherical_joints_velocity_is_along_the_childs_principal_axes() -> None:
    scenario = SCENES["pivot"]
    with opened(scenario, MULTIBODY) as session:
        held = p.getJointStateMultiDof(session.world.body, 0, session.client)[1]
        expected = session.model.body_from_principal.inv().apply(
            np.array(scenario.start.omega_body)
        )
        assert held == pytest.approx(expected, rel=READ_BACK_SLACK)


def attitude_after_a_step(spin: float) -> float:
    """Angle that a hung rotor is read to have turned by in its first step."""
    with opened(rotor(spin), MULTIBODY) as session:
        session.advance(1)
        q = session.read_state().q_world_body_wxyz
        return float(Rotation.from_quat(q, scalar_first=True).magnitude())


def test_a_link_is_read_as_it_is_now() -> None:
    assert attitude_after_a_step(10.0) == pytest.approx(10.0 * TIMESTEP, rel=ROUND_OFF)


def test_without_forward_kinematics_it_is_read_a_step_late(monkeypatch: pytest.MonkeyPatch) -> None:
    real = p.getLinkState
    monkeypatch.setattr(
        p,
        "getLinkState",
        lambda body, link, velocity, _, client: real(body, link, velocity, 0, client),
    )
    assert attitude_after_a_step(10.0) == 0.0


# A rigid body's inertia


def first_spin(method: Method) -> np.ndarray:
    """ω after one step from rest under a torque, world axes."""
    with opened(SCENES["free-torque-world"], method) as session:
        p.resetBaseVelocity(session.world.body, np.zeros(3), np.zeros(3), session.client)
        session.advance(1)
        return np.array(p.getBaseVelocity(session.world.body, session.client)[1])


def test_a_rigid_body_is_loaded_in_its_pose_lest_its_inertia_be_that_of_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scenario = SCENES["free-torque-world"]
    R = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True).as_matrix()
    tensor_world = R @ scenario.body.inertia_com @ R.T
    expected = TIMESTEP * np.linalg.solve(tensor_world, scenario.pushed["torque_world"])
    assert first_spin(MAXIMAL) == pytest.approx(expected, rel=READ_BACK_SLACK)

    real = p.loadURDF

    def load_then_turn(file: str, position: Any, attitude: Any, **keywords: Any) -> int:
        right = real(file, position, attitude, **keywords)
        pose = p.getBasePositionAndOrientation(right, keywords["physicsClientId"])
        p.removeBody(right, keywords["physicsClientId"])
        turned = int(real(file, **keywords))
        p.resetBasePositionAndOrientation(turned, *pose, keywords["physicsClientId"])
        return turned

    monkeypatch.setattr(p, "loadURDF", load_then_turn)
    assert np.abs(first_spin(MAXIMAL) - expected).max() > 0.1 * np.abs(expected).max()
