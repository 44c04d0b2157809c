"""What the engines hold of a file, on the engines themselves."""

from itertools import product

import numpy as np
import pytest
from case_loops import each_case
from spincheck.engines.model_readers import model_readers
from spincheck.engines.users_models import AGREES, difference, read_model, rigid_bodies
from spincheck.engines.users_models.model_file import RigidBody
from users_models import arm, body, inertial, joint, link, robot, written

pytest.importorskip("pybullet")
EPS = float(np.finfo(float).eps)
READERS = {name: one for name, one in model_readers().items() if not one.is_optional}
BOTH = [(name, c.name) for name, reader in READERS.items() for c in reader.configurations]
TURNED = body(
    '<freejoint/><inertial mass="2" pos="0.1 0 0" euler="30 20 10" diaginertia="0.03 0.04 0.05"/>'
)
FAITHFUL = [
    ("pybullet", "inertia-from-file", arm(), "robot.urdf"),
    ("mujoco", "unfused", arm(), "robot.urdf"),
    ("mujoco", "as-is", TURNED, "robot.xml"),
]
MESH = '<collision><geometry><mesh filename="{}"/></geometry></collision>'


def held(folder, text, who, file="robot.urdf", packages=()):
    engine, configuration = who
    return READERS[engine].read(read_model(written(folder, text, file), packages), configuration)


@each_case(("engine", "configuration", "text", "file"), FAITHFUL)
def test_an_engine_that_is_reported_to_holds_the_files_tensor(
    tmp_path, engine, configuration, text, file
):
    stated = read_model(written(tmp_path, text, file)).link("arm").stated
    arm_body = held(tmp_path, text, (engine, configuration), file)["arm"]
    assert arm_body.mass == 2
    assert np.abs(arm_body.com - [0.1, 0, 0]).max() <= EPS
    assert np.abs(arm_body.inertia_com - stated.inertia_com).max() <= 8 * EPS * 0.05
    # Teeth: without the rotation of its own frame it would be another.
    assert np.abs(arm_body.inertia_com - stated.unturned).max() > 1e-3


@each_case(
    ("who", "mesh"),
    product(BOTH, ["none.stl", "../outside.stl", "package://other/a.stl"]),
)
def test_meshes_that_are_not_there_do_not_matter(tmp_path, who, mesh):
    written(tmp_path, "no mesh at all", "outside.stl")
    text = arm(inside=MESH.format(mesh))
    assert held(tmp_path, text, who, "inner/robot.urdf")["arm"].mass == 2


OBJ = "v 0 0 0\nv 3 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"


def test_a_mesh_in_a_package_is_read_where_pybullet_asks_for_it(tmp_path):
    written(tmp_path, OBJ, "package/mesh.obj")
    text = arm(inside=MESH.format("package://made-up/mesh.obj"))
    packages = (("made-up", tmp_path / "package"),)
    without = held(tmp_path, text, ("pybullet", "default"))["arm"]
    arm_body = held(tmp_path, text, ("pybullet", "default"), packages=packages)["arm"]
    assert np.trace(arm_body.inertia_com) > 1e3 * np.trace(without.inertia_com)


def test_an_mjcfs_missing_meshes_and_textures_do_not_matter(tmp_path):
    assets = (
        '<asset><mesh name="m" file="none.stl"/><texture name="t" file="none.png" type="2d"/>'
        '<material name="o" texture="t"/></asset>'
    )
    text = body(
        '<freejoint/><inertial mass="2" pos="0 0 1" diaginertia="1 2 2.5"/>'
        '<geom type="mesh" mesh="m" material="o"/><site material="o"/>',
        assets,
    )
    assert held(tmp_path, text, ("mujoco", "as-is"), "robot.xml")["arm"].mass == 2


def test_bodies_without_a_name_are_distinguished(tmp_path):
    inner = '<freejoint/><geom size="1"/><body pos="1 0 0"><geom size="2"/></body>'
    text = f"<mujoco><worldbody><body>{inner}</body></worldbody></mujoco>"
    bodies = held(tmp_path, text, ("mujoco", "as-is"), "robot.xml")
    assert bodies["(body 2)"].mass == pytest.approx(8 * bodies["(body 1)"].mass)


def test_replicated_bodies_are_named_as_mujoco_names_them(tmp_path):
    inner = '<freejoint/><geom size="1"/><replicate count="11" sep="-"><body name="k">'
    text = body(f'{inner}<geom size="0.1"/></body></replicate>')
    for named in (text, text.replace(' name="k"', "")):
        names = {one.name for one in read_model(written(tmp_path, named, "robot.xml")).links}
        assert set(held(tmp_path, named, ("mujoco", "as-is"), "robot.xml")) == names


@each_case("sequence", ["zYx", "XYZ"])
def test_replicas_are_where_mujoco_has_them(tmp_path, sequence):
    """Nested ones, which MuJoCo fuses with the arm: their sum is right only if all places are."""
    part = '<inertial pos="0 0 0" mass="1" diaginertia="1 2 2.5"/>'
    inner = f'<body name="k" pos="1 0 0" euler="3 2 1">{part}</body>'
    for step in ('offset="0 0.1 0.2" euler="0.1 0.5 -0.7"', 'euler="9 8 7" sep="-"'):
        copies = f'<replicate count="2" {step}>{inner}</replicate>'
        inner = f'<frame pos="0 1 0" euler="1 1 2">{copies}</frame>'
    compiler = f'<compiler angle="radian" eulerseq="{sequence}" fusestatic="true"/>'
    text = body(f"<freejoint/>{part}{inner}", compiler)
    got = held(tmp_path, text, ("mujoco", "as-is"), "robot.xml")
    (whole,) = rigid_bodies(read_model(tmp_path / "robot.xml").links)
    assert list(got) == ["arm"]
    assert difference(whole.stated, got["arm"]).worst <= AGREES
    # Teeth: with the first pose for all, it is another body.
    (arm_part, first, *others) = whole.parts
    wrong = RigidBody((arm_part, first, *((link, first[1]) for link, _ in others)))
    assert difference(wrong.stated, got["arm"]).worst > 0.1


def test_mujoco_is_given_what_was_checked_and_opens_no_file_of_the_users(tmp_path):
    """Planted: file, include and mesh are others when MuJoCo reads, and name what is elsewhere."""
    written(tmp_path, body('<include file="geom.xml"/>'), "robot.xml")
    inner = '<mujoco><freejoint/><geom type="mesh" mesh="m"/></mujoco>'
    mesh = '<asset><mesh name="m" file="a.obj"/></asset>'
    written(tmp_path, OBJ, "meshes/a.obj")
    compiler = '<compiler meshdir="meshes"/>'
    text = body('<include file="geom.xml"/>', compiler + mesh)
    written(tmp_path, inner, "geom.xml")
    model = read_model(written(tmp_path, text, "robot.xml"))
    elsewhere = written(tmp_path.parent, OBJ.replace("3", "300"), "elsewhere.obj")
    written(tmp_path, text.replace("a.obj", str(elsewhere)), "robot.xml")
    written(tmp_path, inner.replace("<geom", '<geom density="1"'), "geom.xml")
    held_body = READERS["mujoco"].read(model, "as-is")["arm"]
    # A corner of a box of 3 m³, of water.
    assert held_body.mass == pytest.approx(1000 * 3 / 6)


def test_mujoco_reads_a_model_that_a_model_attaches(tmp_path):
    written(tmp_path, body('<geom size="1"/>').replace("arm", "hand"), "hand.xml")
    asset = '<asset><model name="h" file="hand.xml"/></asset>'
    text = body('<freejoint/><geom size="1"/><attach model="h" body="hand" prefix="l-"/>', asset)
    assert set(held(tmp_path, text, ("mujoco", "as-is"), "robot.xml")) == {"arm", "l-hand"}


def test_a_body_without_a_name_is_not_counted_among_those_of_an_attached_model(tmp_path):
    written(tmp_path, body('<body><geom size="3"/></body>').replace("arm", "hand"), "hand.xml")
    asset = '<asset><model name="h" file="hand.xml"/></asset>'
    inner = '<attach model="h" body="hand" prefix="l-"/><body><geom size="2"/></body>'
    text = body(f'<freejoint/><geom size="1"/>{inner}', asset)
    bodies = held(tmp_path, text, ("mujoco", "as-is"), "robot.xml")
    assert bodies["(body 1)"].mass == pytest.approx(8 * bodies["arm"].mass)


def test_nothing_is_written_beside_the_user(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mimic = joint("base", "arm", "floating").replace("<axis", '<mimic joint="x"/><axis')
    text = robot(link("base"), link("arm", inertial()), mimic)
    held(tmp_path, text, ("mujoco", "as-is"), "inner/robot.urdf")
    assert [path.name for path in tmp_path.iterdir()] == ["inner"]
