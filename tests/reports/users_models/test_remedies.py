"""Remedies work: each is applied to its file, and the file inspected again."""

from types import SimpleNamespace

import numpy as np
import pytest
from spincheck.engines.users_models import Advice, read_model
from spincheck.engines.users_models.edit import inertial_line
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.users_models import findings, inspection
from spincheck.reports.users_models.findings import remedies
from spincheck.reports.users_models.inspection import Inspection, inspect_model, reader_engines
from users_models import TENSOR, arm, arm_with_a_tool, diagonal, inertial, link, written

pytest.importorskip("pybullet")
EPS = float(np.finfo(float).eps)
#: What MuJoCo's refusal of an impossible mass or tensor is followed by.
CORRECT = "correct the masses and tensors that no body has"


def inspected(folder, text):
    return inspect_model(read_model(written(folder, text)), InProcess(), reader_engines())


def remedies_of(inspection, who):
    return [one for one in remedies(inspection) if who in one.who]


def kinds(inspection, who):
    """By link, what a configuration has done to it."""
    return {
        link.link.name: held.kind
        for link in inspection.links
        for held in link.readings
        if f"{held.engine} {held.configuration}" == who
    }


def test_a_link_that_states_nothing_gets_a_line(tmp_path):
    who = "pybullet inertia-from-file"
    before = inspected(tmp_path, arm())
    (remedy,) = remedies_of(before, who)
    assert (remedy.names, kinds(before, who)["base"]) == (("base",), "nothing stated")
    text = arm().replace(link("base"), link("base", remedy.line))
    after = inspected(tmp_path, text)
    assert kinds(after, who) == {"base": "", "arm": ""}
    assert remedies_of(after, who) == []


def test_where_a_flag_mends_it_the_flag_is_reported(tmp_path):
    inspection = inspected(tmp_path, arm())
    words = [one.text for one in remedies_of(inspection, "pybullet default") if "flag" in one.text]
    assert words == ["load it with flags=pybullet.URDF_USE_INERTIA_FROM_FILE"]
    assert kinds(inspection, "pybullet inertia-from-file")["arm"] == ""


def test_an_option_has_mujoco_take_links_without_a_tensor(tmp_path):
    text = arm(diagonal(0, 0, 0))
    (remedy,) = remedies_of(inspected(tmp_path, text), "mujoco as-is")
    assert remedy.names == ("arm",)
    after = inspected(tmp_path, text.replace('name="made-up">', f'name="made-up">{remedy.line}'))
    assert ("mujoco", "as-is") not in after.refusals


@pytest.mark.parametrize("moments", [(0.3, 0.1, 0.9), (-0.1, 0.3, 0.3)])
def test_a_tensor_that_no_body_has_is_to_be_corrected(tmp_path, moments):
    inspection = inspected(tmp_path, arm(diagonal(*moments)))
    (remedy,) = remedies_of(inspection, "mujoco as-is")
    assert (remedy.text, remedy.names) == (CORRECT, ("arm",))
    of_bullet = remedies_of(inspection, "pybullet inertia-from-file")
    corrected = ("correct their masses and tensors in the file: no body has them", ("arm",))
    assert corrected in [(one.text, one.names) for one in of_bullet]
    # That for several configurations is reported once.
    lines = [(one.text, one.names) for one in remedies(inspection)]
    assert len(lines) == len(set(lines))
    assert ("mujoco as-is", "mujoco unfused") in [one.who for one in remedies(inspection)]


@pytest.mark.parametrize("mass", ["-1", "0"])
def test_no_option_hides_a_mass_that_no_body_has(tmp_path, mass):
    """MuJoCo refuses it in the words in which it refuses a link without a mass."""
    inspection = inspected(tmp_path, arm(mass=mass))
    (remedy,) = remedies_of(inspection, "mujoco as-is")
    assert (remedy.text, remedy.names, remedy.line) == (CORRECT, ("arm",), "")


@pytest.mark.parametrize(
    ("mass", "moments", "factor"), [("1e-6", (3e-16, 3e-16, 5e-16), 1e3), ("1e-16", (1, 1, 1), 1)]
)
def test_what_is_too_small_for_an_engine_is_not_called_impossible(tmp_path, mass, moments, factor):
    inspection = inspected(tmp_path, arm(diagonal(*moments), mass))
    assert all(one.is_possible for one in inspection.links)
    (remedy,) = remedies_of(inspection, "mujoco as-is")
    assert remedy.names == ("arm",)
    assert remedy.text.startswith("state larger masses and tensors: MuJoCo takes none below 1e-14 ")
    # As advised, MuJoCo takes them.
    larger = arm(diagonal(*(factor * moment for moment in moments)), str(1e3 * float(mass)))
    assert ("mujoco", "as-is") not in inspected(tmp_path, larger).refusals


# From 4.0.0 on, MuJoCo warns of the option.
@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass' is deprecated")
def test_a_tensor_scaled_as_a_whole_moves_alike_and_the_option_that_scales_it_is_named(tmp_path):
    option = '<mujoco><compiler settotalmass="7"/></mujoco>'
    scaled = inspected(tmp_path, arm().replace('name="made-up">', f'name="made-up">{option}'))
    held = next(one for one in scaled.links if one.link.name == "arm").readings[1]
    assert (held.who, held.agrees) == ("mujoco unfused", False)
    assert held.attitude_apart_deg == {1.0: 0.0, 3.0: 0.0}
    (note,) = [one for one in scaled.model.notes if "settotalmass" in one]
    assert note.endswith(
        "MuJoCo's option settotalmass='7' scales all masses and tensors; without it MuJoCo holds "
        "what the file states"
    )


def test_the_line_without_a_rotation_states_the_same_tensor(tmp_path):
    before = read_model(written(tmp_path, arm())).link("arm").stated
    text = arm().replace(inertial("2", TENSOR), inertial_line(before))
    after = read_model(written(tmp_path, text)).link("arm").stated
    assert (after.inertia_com == before.inertia_com).all()
    assert (after.unturned == after.inertia_com).all()
    assert (after.mass, after.com.tolist()) == (before.mass, before.com.tolist())
    # Teeth: as it was, a reader that loses the rotation has another tensor.
    assert np.abs(before.unturned - before.inertia_com).max() > 1e-3


def test_links_that_are_kept_apart_are_not_fused(tmp_path):
    text = arm_with_a_tool()
    option = '<mujoco><compiler fusestatic="false"/></mujoco>'
    after = inspected(tmp_path, text.replace('name="made-up">', f'name="made-up">{option}'))
    assert all(not held.fused for one in after.links for held in one.readings)


def test_an_optional_reader_reads_only_if_it_is_named(monkeypatch):
    rare, usual = (
        SimpleNamespace(version="2.0", is_optional=optional) for optional in (True, False)
    )
    monkeypatch.setattr(inspection, "model_readers", lambda: {"rare": rare, "usual": usual})
    assert [one.name for one in reader_engines()] == ["usual"]
    assert [one.name for one in reader_engines(["rare"])] == ["rare"]


def test_an_engine_of_any_name_brings_its_own_advice(tmp_path, monkeypatch):
    advice = Advice("weigh them down", concerns="massless")
    reader = SimpleNamespace(refusals={"too light": (advice,)})
    monkeypatch.setattr(findings, "model_readers", lambda: {"stranger": reader})
    model = read_model(written(tmp_path, arm()))
    refused = {("stranger@2.0", "as-is"): "a link is too light"}
    (remedy,) = remedies(Inspection(model, (), refused))
    assert (remedy.who, remedy.text) == (("stranger@2.0 as-is",), "weigh them down")
