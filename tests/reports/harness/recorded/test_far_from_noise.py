"""Far beyond noise no tensor is given, and what a method made is not taken for measured."""

from pathlib import Path

import numpy as np
import pytest
from planted_motions import Case, case, exactly, rates_of
from reported_faults import Arrays
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.fits import right_by_itself
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import from_tables

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
    assert fit.explained() == [right_by_itself.ATTITUDE_ALONE] * is_drifting


def test_far_beyond_noise_attitudes_or_omega_may_be_right_by_themselves() -> None:
    right, late = noisy(), exactly(ONE, rates_of(ONE))
    omega = np.array([np.interp(0.9 * late["t"], late["t"], one) for one in late["omega"].T]).T
    chance = np.random.default_rng(5)
    arrays = right | {"omega": omega + chance.normal(0, NOISE, omega.shape)}
    found = judged(arrays, STATED)
    assert found.explained_by == (right_by_itself.ATTITUDE_ALONE,)
    q = np.array([np.interp(0.9 * late["t"], late["t"], one) for one in late["q"].T]).T
    q += chance.normal(0, NOISE / 2, q.shape)
    arrays = right | {"q": q / np.linalg.norm(q, axis=1)[:, None]}
    assert judged(arrays, STATED).explained_by == (right_by_itself.OMEGA_ALONE,)


def test_a_gyroscopes_filter_is_named_without_a_stated_noise_too() -> None:
    """Its error is below that of one step from sample to sample, and its attitudes are right."""
    inertia = np.array([[10.0, -2.4, -1.5], [-2.4, 12.0, -2.3], [-1.5, -2.3, 17.1]]) * 1e-3
    tables = {
        "title": "A box with a filtered gyroscope",
        "source": "made up",
        "body": {"mass": 1.9, "inertia": inertia.tolist()},
        "start": {"rotation_vector_deg": [-50.0, 20.0, 15.0], "omega_body": [5.0, 6.0, -4.5]},
        "window": {"duration": 3.0, "samples": 3001},
    }
    box = Case(from_tables(tables, "box"), inertia, np.zeros(3), np.zeros(3))
    motion, chance = exactly(box, rates_of(box)), np.random.default_rng(6)
    filtered = [motion["omega"][0]]
    for omega in motion["omega"][1:]:
        # A low-pass of 12 ms that starts at the first ω.
        filtered.append(filtered[-1] + (1 - np.exp(-0.001 / 0.012)) * (omega - filtered[-1]))
    motion = {name: array[::10] for name, array in (motion | {"omega": np.array(filtered)}).items()}
    motion["omega"] += chance.normal(0, 0.01, motion["omega"].shape)
    turns = Rotation.from_rotvec(chance.normal(0, 0.001, motion["omega"].shape))
    q = Rotation.from_quat(motion["q"], scalar_first=True) * turns
    arrays = motion | {"q": q.as_quat(scalar_first=True)}
    recording = Recording(Path("motion.csv"), arrays, {})
    words = judged_motion(box.scenario, recording, 1).explained_by
    assert words[0].startswith("ω is what a low-pass filter of a time constant of 0.011")


def test_a_heading_that_drifts_is_no_other_body() -> None:
    motion, rate = noisy(), 0.01
    drift = Rotation.from_rotvec(np.outer(motion["t"], [0.0, 0.0, rate]))
    turned = drift * Rotation.from_quat(motion["q"], scalar_first=True)
    motion["q"] = turned.as_quat(scalar_first=True)
    (words,) = judged(motion, STATED).explained_by
    assert words.startswith("it turns as if the world turned by [")


def test_axes_that_are_turned_in_the_body_are_no_other_body() -> None:
    motion, turn = noisy(), Rotation.from_rotvec([0.1, -0.05, 0.15])
    q = Rotation.from_quat(motion["q"], scalar_first=True) * turn
    omega = turn.inv().apply(motion["omega"])
    arrays = motion | {"q": q.as_quat(scalar_first=True), "omega": omega}
    found = judged(arrays, STATED)
    (words,) = found.explained_by
    assert words.startswith("attitude and ω are those of axes that are turned by [")
    numbers = [float(one.split()[0]) for one in words.partition("[")[2].split(",")]
    assert numbers == pytest.approx(np.degrees(turn.as_rotvec()), abs=0.1)


def test_standard_errors_grow_with_what_is_left_beyond_noise() -> None:
    motion = noisy()
    # Half as much again as what is stated, in one axis: beyond noise, and not far.
    waves = 2 * NOISE * np.sin(np.outer(motion["t"], [40.0, 45.0, 50.0]))
    fit = judged(motion | {"omega": motion["omega"] + waves}, STATED).measured
    assert fit is not None
    assert fit.is_beyond
    assert not fit.is_far
    assert fit.inflation == pytest.approx(np.sqrt(fit.chi2 / fit.freedom))
    assert fit.inflation > 1.2
    usual = judged(motion, STATED).measured
    assert usual is not None
    assert usual.inflation == 1.0
    assert np.all(fit.tensor_entries()[1] > 1.1 * usual.tensor_entries()[1])


@pytest.mark.parametrize(("order", "is_measured"), [(1, True), (4, False)])
def test_what_a_method_of_a_stated_order_made_is_not_measured(
    order: int, is_measured: bool
) -> None:
    found = judged(noisy(), {"timestep": "0.001"}, order)
    assert (found.measured is not None) == is_measured
