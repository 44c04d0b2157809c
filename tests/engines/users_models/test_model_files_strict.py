"""Files that parsers or engines do not read alike are refused, with file, line and element."""

import os

import pytest
from case_loops import each_case
from spincheck.engines.users_models import ModelFileError, read_model
from spincheck.engines.users_models.xml_tree import (
    MAX_ATTRIBUTES,
    MAX_DEPTH,
    MAX_ELEMENTS,
    MAX_NAME,
)
from spincheck.scenarios.regular_files import LARGEST_MODEL
from users_models import arm, body, diagonal, inertial, joint, link, robot, written

MANY_ATTRIBUTES = " ".join(f'a{k}=""' for k in range(MAX_ATTRIBUTES + 1))


def refusal(path):
    with pytest.raises(ModelFileError) as caught:
        read_model(path)
    message = str(caught.value)
    assert "\n" not in message
    return message.replace(str(path), "FILE")


def test_a_file_larger_than_any_model_is_refused(tmp_path):
    path = tmp_path / "huge.urdf"
    with path.open("wb") as file:
        file.truncate(LARGEST_MODEL + 1)
    message = f"FILE: too large for a model, the limit is {LARGEST_MODEL} bytes"
    assert refusal(path) == message


def test_a_pipe_is_not_waited_for(tmp_path):
    path = tmp_path / "pipe.urdf"
    os.mkfifo(path)
    assert refusal(path) == "FILE: cannot be read: it is not a regular file"


def test_a_file_that_is_not_there_is_reported(tmp_path):
    message = "FILE: cannot be read: No such file or directory"
    assert refusal(tmp_path / "none.urdf") == message


def test_a_version_of_xml_that_there_is_not_is_read_as_engines_read_it(tmp_path):
    model = read_model(written(tmp_path, '<?xml version="0.0" ?>\n' + arm()))
    assert [link.name for link in model.links] == ["base", "arm"]


MESH_OUTSIDE = '<collision><geometry><mesh filename="../outside.stl"/></geometry></collision>'
SCALED = '<contact>\n<inertia_scaling value="3.0"/></contact>'
FROM_SHAPES = '<mujoco><compiler inertiafromgeom="{}"/></mujoco>'
BROKEN = "this XML declaration breaks the standard; engines read over it, standard parsers refuse"
#: Texts, and what is noted about them.
NOTED = [
    ('<!-- x -->\n<?xml version="1.0"?>\n' + arm(), f"FILE:2: {BROKEN}"),
    ('\n<?xml encoding="none" version="1.0"?>\n' + arm(), f"FILE:2: {BROKEN}"),
    (robot(link("a"), "<sensor:camera/>"), "FILE:3: the prefix of <sensor:camera> is not"),
    (robot(link("a"), '<s:camera xmlns:s="urn:s"/>'), None),
    (
        robot(link("a", inertial() + SCALED)),
        "FILE:3: Bullet multiplies the tensor of <link name='a'> by this <inertia_scaling>; no "
        "other engine does",
    ),
    (
        robot(FROM_SHAPES.format("true"), link("a")),
        "FILE:2: MuJoCo's option inertiafromgeom='true' computes masses and tensors from shapes; ",
    ),
    (robot(FROM_SHAPES.format("auto"), link("a")), None),
    (
        robot(link("a", MESH_OUTSIDE)),
        "FILE: 1 of 1 collision meshes are not inside the model's folders, the first is "
        "'../outside.stl'; stated inertia needs none, what PyBullet makes up by default does; "
        "'--package-path NAME=DIR' says where they are",
    ),
]


@each_case(("text", "note"), NOTED)
def test_what_is_odd_about_a_file_is_noted(tmp_path, text, note):
    written(tmp_path, "solid", "outside.stl")
    path = written(tmp_path, text, "inner/robot.urdf")
    model = read_model(path)
    notes = [one.replace(str(path), "FILE") for one in model.notes]
    assert [one.startswith(note or "?") for one in notes] == [True] * bool(note)
    # A declaration that is read over moves nothing in the file.
    start, end = model.links[-1].span
    assert model.data[start:end].startswith(b"<link name=")
    assert model.data[start:end].endswith((b"/>", b"</link>"))


def test_a_link_of_the_file_system_leads_no_further(tmp_path):
    outside = written(tmp_path, "<mujoco/>", "outside.xml")
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner/inside.xml").symlink_to(outside)
    path = written(tmp_path, '<mujoco><include file="inside.xml"/></mujoco>', "inner/robot.xml")
    assert "there is no such file inside the model's folder" in refusal(path)


#: Counts of nothing, bodies, shapes, a cloth and a grid.
NOTHING = '<replicate count="5000"><replicate count="5000"/></replicate>'
NESTED = [
    NOTHING,
    '<replicate count="100"><replicate count="100"><body/></replicate></replicate>',
    '<replicate count="60"><frame><replicate count="60"><geom/></replicate></frame></replicate>',
    '<replicate count="9"><composite type="cloth" count="99 99 1"/></replicate>',
    '<flexcomp name="x" type="grid" count="999 999 999" dim="3"/>',
]


@each_case("inner", NESTED)
def test_what_counts_make_is_bounded_as_a_product(tmp_path, inner):
    message = refusal(written(tmp_path, body(inner), "robot.xml"))
    assert "makes more than 4096 elements, nested ones too" in message


#: What a model attaches: models that attach themselves or each other, too many, or no MJCF.
ATTACHED = {
    "a URDF": ({"robot.xml": ("b.xml", ""), "b.xml": None}, "<model> must name an MJCF file, got"),
    "itself": ({"robot.xml": ("robot.xml", "")}, "<model> attaches itself"),
    "each other": ({"robot.xml": ("b.xml", ""), "b.xml": ("robot.xml", "")}, "<model> attaches"),
    "twice and twice again": (
        {f"{k}.xml".replace("0.", "robot."): (f"{k + 1}.xml", "<body/>") for k in range(14)},
        "<attach> makes more than 4096 elements, nested ones too",
    ),
    "a bomb": (
        {"robot.xml": ("b.xml", ""), "b.xml": ("c.xml", NOTHING)},
        "makes more than 4096 elements",
    ),
}


@each_case(("files", "words"), ATTACHED)
def test_what_attached_models_make_is_bounded(tmp_path, files, words):
    for name, file in files.items():
        if file is None:
            written(tmp_path, arm(), name)
            continue
        attached, inside = file
        asset = f'<asset><model name="m" file="{attached}"/></asset>'
        written(tmp_path, body(2 * '<attach model="m" body="arm"/>' + inside, asset), name)
        if attached not in files:
            written(tmp_path, body("<geom/>"), attached)
    assert words in refusal(tmp_path / "robot.xml")


def test_includes_within_includes_nest_no_deeper_than_a_file_may(tmp_path):
    for k in range(4):
        deep = "<body>" * 100 + f'<include file="{k + 1}.xml"/>' + "</body>" * 100
        inner = deep if k < 3 else "<body/>"
        written(tmp_path, f"<mujoco>{inner}</mujoco>", f"{k}.xml")
    path = written(
        tmp_path, '<mujoco><worldbody><include file="0.xml"/></worldbody></mujoco>', "robot.xml"
    )
    with pytest.raises(ModelFileError, match="nest them more than 256 deep"):
        read_model(path)


def test_replicates_beside_each_other_are_a_sum(tmp_path):
    inner = '<replicate count="1000"><body/></replicate>'
    read_model(written(tmp_path, body(inner), "robot.xml"))
    assert "makes more than" in refusal(written(tmp_path, body(3 * inner), "robot.xml"))


#: Where a model may read other files from.
INSIDE = "there is no such file inside the model's folder or one given by '--package-path'"
CHAIN = "".join(f'<link name="l{k}"/>' for k in range(3000)) + "".join(
    f'<joint name="j{k}" type="fixed"><parent link="l{k}"/><child link="l{k + 1}"/></joint>'
    for k in reversed(range(2999))
)
BOMB = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>\n'


#: By the line of the complaint, and the complaint: the file's text.
REFUSED = {
    "1: not well-formed XML: no element found": "",
    "1: not well-formed XML: mismatched tag": "<robot><link></robot>",
    "1: not well-formed XML: junk after document element": "<robot/><robot/>",
    "1: not well-formed XML: duplicate attribute": '<robot><link name="a" name="b"/></robot>',
    "1: SDF is not read; convert it to URDF or MJCF": "<sdf/>",
    "1: <html> is neither URDF (<robot>) nor MJCF (<mujoco>)": "<html/>",
    "1: <robot> has no <link>: there is nothing to inspect": "<robot/>",
    "1: <mujoco> has no <body>: there is nothing to inspect": "<mujoco/>",
    "1: <xacro:macro> is xacro: expand it first, 'xacro FILE > robot.urdf'": (
        '<robot><xacro:macro name="m"/></robot>'
    ),
    "2: <include> has no place in a URDF; expand the file first": (
        '<robot>\n<mujoco><include file="/etc/passwd"/></mujoco><link name="a"/></robot>'
    ),
    "1: a DTD (<!DOCTYPE …>) is refused: it can make a small file huge or read other files; "
    "remove it": robot(link("a"), head=BOMB),
    f"2: elements are nested more than {MAX_DEPTH} deep": (
        robot("<a>" * MAX_DEPTH + "</a>" * MAX_DEPTH)
    ),
    f"2: more than {MAX_ELEMENTS} elements, which no model has": robot("<a/>" * MAX_ELEMENTS),
    f"1: <robot> has more than {MAX_ATTRIBUTES} attributes": f"<robot {MANY_ATTRIBUTES}/>",
    f"2: 'name' must be at most {MAX_NAME} characters": robot(link("a" * 10**6)),
    f"1: 'sep' must be at most {MAX_NAME} characters": (
        body(f'<replicate count="9" sep="{"a" * 10**6}"><body/></replicate>')
    ),
    "1: links hang on each other more than 256 deep": f"<robot>{CHAIN}</robot>",
    **{
        f"3: 'value' of <mass> must be numbers up to 1e+100, got '{mass}'": arm(mass=mass)
        for mass in ("1e101", "-1e308", "1e999")
    },
    **{
        f"1: '{way}' of <inertial> {rule}": body(
            f'<inertial mass="1" diaginertia="1 1 1" {way}="{numbers}"/>'
        )
        for way, numbers, rule in (
            ("quat", "0 0 0 0", "must not be zero"),
            ("axisangle", "0 0 0 40", "must not be zero"),
            ("xyaxes", "0 0 0 0 1 0", "must not be zero"),
            ("xyaxes", "1 0 0 0 0 0", "must not be zero"),
            ("xyaxes", "1 0 0 -2 0 0", "must be two axes that are not parallel"),
            ("zaxis", "0 0 0", "must not be zero"),
        )
    },
    **{
        f"3: 'value' of <mass> must be decimal numbers, got '{number}': {why}": arm(mass=number)
        for why, numbers in {
            "engines do not read it alike": ("1_0", "nan", "inf", "0x10", "٣"),
            "engines stop reading at the comma": ("0,5",),
            "it is xacro, expand the file first": ("${m}",),
        }.items()
        for number in numbers
    },
    "3: 'iyy' of <inertia> must be decimal numbers, got '0,1': engines stop reading at the comma": (
        arm(diagonal("0.1", "0,1", "0.1"))
    ),
    "3: 'rpy' of <origin> must be 3 numbers, got '0 0.5'": (
        arm().replace('rpy="0 0 0.5"', 'rpy="0 0.5"')
    ),
    "1: <inertial> gives its rotation twice: 'quat' and 'euler'": (
        body('<inertial mass="1" diaginertia="1 1 1" quat="1 0 0 0" euler="0 0 0"/>')
    ),
    "3: a second link is named 'a'; names must differ": robot(link("a"), link("a")),
    "3: links 'a' and 'b' both hang on no joint; engines want one root": (
        robot(link("a"), link("b"))
    ),
    "4: <joint name='to-c'> must name a link of the file as its child, got 'c'": (
        robot(link("a"), link("b"), joint("a", "c"))
    ),
    "5: <joint name='to-b'>: the link 'b' hangs on a joint already": (
        robot(link("a"), link("b"), joint("a", "b"), joint("a", "b"))
    ),
    "1: joints lead from the link 'a' back to itself": (
        robot(link("a"), link("b"), joint("a", "b"), joint("b", "a"))
    ),
    "2: a second <inertial> in <link name='a'>: engines do not take the same one": (
        robot(link("a", inertial() + inertial()))
    ),
    "1: a second <inertial> in <body name='arm'>: engines do not take the same one": (
        body(f"{2 * '<frame><inertial mass=_1_ diaginertia=_1 1 1_/></frame>'}".replace("_", '"'))
    ),
    "2: <inertial> lacks <inertia>: engines do not fill in the same": (
        robot(link("a", '<inertial><mass value="1"/></inertial>'))
    ),
    "2: <inertia> lacks 'ixy'": robot(link("a", inertial(tensor='ixx="1" iyy="1" izz="1"'))),
    **{
        f"2: <include> of '{file}': {INSIDE}": f'<mujoco>\n<include file="{file}"/></mujoco>'
        for file in ("/etc/passwd", "../outside.xml", "none.xml")
    },
    **{
        f"1: <{tag}> of '/etc/passwd': {INSIDE}": (
            body("", f'<asset><{tag} name="m" file="/etc/passwd"/></asset>')
        )
        for tag in ("model", "hfield")
    },
    "1: <include> of 'robot.xml': a file can be included once": (
        '<mujoco><include file="robot.xml"/></mujoco>'
    ),
    "1: <replicate> makes more than 4096 elements, nested ones too": (
        body('<replicate count="1e8"><body/></replicate>')
    ),
    # Tables of two thousand million entries.
    **{
        f"1: '{key}' of <size> must be at most 10000, got '2000000000'": (
            f'<mujoco><size memory="1G" njmax="99999" {key}="2000000000"/>'
            "<worldbody><body/></worldbody></mujoco>"
        )
        for key in ("nkey", "nuserdata", "nuser_body")
    },
}


@each_case(("complaint", "text"), [*REFUSED.items()])
def test_what_is_no_model_that_all_read_alike_is_refused(tmp_path, complaint, text):
    written(tmp_path, "<mujoco/>", "outside.xml")
    kind = "xml" if text.startswith("<mujoco") else "urdf"
    path = written(tmp_path, text, f"inner/robot.{kind}")
    assert refusal(path) == f"FILE:{complaint}"


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-16-le"])
def test_a_file_in_another_encoding_is_refused_as_engines_do(tmp_path, encoding):
    """Where expat reads it, spans of elements would be counted in other bytes."""
    path = tmp_path / "robot.urdf"
    path.write_bytes(robot(link("a", inertial())).encode(encoding))
    assert refusal(path) == "FILE: must be a text in UTF-8, no engine reads UTF-16 or zeros"


def test_a_file_in_latin_1_is_said_not_to_be_in_utf_8(tmp_path):
    path = tmp_path / "robot.urdf"
    declared = '<?xml version="1.0" encoding="ISO-8859-1"?>\n'
    path.write_bytes((declared + robot(link("fuß", inertial()))).encode("latin-1"))
    assert refusal(path) == "FILE:3: must be a text in UTF-8, the only encoding that is read"
