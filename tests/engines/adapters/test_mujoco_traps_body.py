"""Defaults of MuJoCo's compilers that alter a body: each, planted, is detected."""

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest
from mujoco_sessions import TIMESTEP, read_back
from scipy.spatial.transform import Rotation
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.models.description import PLAIN, Description
from spincheck.engines.models.mjcf import mjcf
from spincheck.engines.models.urdf import urdf
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import SCENES, scene

EPS = np.finfo(float).eps
#: A dozen products of rotations and vectors.
ROUNDOFF = 64 * EPS
MUJOCO = MuJoCo()
RK4 = MUJOCO.method("RK4")
BY_URDF = Description(urdf=True)


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


@pytest.mark.parametrize("description", [PLAIN, BY_URDF], ids=["MJCF", "URDF"])
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
    with MUJOCO.open_with(free, RK4, TIMESTEP, description=BY_URDF) as session:
        session.advance(10)
        moved = session.read_state().q_world_body_wxyz - free.start.q_world_body_wxyz
    assert np.abs(moved).max() > TIMESTEP
