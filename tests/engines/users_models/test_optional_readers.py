"""What the importers of Genesis and Newton hold of a file; each skipped if not installed."""

from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from spincheck.engines import EngineError
from spincheck.engines.model_readers import model_readers
from spincheck.engines.users_models import AGREES, difference, read_model
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.users_models.inspection import inspect_model, reader_engines
from users_models import arm, arm_with_a_tool, body, diagonal, inertial, joint, link, robot, written

pytestmark = pytest.mark.slow

SPHERE = '<collision><geometry><sphere radius="1"/></geometry></collision>'
OTHER_ANGLES = '<compiler angle="radian" eulerseq="zXy"/>'


def turned(how: str, after: str = "", compiler: str = "", tensor: str = "0.03 0.04 0.05") -> str:
    """A free body of an MJCF, its tensor along axes that an attribute turns."""
    stated = f'<inertial mass="2" pos="0.1 0 0" {how} diaginertia="{tensor}"/>'
    return body(f"<freejoint/>{stated}{after}", compiler)


def held(
    folder: Path,
    text: str,
    configuration: str = "as-is",
    file: str = "robot.urdf",
    reader: str = "newton",
):
    installed(reader)
    return model_readers()[reader].read(read_model(written(folder, text, file)), configuration)


BALL = '<geom size="1"/>'


@each_case(
    ("reader", "file", "text"),
    [
        ("genesis", "robot.urdf", arm()),
        # By default Genesis moves a free body's frame to its principal axes.
        ("genesis", "robot.xml", turned('euler="30 20 10"', BALL)),
        ("genesis", "robot.xml", turned('euler="30 20 10"', BALL, '<compiler eulerseq="zXy"/>')),
        ("newton", "robot.urdf", arm()),
        ("newton", "robot.urdf", arm(inside=SPHERE)),
        ("newton", "robot.xml", turned('euler="30 20 10"')),
        ("newton", "robot.xml", turned('zaxis="1 2 3"', BALL)),
        ("newton", "robot.xml", turned('euler="0.3 0.2 0.1"', compiler=OTHER_ANGLES)),
    ],
)
def test_a_turned_tensor_is_held_as_the_file_states_it(tmp_path, reader, file, text):
    got = held(tmp_path, text, file=file, reader=reader)["arm"]
    stated = read_model(written(tmp_path, text, file)).link("arm").stated
    assert difference(stated, got).worst <= AGREES
    # Teeth: without the rotation of its own frame it would be another.
    assert np.abs(stated.unturned - stated.inertia_com).max() > 100 * AGREES * 0.05


def test_bodies_are_found_by_names_that_newton_changes(tmp_path):
    inner = '<freejoint/><geom size="1"/><body pos="1 0 0"><joint/><geom size="2"/></body>'
    text = f'<mujoco><worldbody><body name="left-arm">{inner}</body></worldbody></mujoco>'
    bodies = held(tmp_path, text, file="robot.xml")
    assert bodies["(body 1)"].mass == pytest.approx(8 * bodies["left-arm"].mass)
    text = robot(link("a"), link("b/a", inertial()), joint("a", "b/a"))
    assert held(tmp_path, text)["b/a"].mass == 2


@each_case(
    ("reader", "file", "text", "words"),
    [
        ("genesis", "robot.urdf", arm(diagonal(0.01, 0.01, 0.05)), r"A\+B>=C"),
        ("newton", "robot.xml", turned("", tensor="0.03 0.04 0.5"), r"A \+ B >= C"),
    ],
)
def test_a_file_that_it_refuses_is_reported(tmp_path, reader, file, text, words):
    refusal = f"{reader.capitalize()} refuses the file: .*{words}"
    with pytest.raises(EngineError, match=refusal) as refused:
        held(tmp_path, text, file=file, reader=reader)
    assert "/tmp" not in str(refused.value)


def test_welded_links_are_summed_by_genesis_and_kept_apart(tmp_path):
    installed("genesis")
    model = read_model(written(tmp_path, arm_with_a_tool()))
    found = inspect_model(model, InProcess(), reader_engines(["genesis"]))
    assert found.is_well
    (arm_held,) = (one for one in found.links if one.link.name == "arm")
    assert [one.fused for one in arm_held.readings] == [("tool",), ()]


def test_collapsed_links_have_a_wrong_sum_of_tensors(tmp_path):
    """A fault of 1.8.0; when this fails, docs/measured/known-issues.toml has to say since when.

    The tool's tensor is shifted by the distance of the links' origins, the arm's by nothing, where
    both should be by the distance of their com from the whole's.
    """
    installed("newton")
    model = read_model(written(tmp_path, arm_with_a_tool()))
    links = inspect_model(model, InProcess(), reader_engines(["newton"])).links
    (arm_held,) = (one for one in links if one.link.name == "arm")
    as_is, collapsed = arm_held.readings
    assert as_is.agrees
    assert (collapsed.kind, collapsed.fused) == ("sum", ("tool",))
    tool, p = model.link("tool"), model.link("tool").pose.position
    shifted = tool.stated.mass * (p @ p * np.eye(3) - np.outer(p, p))
    turned_tool = tool.pose.R @ tool.stated.inertia_com @ tool.pose.R.T
    wrong = model.link("arm").stated.inertia_com + turned_tool + shifted
    assert np.linalg.norm(collapsed.body.inertia_com - wrong) <= AGREES * np.linalg.norm(wrong)


def test_small_tensors_are_made_larger(tmp_path):
    """A fault of 1.8.0: a moment below 1e-10 kg m² gets 1e-6 kg m² more (`inertia_correction`)."""
    text = arm(diagonal(1e-11, 2e-11, 2.5e-11), mass="1e-3")
    got = held(tmp_path, text)["arm"].inertia_com
    assert np.linalg.eigvalsh(got) == pytest.approx(1e-6, rel=1e-3)
    # The next larger power of ten is kept.
    text = arm(diagonal(1e-9, 2e-9, 2.5e-9), mass="1e-3")
    assert np.trace(held(tmp_path, text)["arm"].inertia_com) == pytest.approx(5.5e-9)


def test_what_mjcf_says_of_shells_and_copies_is_left_out(tmp_path):
    """Faults of 1.8.0: `shellinertia` and `replicate` are passed over without a word."""
    shell = body('<freejoint/><geom size="0.1" shellinertia="true"/>')
    solid = body('<freejoint/><geom size="0.1"/>')
    one, other = (held(tmp_path, text, file="robot.xml")["arm"] for text in (shell, solid))
    assert one.mass == other.mass
    copies = '<replicate count="2"><body name="k"><geom size="1"/></body></replicate>'
    text = body(f'<freejoint/><geom size="1"/>{copies}')
    assert list(held(tmp_path, text, file="robot.xml")) == ["arm"]


#: Two bodies welded together, Z up; `{}` makes them an articulation, or says other units.
WELDED = """#usda 1.0
(
    upAxis = "{up}"
    metersPerUnit = {metre}
)
def Xform "World" ({articulation})
{{
    def Xform "arm" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
    )
    {{
        {stated}
    }}
    def Xform "tool" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
    )
    {{
        {stated}
        double3 xformOp:translate = (0, 0, 1)
        quatf xformOp:orient = (0.8, 0.6, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]
    }}
    def PhysicsFixedJoint "weld"
    {{
        rel physics:body0 = </World/arm>
        rel physics:body1 = </World/tool>
        point3f physics:localPos0 = (0, 0, 1)
        quatf physics:localRot0 = (0.8, 0.6, 0, 0)
    }}
}}
"""
MASS = """float physics:mass = 2
        point3f physics:centerOfMass = (0.1, 0, 0)
        float3 physics:diagonalInertia = (0.03, 0.04, 0.05)
        quatf physics:principalAxes = (0.9, 0.1, 0.3, 0.2)"""
ARTICULATION = '\n    prepend apiSchemas = ["PhysicsArticulationRootAPI"]\n'


def usd(up: str = "Z", articulation: str = ARTICULATION, metre: float = 1.0) -> str:
    return WELDED.format(up=up, metre=metre, articulation=articulation, stated=MASS)


@pytest.fixture
def _openusd():
    pytest.importorskip("pxr", reason="OpenUSD is not installed")
    pytest.importorskip("newton_usd_schemas", reason="newton[importers] is not installed")


@pytest.mark.usefixtures("_openusd")
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_usds_bodies_are_held_as_the_file_states_them(tmp_path, up):
    model = read_model(written(tmp_path, usd(up), "robot.usda"))
    bodies = held(tmp_path, usd(up), file="robot.usda")
    for link_read in model.links:
        assert difference(link_read.stated, bodies[link_read.name]).worst <= AGREES
    # Teeth: without the principal axes it would be another.
    assert np.abs(link_read.stated.unturned - link_read.stated.inertia_com).max() > 1e-3


@pytest.mark.usefixtures("_openusd")
def test_units_of_a_usd_file_are_left_out(tmp_path):
    """A fault of 1.8.0, which warns of it: a tensor in kg cm² is held as one in kg m²."""
    model = read_model(written(tmp_path, usd(metre=0.01), "robot.usda"))
    got = held(tmp_path, usd(metre=0.01), file="robot.usda")["/World/arm"]
    assert np.trace(got.inertia_com) == pytest.approx(
        1e4 * np.trace(model.links[0].stated.inertia_com)
    )


@pytest.mark.usefixtures("_openusd")
def test_joints_of_a_usd_file_without_an_articulation_are_turned_with_the_world(tmp_path):
    """A fault of 1.8.0: their frames in the body are turned as the stage is, if Y is up there."""
    coms = {
        (up, whole): held(
            tmp_path, usd(up, ARTICULATION if whole else ""), "collapsed", "robot.usda"
        )["/World/arm"].com
        for up in "YZ"
        for whole in (True, False)
    }
    right = [0.1, 0.0, 0.5]
    assert all(np.allclose(coms[one], right, atol=1e-6) for one in coms if one != ("Y", False))
    assert np.allclose(coms["Y", False], [0.1, -0.5, 0.0], atol=1e-6)
