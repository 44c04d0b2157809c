"""Noise that is not stated is estimated from what alternates between samples."""

from dataclasses import replace

import numpy as np
import pytest
from honest_library import NOISES, noisy
from library_scenes import library_scene
from spincheck.reference import solve
from spincheck.reports.harness.recorded.samples.alternation import alternation


@pytest.mark.parametrize("name", ["fast-top", "top-in-treacle", "sphere-in-syrup"])
@pytest.mark.parametrize("size", NOISES)
def test_noise_is_estimated_also_where_drag_damps_it_from_sample_to_sample(
    name: str, size: float
) -> None:
    scenario = library_scene(name)
    exact = solve(scenario, scenario.times).trajectory
    recorded = noisy(scenario, size, is_stated=False).arrays
    motion = replace(exact, q_world_body_wxyz=recorded["q"], omega_body=recorded["omega"])
    found = alternation(scenario, motion, np.zeros(2))
    assert found is not None
    fastest = np.linalg.norm(exact.omega_body, axis=1).max()
    assert found.is_noise.all()
    # 2 400 fourth differences, which share noise, determine it to some 3 %.
    assert np.abs(found.noise / [size, size * fastest] - 1).max() < 0.1


def test_an_honest_recording_of_a_stiff_motion_is_within_its_noise() -> None:
    found = noisy(library_scene("top-in-treacle"), 1e-4, is_stated=False).judged()
    assert found.explained_by == ()
    assert not found.is_beyond
