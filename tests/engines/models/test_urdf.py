"""The URDF holds the scene's body, bit for bit, and nothing else but what holds it.

That engines hold, by it, the body where the scene holds it is verified by the contract.
"""

import xml.etree.ElementTree as ET

import numpy as np
from case_loops import each_case
from scipy.spatial.transform import Rotation
from spincheck.engines.checks.read_back import BodyReading
from spincheck.engines.models.urdf import BODY_LINK, urdf
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps
#: Three products and two sums of rotation entries, each entry good to a few ulp.
ROUNDOFF = 16 * EPS
#: Models of rotors are read back by the contract.
RIGID = {name: scene for name, scene in SCENES.items() if not scene.rotors}


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


@each_case("name", [*RIGID])
def test_mass_and_com_are_there_bit_for_bit_and_the_tensor_to_rounding(name: str) -> None:
    """The com from where the body is held, or else from its origin."""
    scene, held = SCENES[name], read(urdf(SCENES[name]))
    assert held.mass == scene.body.mass
    assert held.com.tolist() == scene.constraint.lever.tolist()
    wanted = scene.body.inertia_com
    assert np.abs(held.inertia_com - wanted).max() < ROUNDOFF * np.abs(wanted).max()


@each_case("name", [*RIGID])
def test_nothing_but_bodies_and_the_pivot_is_written(name: str) -> None:
    tags = {element.tag for element in ET.fromstring(urdf(SCENES[name])).iter()}
    held = set() if SCENES[name].constraint.is_free else {"joint", "parent", "child", "axis"}
    held |= {"limit"} if "table" in SCENES[name].called_for else set()
    assert tags == {"robot", "link", "inertial", "origin", "mass", "inertia"} | held
