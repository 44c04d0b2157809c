"""What Newton's importers hold of a file; skipped where Newton is not installed."""

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


def held(folder: Path, text: str, configuration: str = "as-is", file: str = "robot.urdf"):
    installed("newton")
    return model_readers()["newton"].read(read_model(written(folder, text, file)), configuration)


@each_case(
    ("file", "text"),
    [
        ("robot.urdf", arm()),
        ("robot.urdf", arm(inside=SPHERE)),
        ("robot.xml", turned('euler="30 20 10"')),
        ("robot.xml", turned('zaxis="1 2 3"', '<geom size="1"/>')),
        ("robot.xml", turned('euler="0.3 0.2 0.1"', compiler=OTHER_ANGLES)),
    ],
)
def test_a_turned_tensor_is_held_as_the_file_states_it(tmp_path, file, text):
    stated = read_model(written(tmp_path, text, file)).link("arm").stated
    got = held(tmp_path, text, file=file)["arm"]
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


def test_a_file_that_newton_refuses_is_reported(tmp_path):
    text = turned("", tensor="0.03 0.04 0.5")
    with pytest.raises(EngineError, match=r"Newton refuses the file: .*A \+ B >= C"):
        held(tmp_path, text, file="robot.xml")


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
