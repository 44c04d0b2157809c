"""Links of robots that come with PyBullet, from text to verdict: docs/how-to/models.md."""

from pathlib import Path

import numpy as np
import pytest
from spincheck.engines.users_models import read_model
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.users_models.inspection import inspect_model, reader_engines

pybullet_data = pytest.importorskip("pybullet_data")
ROBOTS = Path(pybullet_data.getDataPath())
#: Of numbers printed with three digits.
PRINTED = 5e-3


def held(file, link):
    """By configuration, and what the file has wrong."""
    model = read_model(ROBOTS / file, (("robots", ROBOTS),))
    inspection = inspect_model(model, InProcess(), reader_engines())
    (one,) = (li for li in inspection.links if li.link.name == link)
    return {h.configuration: h for h in one.readings}, [p.kind for p in one.problems]


def moments(one):
    return np.linalg.eigvalsh(one.body.inertia_com)


def test_an_arms_link_is_held_but_by_default():
    by, wrong = held("kuka_iiwa/model.urdf", "lbr_iiwa_link_3")
    assert wrong == []
    agreeing = {name for name, h in by.items() if h.agrees}
    assert agreeing == {"as-is", "unfused", "inertia-from-file"} == {*by} - {"default"}
    assert moments(by["inertia-from-file"]) == pytest.approx([0.01, 0.075, 0.08])


def test_bullets_own_scaling_of_a_cube_is_reported():
    by, wrong = held("cube_small.urdf", "baseLink")
    assert wrong == ["placeholder"]
    # A cube of 5 cm and 0.1 kg, three times.
    assert moments(by["default"]) == pytest.approx(3 * 0.1 * 0.05**2 / 6, rel=PRINTED)
    assert by["inertia-from-file"].cause == "tensor 3 times the file's"


def test_a_head_and_its_box_are_summed():
    by, _ = held("r2d2.urdf", "head")
    arm_squared = 2 * 0.1214**2
    across = 2 + 10 * 1 / 11 * arm_squared
    assert moments(by["as-is"]) == pytest.approx([2, across, across])
    assert by["as-is"].agrees


def test_a_tensor_that_no_body_has_is_zero_in_one_engine_and_refused_by_the_other():
    by, wrong = held("xarm/xarm6_robot.urdf", "link2")
    assert wrong == ["triangle inequality"]
    assert by["inertia-from-file"].cause == (
        "tensor set to zero: no body has it, 0.00306 + 0.0236 < 0.0269"
    )
    assert "inertia must satisfy A + B >= C" in by["as-is"].cause


def test_a_leg_without_a_tensor_is_a_problem_of_the_file():
    by, wrong = held("laikago/laikago.urdf", "FR_upper_leg")
    assert wrong == ["zero tensor"]
    assert by["inertia-from-file"].agrees
    assert by["default"].cause.endswith("kg m², the file states a tensor of zero")
