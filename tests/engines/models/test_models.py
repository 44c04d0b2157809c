"""Models that engines load: the scene's numbers bit for bit, along principal axes, and no more.

That engines hold, by them, the body where the scene holds it, and that nothing else acts, is
verified by the contract.
"""

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest
from case_loops import each_case
from scipy.spatial.transform import Rotation
from spincheck.engines.checks.read_back import BodyReading
from spincheck.engines.models.mjcf import mjcf, start_coordinates, switched_off
from spincheck.engines.models.principal_frame import PrincipalFrame, principal_frame
from spincheck.engines.models.urdf import BODY_LINK, urdf
from spincheck.scenarios.body import Body, body_about_com
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps
#: Three products and two sums of rotation entries, each entry good to a few ulp.
ROUNDOFF = 16 * EPS
#: Models of rotors are read back by the contract.
RIGID = [name for name, scene in SCENES.items() if not scene.rotors]


# MJCF


@each_case("name", RIGID)
def test_numbers_of_an_mjcf_are_read_back_bit_for_bit(name: str) -> None:
    scene = SCENES[name]
    model = mujoco.MjModel.from_xml_string(mjcf(scene, 0.1 / 3, "RK4"))
    qpos, qvel = start_coordinates(scene)
    assert model.opt.timestep == 0.1 / 3
    assert model.opt.gravity.tolist() == scene.gravity_world.tolist()
    assert model.body_mass[1] == scene.body.mass
    assert model.body_ipos[1].tolist() == scene.body.com.tolist()
    assert model.key(0).qvel.tolist() == qvel
    # The compiler normalises the quaternion once more.
    assert np.abs(model.key(0).qpos - qpos).max() <= np.finfo(float).eps
    # Of a gravity of zero the audit tells nothing.
    assert ("gravity" in switched_off(scene)) == ("gravity" not in scene.called_for)


@each_case("integrator", ["Euler", "implicit", "implicitfast", "RK4", "discrete"])
def test_the_integrator_is_the_one_asked_for(integrator: str) -> None:
    model = mujoco.MjModel.from_xml_string(mjcf(SCENES["free"], 1e-3, integrator))
    enum = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator.upper()}"]
    assert model.opt.integrator == enum


# URDF


def numbers(element: ET.Element | None, key: str) -> np.ndarray:
    assert element is not None
    return np.array(element.attrib[key].split(), dtype=float)


def read(text: str) -> BodyReading:
    """The body as the URDF specification has it: inertia in the inertial frame, fixed-axis rpy."""
    inertial = ET.fromstring(text).find(f"link[@name='{BODY_LINK}']/inertial")
    assert inertial is not None
    origin, inertia = inertial.find("origin"), inertial.find("inertia")
    R = Rotation.from_euler("xyz", numbers(origin, "rpy")).as_matrix()
    entries = {
        key: numbers(inertia, f"i{key}").item() for key in ("xx", "xy", "xz", "yy", "yz", "zz")
    }
    tensor = np.array([[entries["".join(sorted(r + c))] for c in "xyz"] for r in "xyz"])
    mass = numbers(inertial.find("mass"), "value").item()
    return BodyReading(mass, numbers(origin, "xyz"), R @ tensor @ R.T)


@each_case("name", RIGID)
def test_in_a_urdf_mass_and_com_are_there_bit_for_bit_and_the_tensor_to_rounding(name: str) -> None:
    """The com from where the body is held, or else from its origin."""
    scene, held = SCENES[name], read(urdf(SCENES[name]))
    assert held.mass == scene.body.mass
    assert held.com.tolist() == scene.constraint.lever.tolist()
    wanted = scene.body.inertia_com
    assert np.abs(held.inertia_com - wanted).max() < ROUNDOFF * np.abs(wanted).max()


# The principal frame

MOMENTS = {
    "distinct": (1.0, 2.0, 2.5),
    "symmetric": (1.0, 1.0, 0.5),
    "nearly-symmetric": (1.0, 1.0 + 1e-12, 0.5),
    "plate": (1.0, 2.0, 3.0),
    "ball": (1.0, 1.0, 1.0),
    "needle": (1.0, 1.0, 1e-9),
}
ROTATIONS = Rotation.random(20, rng=1)


def turned(moments: tuple[float, float, float], R_body_axes: Rotation) -> Body:
    R = R_body_axes.as_matrix()
    tensor = R @ np.diag(moments) @ R.T
    tensor = (tensor + tensor.T) / 2
    return body_about_com(1.0, (0.0, 0.0, 0.0), tensor.tolist())


def relative_misfit(frame: PrincipalFrame, R_body_axes: Rotation, body: Body) -> float:
    R = R_body_axes.as_matrix()
    misfit = R @ np.diag(frame.moments) @ R.T - body.inertia_com
    return float(np.abs(misfit).max() / np.abs(body.inertia_com).max())


def from_quaternion(frame: PrincipalFrame) -> Rotation:
    return Rotation.from_quat(frame.q_body_axes_wxyz, scalar_first=True)


def from_angles(frame: PrincipalFrame, order: str = "xyz") -> Rotation:
    return Rotation.from_euler(order, frame.rpy_body_axes)


@each_case("kind", [*MOMENTS])
def test_moments_and_axes_give_the_tensor_back_in_either_notation(kind: str) -> None:
    for R_body_axes in ROTATIONS:
        body = turned(MOMENTS[kind], R_body_axes)
        frame = principal_frame(body)
        q = from_quaternion(frame)
        assert relative_misfit(frame, q, body) < ROUNDOFF
        assert (from_angles(frame).inv() * q).magnitude() < ROUNDOFF
        for wrong in (q.inv(), from_angles(frame, "XYZ")) if kind == "distinct" else ():
            assert relative_misfit(frame, wrong, body) > 1e9 * ROUNDOFF


def test_a_diagonal_tensor_keeps_the_body_axes_in_their_order() -> None:
    frame = principal_frame(body_about_com(1.0, (0, 0, 0), np.diag([2.5, 1.0, 2.0]).tolist()))
    assert frame.moments.tolist() == [2.5, 1.0, 2.0]
    assert frame.q_body_axes_wxyz.tolist() == [1, 0, 0, 0]
    assert frame.rpy_body_axes.tolist() == [0, 0, 0]


def excess(frame: PrincipalFrame) -> float:
    """By how much the largest moment exceeds the sum of the others, as doubles."""
    smallest, middle, largest = sorted(frame.moments)
    return float(largest - (smallest + middle))


def test_a_flat_body_obeys_the_triangle_inequality_and_is_kept_as_far_from_flat_as_asked() -> None:
    thickness = 64 * EPS
    for body in (turned(MOMENTS["plate"], R_body_axes) for R_body_axes in ROTATIONS):
        assert excess(principal_frame(body)) <= 0
        frame = principal_frame(body, thickness)
        assert excess(frame) <= -0.5 * thickness * frame.moments.max()
    solid = turned(MOMENTS["distinct"], ROTATIONS[0])
    assert (principal_frame(solid, thickness).moments == principal_frame(solid).moments).all()


def test_gimbal_lock_is_no_trap() -> None:
    # The smallest moment is along z, and the first principal axis belongs to it: pitch is ±90°.
    body = body_about_com(1.0, (0, 0, 0), [[2.0, 0.5, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 1.25]])
    frame = principal_frame(body)
    assert abs(frame.rpy_body_axes[1]) == pytest.approx(np.pi / 2, rel=ROUNDOFF)
    assert relative_misfit(frame, from_quaternion(frame), body) < ROUNDOFF
    assert relative_misfit(frame, from_angles(frame), body) < ROUNDOFF
