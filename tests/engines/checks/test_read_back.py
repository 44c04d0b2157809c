"""Differences of a body that an engine holds, by their size."""

import numpy as np
import pytest
from scene_texts import scene
from spincheck.engines import BodyReading, State
from spincheck.engines.checks.read_back import READ_BACK_SLACK, differences

#: m; beside it the tensor about the origin is that of the arm: m r² is 500 times the tensor's.
ARM = 25.0


def unlike(inertia):
    """What is told of a body far from its origin that is held with that tensor."""
    far = scene(("com = [0.1, 0.2, 0.3]", f"com = [{ARM}, 0.0, 0.0]"))
    held = BodyReading(far.body.mass, far.body.com, inertia)
    start = far.start
    state = State(
        start.q_world_body_wxyz, start.omega_body, start.position_world, start.velocity_world
    )
    return differences(far, held, state, READ_BACK_SLACK)


@pytest.mark.parametrize("times", [61.0, 1 + 1e-6])
def test_a_tensor_is_measured_about_the_com(times):
    (difference,) = unlike(times * np.diag([1.0, 2.0, 2.5]))
    assert difference.what == "inertia_com"
    assert difference.relative == pytest.approx(times - 1)


def test_a_tensor_is_reported_within_its_own_rounding_however_long_the_arm():
    assert unlike(np.diag([1.0, 2.0, 2.5]) * (1 + READ_BACK_SLACK / 2)) == []
    assert len(unlike(np.diag([1.0, 2.0, 2.5]) * (1 + 2 * READ_BACK_SLACK))) == 1
