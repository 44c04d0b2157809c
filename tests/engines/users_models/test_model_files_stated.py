"""What a file states, by hand: mass, com and tensor in the link's frame, and what hangs on what."""

import numpy as np
from case_loops import each_case
from spincheck.engines.users_models import problems, read_model, rigid_bodies
from spincheck.engines.users_models.model_file import Folders
from users_models import body as arm_of_mjcf
from users_models import diagonal, inertial, joint, link, robot, written

EPS = float(np.finfo(float).eps)
QUARTER = f"{np.pi / 2!r}"


def read(folder, text):
    file = "robot.xml" if text.startswith("<mujoco>") else "robot.urdf"
    return read_model(written(folder, text, file))


def stated(folder, text):
    return read(folder, text).link("arm").stated


def of_urdf(origin):
    return robot(link("arm", inertial("2", diagonal(1, 2, 2.5), origin)))


def of_mjcf(rotation, compiler=""):
    return arm_of_mjcf(f'<inertial mass="2" diaginertia="1 2 2.5" {rotation}/>', compiler)


def in_frames(rotation):
    """An `inertial` 3 m along y from the origin of a frame that is turned upside down about z."""
    inner = f'<inertial mass="2" pos="0 3 0" diaginertia="1 2 2.5" {rotation}/>'
    return arm_of_mjcf(f'<frame pos="1 0 0"><frame quat="0 0 0 1">{inner}</frame></frame>')


#: Angles and their sequence are the compiler's.
FIXED_AXES = '<compiler angle="radian" eulerseq="XYZ"/>'
#: Texts, and com and moments that they state. In a URDF roll comes first, about fixed axes: it
#: takes y to z, pitch takes that to x, so that of both the moment 2 ends up along x, 1 along z.
TURNED = [
    (of_urdf(""), [0, 0, 0], [1, 2, 2.5]),
    (of_urdf(f'<origin xyz="1 2 3" rpy="{QUARTER} 0 0"/>'), [1, 2, 3], [1, 2.5, 2]),
    (of_urdf(f'<origin rpy="{QUARTER} {QUARTER} 0"/>'), [0, 0, 0], [2, 2.5, 1]),
    (of_mjcf('quat="1 1 0 0"'), [0, 0, 0], [1, 2.5, 2]),
    (of_mjcf('euler="90 0 0"'), [0, 0, 0], [1, 2.5, 2]),
    (of_mjcf('axisangle="0 0 2 90"'), [0, 0, 0], [2, 1, 2.5]),
    (of_mjcf('xyaxes="0 1 0 -1 0 0"'), [0, 0, 0], [2, 1, 2.5]),
    (of_mjcf('zaxis="0 1 0"'), [0, 0, 0], [1, 2.5, 2]),
    (of_mjcf('zaxis="0 0 -1"'), [0, 0, 0], [1, 2, 2.5]),
    (of_mjcf('euler="90 90 0"'), [0, 0, 0], [2.5, 1, 2]),
    (of_mjcf(f'euler="{QUARTER} {QUARTER} 0"', FIXED_AXES), [0, 0, 0], [2, 2.5, 1]),
    # Vectors of any length.
    (of_mjcf('quat="1e-200 1e-200 0 0"'), [0, 0, 0], [1, 2.5, 2]),
    (of_mjcf('axisangle="0 0 1e-320 90"'), [0, 0, 0], [2, 1, 2.5]),
    (of_mjcf('axisangle="0 0 2 3.6e20"'), [0, 0, 0], [1, 2, 2.5]),
    (of_mjcf('xyaxes="0 1e-200 0 -1e90 1e90 0"'), [0, 0, 0], [2, 1, 2.5]),
    (of_mjcf('zaxis="0 1e-200 0"'), [0, 0, 0], [1, 2.5, 2]),
    (in_frames("zaxis='0 1 0'"), [1, -3, 0], [1, 2.5, 2]),
]


@each_case(("text", "com", "moments"), TURNED)
def test_a_tensor_is_turned_into_the_links_frame(tmp_path, text, com, moments):
    body = stated(tmp_path, text)
    assert (body.mass, body.com.tolist()) == (2, com)
    assert np.abs(body.inertia_com - np.diag(moments)).max() <= 8 * EPS
    assert body.unturned.tolist() == np.diag([1, 2, 2.5]).tolist()


def test_products_of_inertia_are_the_tensors_entries(tmp_path):
    body = stated(tmp_path, robot(link("arm", inertial(origin=""))))
    assert body.inertia_com.tolist() == [[0.03, 0.001, 0], [0.001, 0.04, 0], [0, 0, 0.05]]
    body = stated(tmp_path, arm_of_mjcf('<inertial mass="1" fullinertia="3 4 5 0.1 0.2 0.3"/>'))
    assert body.inertia_com.tolist() == [[3, 0.1, 0.2], [0.1, 4, 0.3], [0.2, 0.3, 5]]


def test_what_an_mjcf_has_from_shapes_it_does_not_state(tmp_path):
    text = arm_of_mjcf(
        '<inertial mass="1" diaginertia="1 1 1"/>', '<compiler inertiafromgeom="true"/>'
    )
    assert stated(tmp_path, text) is None


@each_case(
    ("options", "named"),
    [
        ('boundmass="0.5" settotalmass="-1"', ["boundmass"]),
        ('boundmass="0.0" boundinertia="1e-9" balanceinertia="true"', ["boundinertia", "balance"]),
        ('balanceinertia="false" settotalmass="2"', ["settotalmass"]),
    ],
)
def test_options_by_which_bodies_differ_from_the_file_are_named(tmp_path, options, named):
    notes = read(tmp_path, arm_of_mjcf("", f"<compiler {options}/>")).notes
    assert len(notes) == len(named)
    assert all(f"MuJoCo's option {one}" in note for one, note in zip(named, notes, strict=True))


def test_replicated_bodies_are_there_as_often_as_the_file_says(tmp_path):
    inner = '<replicate count="11"><body name="k"><body name="l"/></body></replicate>'
    model = read(tmp_path, arm_of_mjcf(inner))
    names = [link.name for link in model.links]
    assert names[:3] == ["arm", "k00", "l00"]
    assert names[-1] == "l10"
    assert model.link("l10").parent == "k10"


def test_each_replica_is_moved_and_turned_relative_to_the_one_before(tmp_path):
    """By hand: steps of 1 m along x, and of a quarter turn about z, 5 m above the arm."""
    inner = '<body name="k" pos="0 1 0"><body name="l" pos="0 0 2"/></body>'
    three = f'<replicate count="3" offset="1 0 0" euler="0 0 90">{inner}</replicate>'
    model = read(tmp_path, arm_of_mjcf(f'<frame pos="0 0 5">{three}</frame>'))
    links = [model.link(f"{name}{index}") for name in "kl" for index in range(3)]
    places = [[0, 1, 5], [0, 0, 5], [1, 0, 5]] + 3 * [[0, 0, 2]]
    x_axes = [[1, 0, 0], [0, 1, 0], [-1, 0, 0]] + 3 * [[1, 0, 0]]
    assert np.abs([link.pose.position for link in links] - np.array(places)).max() <= 8 * EPS
    assert np.abs([link.pose.R[:, 0] for link in links] - np.array(x_axes)).max() <= 8 * EPS


@each_case(
    ("inside", "moves"),
    [
        ('<joint type="slide"/>', True),
        ('<frame euler="0 0 30"><joint/></frame>', True),
        ("<frame><frame><joint/></frame></frame>", True),
        ("<frame><freejoint/></frame>", True),
        ('<frame><geom size="1"/></frame>', False),
        # That joint is another body's.
        ('<frame><body name="b"><joint/></body></frame>', False),
    ],
)
def test_a_joint_inside_of_frames_moves_the_body(tmp_path, inside, moves):
    text = arm_of_mjcf(f'<body name="k">{inside}</body>')
    model = read(tmp_path, text)
    assert model.link("k").moves == moves


def test_an_include_of_the_models_folder_is_followed(tmp_path):
    inner = '<mujoco><body name="arm"><inertial mass="3" diaginertia="1 1 1"/></body></mujoco>'
    written(tmp_path, inner, "parts/arm.xml")
    text = '<mujoco><worldbody><include file="parts/arm.xml"/></worldbody></mujoco>'
    assert stated(tmp_path, text).mass == 3


def test_fused_links_are_the_exact_sum_of_their_parts(tmp_path):
    """Two balls on a rod: 2 m d² across it, about the middle (Goldstein, §5.3)."""
    ball = inertial("3", diagonal(0.5, 0.5, 0.5), "")
    origin = f'<origin xyz="0 0 4" rpy="{QUARTER} 0 0"/>'
    text = robot(link("a", ball), link("b", ball), joint("a", "b", "fixed", origin))
    links = read(tmp_path, text).links
    whole = rigid_bodies(links)[0].stated
    assert whole.mass == 6
    assert np.abs(whole.com - [0, 0, 2]).max() <= 8 * EPS
    across = 2 * 0.5 + 2 * 3 * 2**2
    assert np.abs(whole.inertia_com - np.diag([across, across, 1])).max() <= 8 * EPS * across


def test_a_part_without_a_mass_is_no_part(tmp_path):
    nothing = inertial("0", diagonal(7, 7, 7), "")
    origin = '<origin xyz="0 0 4"/>'
    text = robot(link("a", inertial()), link("b", nothing), joint("a", "b", "fixed", origin))
    links = read(tmp_path, text).links
    whole = rigid_bodies(links)[0].stated
    assert np.abs(whole.inertia_com - links[0].stated.inertia_com).max() <= EPS


BOX = '<collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision>'
MESH = '<visual><geometry><mesh filename="a.stl"/></geometry></visual>'
#: Of a shell of that box's shape, of 1 kg: no part is further out than its faces, so that
#: ∫x² dm <= m (w/2)².
MOST = np.array([a**2 + b**2 for a, b in ((0.2, 0.3), (0.1, 0.3), (0.1, 0.2))])
#: kg, of the box made of osmium, with the slack that shapes have.
OSMIUM = 22590.0 * 0.2 * 0.4 * 0.6 * 1.1**3
#: By the words of what is wrong: mass, moments and shapes.
WRONG = {
    "0.1 + 0.3 < 0.9: no body has it": (1, (0.3, 0.1, 0.9), ""),
    "0.001 + 0.001 < 0.002000001: no body has it": (1, (0.001, 0.001, 0.002000001), ""),
    "principal moments must be positive, they are -0.1, 1, 1 kg m²": (1, (-0.1, 1, 1), ""),
    "a tensor without a mass": (0, (1, 1, 1), ""),
    "a mass of 2 kg without a tensor": (2, (0, 0, 0), ""),
    "a mass of -1 kg": (-1, (1, 1, 1), ""),
    "0.001 × identity: a placeholder": (1, (1e-3, 1e-3, 1e-3), ""),
    "its radius of gyration along x is 0.2 m; within its": (2, 8 * MOST, BOX),
    # Next to no mass spreads without end.
    "its radius of gyration": (1e-320, 2 * MOST, BOX),
    f"{1.001 * OSMIUM:g} kg within shapes of 0.2 × 0.4 × 0.6 m are denser than any element, "
    "osmium's 22590 kg/m³: is the mass in grams?": (1.001 * OSMIUM, 1.001 * OSMIUM * MOST, BOX),
    # A flat shape has no density.
    "its radius of gyration along z": (1e9, 1e9 * MOST, BOX.replace("0.6", "0")),
}
WELL = {
    "flat": (1, (1, 2, 3), ""),
    "flat but for rounding": (1, (0.1, 0.2, 0.30000000000000004), ""),
    "a ball": (1, (0.002, 0.002, 0.002), ""),
    "a frame": (0, (0, 0, 0), ""),
    "at the shapes' corners": (2, 2 * MOST, BOX),
    "at those it is drawn with": (2, 2 * MOST, BOX.replace("collision", "visual")),
    "a mesh may be of any size": (2, (9, 9, 9), BOX + MESH),
    "less dense": (0.999 * OSMIUM, 0.999 * OSMIUM * MOST, BOX),
}
DOUBTS = ("placeholder", "radius of gyration", "density")


@each_case(("words", "stated_as"), [*WRONG.items(), *((None, one) for one in WELL.values())])
def test_what_a_file_has_wrong_is_reported(tmp_path, words, stated_as):
    mass, moments, shapes = stated_as
    inside = inertial(repr(mass), diagonal(*map(float, moments)), "") + shapes
    (arm,) = read(tmp_path, robot(link("a", inside))).links
    assert [one.text.startswith(words or "?") for one in problems(arm)] == [True] * bool(words)
    assert all(one.impossible == (one.kind not in DOUBTS) for one in problems(arm))


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
