"""What a file states, by hand: mass, com and tensor in the link's frame, and what hangs on what."""

import numpy as np
import pytest
from spincheck.engines.users_models import problems, read_model, rigid_bodies
from spincheck.engines.users_models.model_file import Folders
from users_models import TENSOR, body, diagonal, inertial, joint, link, robot, written

EPS = float(np.finfo(float).eps)
QUARTER = f"{np.pi / 2!r}"


def stated(folder, text, name="arm", file="robot.urdf"):
    return read_model(written(folder, text, file)).link(name).stated


def test_a_urdfs_tensor_is_turned_by_rpy_into_the_links_frame(tmp_path):
    turned = f'<origin xyz="1 2 3" rpy="{QUARTER} 0 0"/>'
    bodies = stated(tmp_path, robot(link("arm", inertial("2", diagonal(1, 2, 2.5), turned))))
    assert bodies.mass == 2
    assert bodies.com.tolist() == [1, 2, 3]
    assert np.abs(bodies.inertia_com - np.diag([1, 2.5, 2])).max() <= 8 * EPS
    assert bodies.unturned.tolist() == np.diag([1, 2, 2.5]).tolist()


def test_rpy_turns_about_fixed_axes_roll_first(tmp_path):
    turned = f'<origin rpy="{QUARTER} {QUARTER} 0"/>'
    bodies = stated(tmp_path, robot(link("arm", inertial("2", diagonal(1, 2, 2.5), turned))))
    # Roll takes y to z, pitch takes that to x: the moment 2 ends up along x, 1 along z.
    assert np.abs(bodies.inertia_com - np.diag([2, 2.5, 1])).max() <= 8 * EPS


def test_products_of_inertia_are_the_tensors_entries(tmp_path):
    bodies = stated(tmp_path, robot(link("arm", inertial(origin=""))))
    assert bodies.inertia_com.tolist() == [[0.03, 0.001, 0], [0.001, 0.04, 0], [0, 0, 0.05]]
    assert 'ixy="0.001"' in TENSOR


@pytest.mark.parametrize(
    ("rotation", "moments"),
    [
        ('quat="1 1 0 0"', [1, 2.5, 2]),
        ('euler="90 0 0"', [1, 2.5, 2]),
        ('axisangle="0 0 2 90"', [2, 1, 2.5]),
        ('xyaxes="0 1 0 -1 0 0"', [2, 1, 2.5]),
        ('zaxis="0 1 0"', [1, 2.5, 2]),
        ('zaxis="0 0 -1"', [1, 2, 2.5]),
        ('euler="90 90 0"', [2.5, 1, 2]),
    ],
)
def test_an_mjcfs_tensor_is_turned_in_each_of_its_ways(tmp_path, rotation, moments):
    text = body(f'<inertial mass="1" diaginertia="1 2 2.5" {rotation}/>')
    bodies = stated(tmp_path, text, file="robot.xml")
    assert np.abs(bodies.inertia_com - np.diag(moments)).max() <= 8 * EPS


def test_an_mjcfs_angles_and_sequence_are_its_compilers(tmp_path):
    compiler = '<compiler angle="radian" eulerseq="XYZ"/>'
    text = body(
        f'<inertial mass="1" diaginertia="1 2 2.5" euler="{QUARTER} {QUARTER} 0"/>', compiler
    )
    bodies = stated(tmp_path, text, file="robot.xml")
    assert np.abs(bodies.inertia_com - np.diag([2, 2.5, 1])).max() <= 8 * EPS


def test_an_mjcfs_full_tensor_is_in_its_own_order(tmp_path):
    text = body('<inertial mass="1" fullinertia="3 4 5 0.1 0.2 0.3"/>')
    bodies = stated(tmp_path, text, file="robot.xml")
    assert bodies.inertia_com.tolist() == [[3, 0.1, 0.2], [0.1, 4, 0.3], [0.2, 0.3, 5]]


def test_what_an_mjcf_has_from_shapes_it_does_not_state(tmp_path):
    text = body('<inertial mass="1" diaginertia="1 1 1"/>', '<compiler inertiafromgeom="true"/>')
    assert stated(tmp_path, text, file="robot.xml") is None


def test_replicated_bodies_are_there_as_often_as_the_file_says(tmp_path):
    inner = '<replicate count="11"><body name="k"><body name="l"/></body></replicate>'
    model = read_model(written(tmp_path, body(inner), "robot.xml"))
    names = [link.name for link in model.links]
    assert names[:3] == ["arm", "k00", "l00"]
    assert names[-1] == "l10"
    assert model.link("l10").parent == "k10"


def test_an_include_of_the_models_folder_is_followed(tmp_path):
    inner = '<mujoco><body name="arm"><inertial mass="3" diaginertia="1 1 1"/></body></mujoco>'
    written(tmp_path, inner, "parts/arm.xml")
    text = '<mujoco><worldbody><include file="parts/arm.xml"/></worldbody></mujoco>'
    assert stated(tmp_path, text, file="robot.xml").mass == 3


def test_fused_links_are_the_exact_sum_of_their_parts(tmp_path):
    """Two balls on a rod: 2 m d² across it, about the middle (Goldstein, §5.3)."""
    ball = inertial("3", diagonal(0.5, 0.5, 0.5), "")
    origin = f'<origin xyz="0 0 4" rpy="{QUARTER} 0 0"/>'
    text = robot(link("a", ball), link("b", ball), joint("a", "b", "fixed", origin))
    links = read_model(written(tmp_path, text)).links
    whole = rigid_bodies(links)[0].stated
    assert whole.mass == 6
    assert np.abs(whole.com - [0, 0, 2]).max() <= 8 * EPS
    across = 2 * 0.5 + 2 * 3 * 2**2
    assert np.abs(whole.inertia_com - np.diag([across, across, 1])).max() <= 8 * EPS * across


def test_a_part_without_a_mass_is_no_part(tmp_path):
    nothing = inertial("0", diagonal(7, 7, 7), "")
    origin = '<origin xyz="0 0 4"/>'
    text = robot(link("a", inertial()), link("b", nothing), joint("a", "b", "fixed", origin))
    links = read_model(written(tmp_path, text)).links
    whole = rigid_bodies(links)[0].stated
    assert np.abs(whole.inertia_com - links[0].stated.inertia_com).max() <= EPS


PROBLEMS = {
    "triangle inequality": (("1", diagonal(0.3, 0.1, 0.9)), "0.1 + 0.3 < 0.9: no body has it"),
    "not positive definite": (
        ("1", diagonal(-0.1, 1, 1)),
        "principal moments must be positive, they are -0.1, 1, 1 kg m²",
    ),
    "zero mass": (("0", diagonal(1, 1, 1)), "a tensor without a mass"),
    "zero tensor": (("2", diagonal(0, 0, 0)), "a mass of 2 kg without a tensor"),
    "negative mass": (("-1", diagonal(1, 1, 1)), "a mass of -1 kg"),
    "placeholder": (
        ("1", diagonal(1e-3, 1e-3, 1e-3)),
        "0.001 × identity: a placeholder",
    ),
}


@pytest.mark.parametrize("kind", PROBLEMS)
def test_what_a_file_has_wrong_is_reported(tmp_path, kind):
    inertial_arguments, words = PROBLEMS[kind]
    (problem,) = problems(
        read_model(written(tmp_path, robot(link("a", inertial(*inertial_arguments))))).links[0]
    )
    assert (problem.kind, problem.text) == (kind, words)
    assert problem.impossible == (kind != "placeholder")


@pytest.mark.parametrize(
    ("mass", "tensor"),
    [
        ("1", diagonal(1, 2, 3)),
        ("1", diagonal(0.1, 0.2, 0.30000000000000004)),
        ("1", diagonal(0.002, 0.002, 0.002)),
        ("0", diagonal(0, 0, 0)),
    ],
    ids=["flat", "flat but for rounding", "a ball", "a frame"],
)
def test_what_a_body_can_have_is_not(tmp_path, mass, tensor):
    (arm,) = read_model(written(tmp_path, robot(link("a", inertial(mass, tensor))))).links
    assert problems(arm) == ()


def test_a_violation_in_the_last_digits_is_shown_with_them(tmp_path):
    tensor = diagonal(0.001, 0.001, 0.002000001)
    (arm,) = read_model(written(tmp_path, robot(link("a", inertial("1", tensor))))).links
    (problem,) = problems(arm)
    assert problem.text == "0.001 + 0.001 < 0.002000001: no body has it"


def shaped(moments, shape):
    inside = inertial("2", diagonal(*moments), "") + shape
    return robot(link("a", inside))


BOX = '<collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision>'
#: Of a shell of that box's shape no part is further out than its faces: ∫x² dm <= m (w/2)².
MOST = tuple(2 * (a**2 + b**2) for a, b in ((0.2, 0.3), (0.1, 0.3), (0.1, 0.2)))


def test_mass_that_spreads_further_than_the_shapes_is_doubted(tmp_path):
    twice = tuple(4 * moment for moment in MOST)
    (problem,) = problems(read_model(written(tmp_path, shaped(twice, BOX))).links[0])
    assert problem.kind == "radius of gyration"
    assert not problem.impossible
    assert "within its shapes" in problem.text


def test_next_to_no_mass_spreads_without_end(tmp_path):
    text = shaped(MOST, BOX).replace('value="2"', 'value="1e-320"')
    assert [p.kind for p in problems(read_model(written(tmp_path, text)).links[0])] == [
        "radius of gyration"
    ]


@pytest.mark.parametrize("shape", [BOX, BOX.replace("collision", "visual")])
def test_mass_at_the_shapes_corners_is_not(tmp_path, shape):
    assert problems(read_model(written(tmp_path, shaped(MOST, shape))).links[0]) == ()


def heavy(kilograms, shape=BOX):
    """A robot whose one link has that mass, spread as far as BOX allows."""
    moments = (kilograms / 2 * moment for moment in MOST)
    return shaped(moments, shape).replace('value="2"', f'value="{kilograms!r}"')


#: kg, of the box BOX made of osmium, with the slack that shapes have.
OSMIUM = 22590.0 * 0.2 * 0.4 * 0.6 * 1.1**3


def test_a_mass_denser_than_any_element_is_doubted(tmp_path):
    (problem,) = problems(read_model(written(tmp_path, heavy(1.001 * OSMIUM))).links[0])
    assert (problem.kind, problem.impossible) == ("density", False)
    assert problem.text.endswith("is the mass in grams?")
    assert problems(read_model(written(tmp_path, heavy(0.999 * OSMIUM))).links[0]) == ()


def test_the_density_of_a_flat_shape_is_not_judged(tmp_path):
    flat = BOX.replace("0.6", "0")
    (problem,) = problems(read_model(written(tmp_path, heavy(1e9, flat))).links[0])
    assert problem.kind == "radius of gyration"


def test_a_mesh_may_be_of_any_size(tmp_path):
    mesh = '<visual><geometry><mesh filename="a.stl"/></geometry></visual>'
    assert problems(read_model(written(tmp_path, shaped((9, 9, 9), BOX + mesh))).links[0]) == ()


def test_a_mesh_is_found_in_the_models_folder_and_in_packages_alone(tmp_path):
    for name in ("own/a.stl", "package/b.stl", "outside.stl"):
        written(tmp_path, "solid", name)
    folders = Folders(tmp_path / "own", (("made-up", tmp_path / "package"),))
    assert folders.find("a.stl") == tmp_path / "own/a.stl"
    assert folders.find("package://made-up/b.stl") == tmp_path / "package/b.stl"
    assert folders.find("../package/b.stl") == tmp_path / "package/b.stl"
    outside = str(tmp_path / "outside.stl")
    for name in ("../outside.stl", outside, "package://made-up/../outside.stl", "file://a.stl"):
        assert folders.find(name) is None, name


def test_a_package_is_found_above_the_file(tmp_path):
    written(tmp_path, "<package/>", "robots/package.xml")
    written(tmp_path, "solid", "robots/meshes/a.stl")
    folders = Folders(tmp_path / "robots/urdf")
    assert folders.find("package://robots/meshes/a.stl") == tmp_path / "robots/meshes/a.stl"
    assert folders.find("package://other/meshes/a.stl") is None
