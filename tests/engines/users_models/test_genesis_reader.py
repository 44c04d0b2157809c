"""What Genesis's importers hold of a file; skipped where Genesis is not installed."""

from pathlib import Path

import pytest
from case_loops import each_case
from kinds_of_engines import installed
from spincheck.engines import EngineError
from spincheck.engines.model_readers import model_readers
from spincheck.engines.users_models import AGREES, difference, read_model
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.users_models.inspection import inspect_model, reader_engines
from users_models import arm, arm_with_a_tool, body, diagonal, written

pytestmark = pytest.mark.slow

TURNED = """<freejoint/><geom size="1"/>
<inertial mass="2" pos="0.1 0 0" euler="30 20 10" diaginertia="0.03 0.04 0.05"/>"""


def held(folder: Path, text: str, file: str = "robot.urdf"):
    installed("genesis")
    return model_readers()["genesis"].read(read_model(written(folder, text, file)), "as-is")


@each_case(
    ("file", "text"),
    [
        ("robot.urdf", arm()),
        ("robot.xml", body(TURNED)),
        ("robot.xml", body(TURNED, '<compiler eulerseq="zXy"/>')),
    ],
)
def test_a_turned_tensor_is_held_as_the_file_states_it(tmp_path, file, text):
    """Of a free body too, though Genesis by default moves its frame to its principal axes."""
    stated = read_model(written(tmp_path, text, file)).link("arm").stated
    assert difference(stated, held(tmp_path, text, file)["arm"]).worst <= AGREES
    # Teeth: without the rotation of its own frame it would be another.
    assert abs(stated.unturned - stated.inertia_com).max() > 100 * AGREES * 0.05


def test_welded_links_are_summed_and_kept_apart(tmp_path):
    installed("genesis")
    model = read_model(written(tmp_path, arm_with_a_tool()))
    found = inspect_model(model, InProcess(), reader_engines(["genesis"]))
    assert found.is_well
    (arm_held,) = (one for one in found.links if one.link.name == "arm")
    assert [one.fused for one in arm_held.readings] == [("tool",), ()]


def test_a_file_that_genesis_refuses_is_reported(tmp_path):
    with pytest.raises(EngineError, match=r"Genesis refuses the file: .* A\+B>=C") as refused:
        held(tmp_path, arm(diagonal(0.01, 0.01, 0.05)))
    assert "/tmp" not in str(refused.value)
