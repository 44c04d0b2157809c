"""Noise that is not stated is estimated from what alternates between samples."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from honest_library import NOISES, noisy
from library_scenes import library_scene
from planted_motions import case, exactly, rates_of
from spincheck.reference import solve
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.samples.alternation import alternation

pytestmark = pytest.mark.slow


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


# Strong drag damps noise; at the end of the other motion samples are 2.5 rad apart.
@pytest.mark.parametrize("name", ["top-in-treacle", "torque-to-high-spin"])
def test_an_honest_recording_is_within_its_noise(name: str) -> None:
    found = noisy(library_scene(name), 1e-2, is_stated=False).judged()
    assert found.explained_by == ()
    assert not found.is_beyond
    assert "noise" in found.verdict


def test_a_nutation_that_samples_do_not_resolve_is_no_noise() -> None:
    """The body turns by 0.07 rad between samples, and nutates by 5 rad."""
    scenario = library_scene("gyroscope-on-glass")
    exact = solve(scenario, scenario.times).trajectory
    assert alternation(scenario, exact, np.zeros(2)) is None


def test_exact_attitudes_beside_a_noisy_gyroscope_are_no_other_motion() -> None:
    """What noise of ω makes of fourth differences of the attitude hides how small its own is."""
    one = case(801, is_pivoted=True, duration=4.0, samples=201)
    arrays = exactly(one, rates_of(one))
    noise = np.random.default_rng(7).normal(0, 1e-3, arrays["omega"].shape)
    recording = Recording(Path("motion.csv"), arrays | {"omega": arrays["omega"] + noise}, {})
    found = judged_motion(one.scenario, recording)
    assert found.explained_by == ()
    assert not found.is_beyond


@pytest.mark.parametrize(("at", "outlier"), [(50, 1e9), (0, 1e8)])
def test_an_absurd_sample_is_judged(at: int, outlier: float) -> None:
    scenario = library_scene("fast-top")
    one = noisy(scenario, 1e-3, is_stated=False)
    one.arrays["omega"][at] = outlier
    assert one.judged().verdict
