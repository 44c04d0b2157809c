"""ω that is derived from attitudes: how far it is off, and what methods make of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from case_loops import each_case
from planted_motions import case, exactly, rates_of, stepped
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.case import STENCIL_ERRORS, Case
from spincheck.reports.harness.recorded.files.exact_at import exact_at
from spincheck.reports.harness.recorded.files.motion import (
    STENCILS,
    omega_of_attitudes,
    reading_of,
    recorded_motion,
)
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.fits.leading_error import left_by_methods

FREE, HEAVY = case(303, samples=101), case(402, is_pivoted=True, samples=101)


@each_case("one", {"free": FREE, "heavy": HEAVY})
def test_omega_of_attitudes_is_as_near_as_it_says(one: object) -> None:
    arrays = exactly(one, rates_of(one))
    found = omega_of_attitudes(arrays["t"], arrays["q"])
    off = np.linalg.norm(found.omega_body - arrays["omega"], axis=1)
    inner = off[found.reach : -found.reach]
    assert found.reach == STENCILS[-1] // 2
    assert inner.max() < STENCIL_ERRORS * found.error < 1e-4 * np.abs(arrays["omega"]).max()


def test_attitudes_of_either_sign_have_one_omega() -> None:
    arrays = exactly(FREE, rates_of(FREE))
    signs = np.where(np.arange(101) % 7 < 3, 1.0, -1.0)[:, None]
    found, other = (omega_of_attitudes(arrays["t"], q) for q in (arrays["q"], signs * arrays["q"]))
    assert np.abs(found.omega_body - other.omega_body).max() < 1e-12


def test_attitudes_of_few_digits_are_derived_from_few() -> None:
    """Of many samples the polynomial at either end multiplies what is rounded."""
    arrays = exactly(FREE, rates_of(FREE))
    chance = np.random.default_rng(1)
    turned = Rotation.from_rotvec(chance.normal(0, 0.01, (101, 3)))
    q = (Rotation.from_quat(arrays["q"], scalar_first=True) * turned).as_quat(scalar_first=True)
    assert omega_of_attitudes(arrays["t"], q).reach == STENCILS[0] // 2


def test_the_errors_of_a_method_in_a_derived_omega_are_its_own() -> None:
    """Of attitudes alone, too, the leading errors of its order explain what a method made."""
    made = stepped(HEAVY.scenario, rates_of(HEAVY), 2, 0.004, np.random.default_rng(3))
    recording = Recording(Path("motion.csv"), {name: made[name] for name in ("t", "q")}, {})
    exact, reading = exact_at(HEAVY.scenario, made["t"]).trajectory, reading_of(recording)
    recorded = recorded_motion(HEAVY.scenario, recording, reading, exact)
    physics = Case(HEAVY.scenario, recording, reading, exact, recorded, 0.004, 2).physics
    assert physics.intervals is not None
    data = physics.intervals.with_error(physics.off)
    assert data.is_derived
    left, otherwise = (
        np.mean(left_by_methods(one, [2], 0.004) ** 2)
        for one in (data, replace(data, is_derived=False))
    )
    assert left < physics.next_term**2 < otherwise
