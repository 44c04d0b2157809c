"""Far beyond noise no tensor is given, and what a method made is not taken for measured."""

from pathlib import Path

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from reported_faults import Arrays
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.recording import Recording

pytestmark = pytest.mark.slow

ONE = case(151, duration=1.6, samples=81)
NOISE = 1e-3
STATED = {"noise_attitude": repr(NOISE), "noise_omega": repr(NOISE)}


def noisy() -> Arrays:
    motion, chance = exactly(ONE, rates_of(ONE)), np.random.default_rng(3)
    motion["omega"] += chance.normal(0, NOISE, motion["omega"].shape)
    q = motion["q"] + chance.normal(0, NOISE / 2, motion["q"].shape)
    return motion | {"q": q / np.linalg.norm(q, axis=1)[:, None]}


def judged(arrays: Arrays, stated: dict[str, str], order: int = 1) -> JudgedMotion:
    return judged_motion(ONE.scenario, Recording(Path("motion.csv"), arrays, stated), order)


@pytest.mark.parametrize("is_drifting", [False, True])
def test_what_is_far_beyond_noise_gives_no_tensor(is_drifting: bool) -> None:
    motion = noisy()
    # No change of the equations makes ω wave so.
    waves = 40 * NOISE * np.sin(np.outer(motion["t"], [40.0, 45.0, 50.0]))
    motion["omega"] += is_drifting * waves
    fit = judged(motion, STATED).measured
    assert fit is not None
    assert fit.is_far == is_drifting
    assert (fit.as_record()["tensor"] is None) == is_drifting
    assert fit.tensor_in_words().startswith("No tensor is given") == is_drifting
    assert not (is_drifting and fit.explained())


@pytest.mark.parametrize(("order", "is_measured"), [(1, True), (4, False)])
def test_what_a_method_of_a_stated_order_made_is_not_measured(
    order: int, is_measured: bool
) -> None:
    found = judged(noisy(), {"timestep": "0.001"}, order)
    assert (found.measured is not None) == is_measured
