"""What a USD file states, and files that are refused; skipped where OpenUSD is not installed."""

import numpy as np
import pytest
from case_loops import each_case
from spincheck.engines.users_models import ModelFileError, read_model, rigid_bodies
from users_models import written

pytest.importorskip("pxr", reason="OpenUSD is not installed")

BODY = """#usda 1.0
(
    metersPerUnit = {metre}
    kilogramsPerUnit = {kilogram}
)
def Xform "arm" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
)
{{
    {inside}
}}
{after}
"""
STATED = """float physics:mass = 2
    point3f physics:centerOfMass = (0.1, 0, 0)
    float3 physics:diagonalInertia = (0.03, 0.04, 0.05)
    quatf physics:principalAxes = (0.5, 0.5, 0.5, 0.5)"""
TOOL = """def Xform "tool" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
)
{
    float physics:mass = 1
    point3f physics:centerOfMass = (0, 0, 0)
    float3 physics:diagonalInertia = (0.01, 0.01, 0.01)
}
def Physics%sJoint "joint"
{
    rel physics:body0 = </arm>
    rel physics:body1 = </tool>
    point3f physics:localPos0 = (0, 0, 1)
    point3f physics:localPos1 = (0, 0, -1)
}
"""
SCALED = """
    double3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = ["xformOp:scale"]"""


def model(folder, inside=STATED, after="", metre=1.0, kilogram=1.0):
    text = BODY.format(inside=inside, after=after, metre=metre, kilogram=kilogram)
    return read_model(written(folder, text, "robot.usda"))


def test_principal_axes_turn_the_tensor(tmp_path):
    stated = model(tmp_path).link("/arm").stated
    # This quaternion takes x to y, y to z and z to x.
    assert stated.mass == 2
    assert np.allclose(stated.inertia_com, np.diag([0.05, 0.03, 0.04]))
    assert np.allclose(stated.unturned, np.diag([0.03, 0.04, 0.05]))


def test_units_and_scales_are_applied(tmp_path):
    stated = model(tmp_path, STATED + SCALED, metre=0.01, kilogram=0.001).link("/arm").stated
    assert stated.mass == pytest.approx(0.002)
    assert stated.com == pytest.approx([0.002, 0, 0])
    assert np.trace(stated.inertia_com) == pytest.approx(0.12e-7)


@pytest.mark.parametrize("without", ["mass", "centerOfMass", "diagonalInertia"])
def test_what_is_to_be_computed_from_shapes_is_not_stated(tmp_path, without):
    inside = "\n".join(line for line in STATED.splitlines() if without not in line)
    link = model(tmp_path, inside).link("/arm")
    assert link.stated is None
    assert link.by_shapes


@pytest.mark.parametrize(("kind", "bodies"), [("Fixed", 1), ("Revolute", 2)])
def test_fixed_joints_weld(tmp_path, kind, bodies):
    read = model(tmp_path, after=TOOL % kind)
    whole = rigid_bodies(read.links)
    assert len(whole) == bodies
    if bodies == 1:
        # The tool's joint is 1 m below its origin, which is so 2 m above the arm's.
        assert whole[0].stated.com == pytest.approx([0.2 / 3, 0, 2 / 3])


RING = BODY.format(inside=STATED, metre=1, kilogram=1, after=TOOL % "Fixed")
REFUSED = {
    "USD is read as text": "PXR-USDC",
    "no USD: ": "#usda 1.0\ndef X",
    "no prim has PhysicsRigidBodyAPI": "#usda 1.0\n",
    "made of other files too, such as '/etc/other.usda'": (
        "#usda 1.0\n(\n    subLayers = [@/etc/other.usda@]\n)\n"
    ),
    "joints form a ring at '/tool'": RING.replace("body0 = </arm>", "body0 = </tool>"),
}


@each_case(("words", "text"), [*REFUSED.items()])
def test_files_that_are_refused(tmp_path, words, text):
    with pytest.raises(ModelFileError) as refused:
        read_model(written(tmp_path, text, "robot.usda"))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
