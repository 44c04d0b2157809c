"""A model mended is read again: every engine holds what it states, and nothing else has changed."""

import re
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from spincheck.engines.users_models import read_model
from spincheck.engines.users_models.edit import set_attributes
from spincheck.engines.users_models.xml_tree import parse_xml
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.users_models.inspection import Inspection, inspect_model, reader_engines
from spincheck.reports.users_models.mend import REMARK, Wishes, mended, nearest_possible
from users_models import (
    TENSOR,
    arm,
    arm_with_a_tool,
    body,
    diagonal,
    inertial,
    joint,
    link,
    robot,
    written,
)

pytest.importorskip("pybullet")
EPS = float(np.finfo(float).eps)
#: No flag of the file's has PyBullet's default take its tensors.
BY_FLAG = ("pybullet", "default")


def inspected(path: Path) -> Inspection:
    return inspect_model(read_model(path), InProcess(), reader_engines())


def mend(folder: Path, text: str, name="robot.urdf", **wishes):
    """Before and after, what was changed and what is left."""
    before = inspected(written(folder, text, name))
    one = mended(before, Wishes(**wishes))
    after = inspected(written(folder, one.data.decode(), f"mended-{name}"))
    return before, after, list(map(str, one.changes)), list(map(str, one.left))


def wrong(inspection: Inspection) -> dict[tuple[str, str], list[str]]:
    """By configuration, the links held otherwise; PyBullet's default aside."""
    found: dict[tuple[str, str], list[str]] = {who: ["refused"] for who in inspection.refusals}
    for one in inspection.links:
        for reading in one.readings:
            if reading.agrees is False and reading.kind != "refused":
                found.setdefault(reading.column, []).append(one.link.name)
    return {who: names for who, names in found.items() if who != BY_FLAG}


def tensor(inspection: Inspection, name: str) -> np.ndarray:
    return inspection.model.link(name).stated.inertia_com


def test_a_turned_tensor_is_written_along_the_links_axes_and_every_other_byte_stays(tmp_path):
    odd = "<!-- ünïcödé -->\r\n" + arm(inside="<odd:tag a='>' rpy=\"1 2 3\"/>")
    before, after, changes, left = mend(tmp_path, odd)
    assert changes == [
        "base: stated to have no mass, as URDF has it: MuJoCo and PyBullet fix such a root in the "
        "world",
        "arm: tensor written along the link's axes, without a rotation",
    ]
    assert (left, wrong(after)) == ([], {})
    assert wrong(before) == {("pybullet", "inertia-from-file"): ["base"]}
    assert (tensor(after, "arm") == tensor(before, "arm")).all()
    stated = after.model.link("arm").stated
    assert (stated.unturned == stated.inertia_com).all()
    kept = re.sub(rb"<inertial>.*?</inertial>", b"", after.model.data)
    source = re.sub(rb"<inertial>.*?</inertial>", b"", before.model.data)
    assert kept == source
    assert b"\r\n" in kept


def test_a_file_without_a_fault_stays_as_it_is(tmp_path):
    text = robot(link("base", inertial("0", diagonal(0, 0, 0))), link("arm", inertial(origin="")))
    text = text.replace("</robot>", joint("base", "arm") + "</robot>")
    before, after, changes, left = mend(tmp_path, text)
    assert (before.model.data, changes, left) == (after.model.data, [], [])


def test_an_impossible_tensor_is_written_only_if_asked_and_named(tmp_path):
    text = arm(diagonal(0.1, 0.1, 0.3))
    _, after, _, left = mend(tmp_path, text)
    assert left == [
        "arm: 0.1 + 0.1 < 0.3: no body has it; '--nearest' writes the nearest that one has"
    ]
    assert ("mujoco", "as-is") in after.refusals
    _, after, changes, left = mend(tmp_path, text, nearest=True)
    moments = "0.1333, 0.1333, 0.2667 kg m² for 0.1, 0.1, 0.3"
    words = "arm: nearest possible tensor, 0.17 of its norm off: moments "
    assert changes[-1] == words + moments
    assert (left, wrong(after)) == ([], {})


@each_case(
    ("mass", "tensor", "words"),
    [
        ("-1", TENSOR, "a mass of -1 kg"),
        (
            "1",
            diagonal(-1, -1, -1),
            "principal moments must be positive, they are -1, -1, -1 kg m²",
        ),
    ],
)
def test_what_no_body_is_near_is_left_and_said(tmp_path, mass, tensor, words):
    _, _, _, left = mend(tmp_path, arm(tensor, mass), nearest=True)
    assert left == [f"arm: {words}"]


@given(st.lists(st.integers(-1000, 1000), min_size=6, max_size=6), st.floats(-9, 3))
@settings(max_examples=200, deadline=None)
def test_the_nearest_tensor_is_possible_and_nothing_possible_is_nearer(entries, decade):
    xx, yy, zz, xy, xz, yz = np.array(entries) * 10**decade
    given_tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    near = nearest_possible(given_tensor) if given_tensor.any() else None
    if near is None:
        assert np.linalg.eigvalsh(given_tensor).sum() <= 1e-6 * np.abs(given_tensor).max() * 9
        return
    spread = np.trace(near) / 2 * np.eye(3) - near
    assert np.linalg.eigvalsh(spread)[0] > 0
    # Of the convex set of possible tensors, that near which none is: the angle at it is obtuse.
    random = np.random.default_rng(1)
    for _ in range(20):
        factor = random.normal(size=(3, 3)) * np.sqrt(np.abs(given_tensor).max())
        other = np.trace(factor @ factor.T) * np.eye(3) - factor @ factor.T
        slack = 1e-5 * np.linalg.norm(given_tensor) * np.linalg.norm(other - near)
        assert np.sum((given_tensor - near) * (other - near)) <= slack


def test_an_inertia_is_made_up_only_if_asked_and_said_in_the_file(tmp_path):
    box = '<collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>'
    parts = (link("base"), link("arm", box), link("tip"), joint("base", "arm"))
    text = robot(*parts, joint("arm", "tip", "fixed"))
    _, _, _, left = mend(tmp_path, text)
    assert left == ["arm: it has no mass, or no tensor; '--made-up' makes one up from its shapes"]
    _, after, changes, left = mend(tmp_path, text, made_up=True)
    assert "arm: made up: that of the box about its shapes" in changes
    assert after.model.data.count(REMARK.encode()) == 1
    assert (left, wrong(after)) == ([], {})
    # A box of 8 litres of water.
    assert after.model.link("arm").stated.mass == pytest.approx(8)
    assert tensor(after, "arm")[0, 0] == pytest.approx(8 * (0.2**2 + 0.1**2) / 12)


def test_a_mass_without_a_tensor_keeps_its_mass(tmp_path):
    _, after, changes, _ = mend(tmp_path, arm(diagonal(0, 0, 0)), made_up=True)
    assert "arm: made up: that of a cube of 1 cm, as its shapes are not known" in changes
    assert (after.model.link("arm").stated.mass, wrong(after)) == (2.0, {})


def test_welded_links_are_one_body_if_asked(tmp_path):
    text = arm_with_a_tool()
    before, after, changes, _ = mend(tmp_path, text, compose=True)
    assert any(words.endswith("; written as one body with tool") for words in changes)
    assert wrong(after) == {}
    (whole,) = before.composed
    assert np.abs(tensor(after, "arm") - whole.stated.inertia_com).max() <= 8 * EPS
    assert not tensor(after, "tool").any()
    # Impossible ones are not composed.
    bad = text.replace(link("tool", inertial()), link("tool", inertial("1", diagonal(1, 1, 3))))
    _, _, changes, left = mend(tmp_path, bad, compose=True)
    assert "arm: not written as one body with tool, of which some are left" in left


def test_bodies_that_an_mjcf_welds_are_one_if_asked(tmp_path):
    text = body(
        f'<freejoint/>{TURNED}<body pos="0 1 0" quat="1 1 0 0">{TURNED}<geom size="1"/></body>'
    )
    before, after, _, _ = mend(tmp_path, text, "robot.xml", compose=True)
    assert after.is_well
    (whole,) = before.composed
    assert np.abs(tensor(after, "arm") - whole.stated.inertia_com).max() <= 32 * EPS
    assert b'diaginertia="0 0 0"' in after.model.data


def test_bullets_own_scaling_is_taken_away(tmp_path):
    scaled = '<contact><inertia_scaling value="3.0"/><lateral_friction value="1"/></contact>'
    before, after, _, _ = mend(tmp_path, arm(inside=scaled))
    assert wrong(before)[("pybullet", "inertia-from-file")] == ["base", "arm"]
    assert wrong(after) == {}
    assert b'<contact><lateral_friction value="1"/></contact>' in after.model.data


def test_a_scaling_inside_of_another_goes_with_it(tmp_path):
    nested = '<inertia_scaling value="3"><inertia_scaling value="2"/></inertia_scaling>'
    _, after, _, _ = mend(tmp_path, arm(inside=f"<contact>{nested}</contact>"))
    assert b"<contact></contact>" in after.model.data
    assert wrong(after) == {}


TURNED = '<inertial mass="2" pos="0 0 1" euler="30 20 10" diaginertia="1 2 2.5"/>'
SHAPED = '<compiler angle="radian" inertiafromgeom="true" meshdir="m"/>'


def test_an_mjcfs_tensor_loses_its_rotation(tmp_path):
    before, after, changes, _ = mend(tmp_path, body(f"<freejoint/>{TURNED}"), "robot.xml")
    assert changes == ["arm: tensor written along the link's axes, without a rotation"]
    assert (tensor(after, "arm") == tensor(before, "arm")).all()
    assert b"euler" not in after.model.data
    assert after.is_well


def test_a_place_that_mujoco_asks_for_is_written(tmp_path):
    text = body('<freejoint/><inertial mass="2" diaginertia="1 2 2.5"/>')
    before, after, changes, _ = mend(tmp_path, text, "robot.xml")
    assert changes == ["arm: 'pos' written, without which MuJoCo refuses the file"]
    assert (before.is_well, after.is_well) == (False, True)


def test_an_inertial_in_a_frame_becomes_the_bodys_own(tmp_path):
    inner = f'<frame pos="1 0 0" euler="10 20 30">{TURNED}</frame>'
    before, after, changes, _ = mend(tmp_path, body(f"<freejoint/>{inner}"), "robot.xml")
    assert changes == ["arm: tensor written along the link's axes, without a rotation"]
    assert (wrong(before), wrong(after)) == ({}, {})
    assert np.abs(tensor(after, "arm") - tensor(before, "arm")).max() <= EPS
    assert b'<frame pos="1 0 0" euler="10 20 30"></frame>' in after.model.data


def test_what_an_mjcf_has_from_its_shapes_is_stated(tmp_path):
    inner = f'<freejoint/>{TURNED}<geom size="0.1 0.2" type="capsule" euler="0.1 0 0"/>'
    tip = '<body name="tip"><geom size="1"/></body>'
    text = body(inner + tip, SHAPED)
    before, after, changes, left = mend(tmp_path, text, "robot.xml")
    assert "the file: 'inertiafromgeom' taken away: bodies state theirs" in changes
    assert (left, after.is_well) == ([], True)
    assert b'<compiler angle="radian" meshdir="m"/>' in after.model.data
    for k, name in enumerate(("arm", "tip")):
        held = before.links[k].readings[0].body
        assert tensor((before.model.link(name).stated and before) or after, name).any()
        assert np.abs(tensor(after, name) - held.inertia_com).max() <= 8 * EPS * held.mass


def test_bodies_of_included_files_are_left_and_said(tmp_path):
    written(tmp_path, f"<mujoco>{body('<freejoint/>' + TURNED)[8:-9]}</mujoco>", "part.xml")
    before, after, _, left = mend(tmp_path, '<mujoco><include file="part.xml"/></mujoco>', "a.xml")
    assert left == ["arm: it is in a file that this one includes: mend that"]
    assert before.model.data == after.model.data


def test_a_replicated_body_is_written_once(tmp_path):
    text = body(f'<replicate count="3"><body name="k"><joint/>{TURNED}</body></replicate>')
    _, after, _, left = mend(tmp_path, text, "robot.xml")
    assert (after.model.data.count(b"fullinertia"), left, after.is_well) == (1, [], True)


@pytest.mark.parametrize(
    ("tag", "wanted"),
    [
        ("<a b=\"1\" c='2'/>", '<a b="9" d="8"/>'),
        ("<a x=' b=\"1\"' b='1'>", '<a x=\' b="1"\' b="9" d="8">'),
        ('<a\n\tc="2"\n>', '<a b="9" d="8">'),
    ],
)
def test_attributes_are_set_and_taken_away_where_they_are(tag, wanted):
    data = (tag if tag.endswith("/>") else f"{tag}</a>").encode()
    root, _ = parse_xml(data, "a.xml")
    _, new = set_attributes(data, root, {"b": "9", "c": None, "d": "8"})
    assert new.decode() == wanted
