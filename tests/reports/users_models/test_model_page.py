"""The page of a model: worst links first, what to do, nothing of the file taken for markup."""

import re
from html import unescape
from pathlib import Path

import pytest
from spincheck.engines.users_models import read_model
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.users_models.inspection import inspect_model, reader_engines
from spincheck.reports.users_models.page import page_names, write_model_page
from spincheck.scenarios.errors import is_control
from users_models import arm, body, diagonal, inertial, joint, link, robot, written

pytest.importorskip("pybullet")
BOX = '<collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>'


def page(folder: Path, text: str, name: str = "robot.urdf") -> str:
    model = read_model(written(folder, text, name))
    inspection = inspect_model(model, InProcess(), reader_engines())
    return write_model_page(inspection, folder / "out", "a-page").read_text(encoding="utf-8")


def cards(html: str) -> list[str]:
    return re.findall(r'<article class="card">.*?</article>', html, re.DOTALL)


def heading(card: str) -> str:
    return re.search(r"<h3>(\S+)", card)[1]


def card_of_the_arm(html: str) -> str:
    (card,) = (one for one in cards(html) if heading(one) == "arm")
    return card


def test_links_come_worst_first_and_good_ones_not_at_all(tmp_path):
    ball = inertial("2", diagonal(2, 2, 2), "")
    text = robot(
        link("base", inertial("0", diagonal(0, 0, 0))),
        link("round", ball + BOX.replace('box size="0.4 0.2 0.1"', 'sphere radius="0.2"')),
        link("arm", inertial() + BOX),
        joint("base", "round"),
        joint("base", "arm"),
    )
    # A ball that is held too small turns alike; an arm does not.
    assert list(map(heading, cards(page(tmp_path, text)))) == ["arm", "round"]


def test_a_card_has_the_attitude_that_another_body_loses(tmp_path):
    model = read_model(written(tmp_path, arm(inside=BOX), "robot.urdf"))
    inspection = inspect_model(model, InProcess(), reader_engines())
    (readings,) = (one.readings for one in inspection.links if one.link.name == "arm")
    lost = [one.attitude_apart_deg.values() for one in readings if one.agrees is False]
    assert lost
    card = card_of_the_arm(page(tmp_path, arm(inside=BOX)))
    for angles in lost:
        assert ", ".join(f"{angle:.3g}°" for angle in angles) in card


def test_a_tensor_that_no_body_has_is_told(tmp_path):
    card = card_of_the_arm(page(tmp_path, arm(diagonal(0.3, 0.1, 0.9), inside=BOX)))
    assert "0.1 + 0.3 &lt; 0.9: no body has it" in card


def test_what_to_do_has_the_flag_and_the_line_of_xml_and_a_page_needs_its_style_sheets_alone(
    tmp_path,
):
    html = page(tmp_path, arm(inside=BOX))
    assert "flags=pybullet.URDF_USE_INERTIA_FROM_FILE" in unescape(html)
    assert '<inertial><mass value="0"/>' in unescape(html)
    targets = re.findall(r'(?:href|src)="([^"]*)"', html)
    assert targets == ["../assets/style.css", "../assets/model.css"]
    assert all((tmp_path / "out/models" / name).is_file() for name in targets)


def test_of_a_good_file_the_page_says_so(tmp_path):
    text = body('<inertial mass="1" pos="0 0 0" diaginertia="1 2 2.5"/>')
    html = page(tmp_path, text, "good.xml")
    assert "Every engine that was asked holds what the file states" in html
    assert cards(html) == []


def test_nothing_of_a_file_is_taken_for_markup(tmp_path):
    evil = "&lt;script&gt;alert(1)&lt;/script&gt;&quot;&gt;&lt;img src=x onerror=alert(1)&gt;"
    text = robot(
        link("base"), link(evil, inertial() + BOX), joint("base", evil), head="<!-- <b> -->"
    )
    html = page(tmp_path, text, "<b>robot.urdf")
    for tag in ("<script>alert", "<img", "<b>"):
        assert tag not in html
    assert "&lt;script&gt;alert(1)" in html


def test_nothing_in_a_file_commands_a_terminal(tmp_path):
    """What XML lets a name hold: a C1 control, and what turns text about."""
    name = "a\x9b31m\u202eb"
    text = robot(link("base"), link(name, inertial() + BOX), joint("base", name))
    html = page(tmp_path, text, "robot.urdf")
    assert "a\\x9b31m\\u202eb" in html
    assert not [c for c in html if is_control(c) and c not in "\n\t"]


def test_pages_of_files_of_one_name_differ():
    paths = [Path("/a/iiwa/model.urdf"), Path("/b/iiwa/model.urdf"), Path("/b/r 2/..x.urdf")]
    assert page_names(paths) == ["iiwa-model", "iiwa-model-2", "r-2-..x"]
