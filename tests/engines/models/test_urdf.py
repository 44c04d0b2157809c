"""The URDF holds the scene's body, bit for bit, its pivot, and nothing else."""

import xml.etree.ElementTree as ET

import numpy as np
from case_loops import each_case
from scipy.spatial.transform import Rotation
from spincheck.engines.checks.read_back import BodyReading
from spincheck.engines.models.urdf import BODY_LINK, urdf
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps
#: Three products and two sums of rotation entries, each entry good to a few ulp.
ROUNDOFF = 16 * EPS
#: Models of rotors are read back by the contract.
RIGID = {name: scene for name, scene in SCENES.items() if not scene.rotors}
PIVOTED = [name for name, scene in RIGID.items() if scene.constraint.is_pivot]
FREE = [name for name, scene in RIGID.items() if scene.constraint.is_free]
ON_A_TABLE = [name for name in RIGID if name not in {*PIVOTED, *FREE}]


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


def relative_misfit(scene: Scenario, inertia_com: np.ndarray) -> float:
    wanted = scene.body.inertia_com
    return float(np.abs(inertia_com - wanted).max() / np.abs(wanted).max())


@each_case("name", [*RIGID])
def test_mass_and_com_are_there_bit_for_bit(name: str) -> None:
    """The com from where the body is held, or else from its origin."""
    scene, held = SCENES[name], read(urdf(SCENES[name]))
    assert held.mass == scene.body.mass
    assert held.com.tolist() == scene.constraint.lever.tolist()


@each_case("name", [*RIGID])
def test_the_tensor_is_the_scenes(name: str) -> None:
    assert relative_misfit(SCENES[name], read(urdf(SCENES[name])).inertia_com) < ROUNDOFF


def test_the_tensor_is_missed_where_the_inertial_frame_is_dropped() -> None:
    scene = SCENES["free-tilted"]
    root = ET.fromstring(urdf(scene))
    origin = root.find("link/inertial/origin")
    assert origin is not None
    origin.set("rpy", "0 0 0")
    held = read(ET.tostring(root, encoding="unicode"))
    assert relative_misfit(scene, held.inertia_com) > 1e9 * ROUNDOFF


@each_case("name", PIVOTED)
def test_a_pivoted_body_hangs_on_the_world_by_a_ball_at_its_origin(name: str) -> None:
    joint = ET.fromstring(urdf(SCENES[name])).find("joint")
    assert joint is not None
    assert joint.attrib["type"] == "spherical"
    assert not numbers(joint.find("origin"), "xyz").any()
    assert not numbers(joint.find("origin"), "rpy").any()
    # Without an axis, readers warn.
    assert joint.find("axis") is not None


@each_case("name", ON_A_TABLE)
def test_a_body_on_a_table_hangs_by_a_ball_at_its_tip_on_slides_without_mass(name: str) -> None:
    root = ET.fromstring(urdf(SCENES[name]))
    joints = [
        (joint.attrib["type"], numbers(joint.find("axis"), "xyz")) for joint in root.iter("joint")
    ]
    assert [kind for kind, _ in joints] == ["prismatic", "prismatic", "spherical"]
    assert np.array_equal([axis for _, axis in joints[:2]], np.eye(3)[:2])
    place = numbers(root.find("joint[@name='pivot']/origin"), "xyz")
    assert place.tolist() == [float(part) for part in SCENES[name].constraint.place_exact]
    slides = root.findall("link")[1:3]
    assert [numbers(link.find("inertial/mass"), "value").item() for link in slides] == [0.0, 0.0]


@each_case("name", FREE)
def test_a_free_body_is_the_only_link(name: str) -> None:
    assert [child.tag for child in ET.fromstring(urdf(SCENES[name]))] == ["link"]


@each_case("name", [*RIGID])
def test_nothing_but_bodies_and_the_pivot_is_written(name: str) -> None:
    tags = {element.tag for element in ET.fromstring(urdf(SCENES[name])).iter()}
    held = set() if SCENES[name].constraint.is_free else {"joint", "parent", "child", "axis"}
    held |= {"limit"} if name in ON_A_TABLE else set()
    assert tags == {"robot", "link", "inertial", "origin", "mass", "inertia"} | held
