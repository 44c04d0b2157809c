"""A pivot of three hinges in Brax: states along the axes of the world are far from its pole."""

import numpy as np
import pytest
from kinds_of_engines import installed
from library_scenes import library_scene

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", ["goryachev-chaplygin", "gyroscope-on-a-stand", "planar-pendulum"])
def test_a_top_that_begins_along_an_axis_of_the_world_reads_back(name: str) -> None:
    scene, engine = library_scene(name), installed("brax")
    with engine.open(scene, engine.method("generalized"), 0.001) as session:
        state = session.read_state()
        np.testing.assert_allclose(state.omega_body, scene.start.omega_body, atol=1e-4)
        np.testing.assert_allclose(
            np.abs(state.q_world_body_wxyz), np.abs(scene.start.q_world_body_wxyz), atol=1e-6
        )
        session.advance(10)
        assert np.isfinite(session.read_state().omega_body).all()
