"""Honest motions that were accused once, each by another cause, are not."""

from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from honest_library import NOISES, OfLibrary, arrays_of, noisy, stepped_run
from honest_motions import honest
from kinds_of_engines import installed
from library_scenes import library_scene
from planted_motions import case, exactly, rates_of, stepped
from reported_faults import judged
from scipy.spatial.transform import Rotation
from spincheck.engines import State
from spincheck.reference import solve
from spincheck.reports.harness.recorded import explained
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.fits.log import log_of
from spincheck.reports.harness.recorded.fits.stepwise import Stepwise
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.scenarios.scenario import started_at

pytestmark = pytest.mark.slow

#: Numbers of motions, by what was said of them.
ACCUSED = {
    "the times are 1 times too long": [27, 62, 73],
    "the times are 1.149 times too long, of a decay by long steps": [1912],
    "its timestep is another one, of errors hardly beyond rounding": [2728, 2909],
    "it crashed, as a mistaken tensor has no inverse": [1965],
    "one sample is off, of which noise is the largest": [47],
    "it started elsewhere, of samples far apart with noise": [119, 135],
    "it started elsewhere, of a method's errors before": [60, 160, 230],
    "it started elsewhere, of numbers rounded before it rests": [285],
    "it jumps, of a solver's first step": [86],
    "ω is interpolated, of a body at rest": [260],
    "another torque, of an ω that is computed from attitudes": [3160, 3192, 3457],
    "other equations, of the first six samples of twelve": [3354],
}


@pytest.mark.parametrize("number", [*chain(*ACCUSED.values())])
def test_an_honest_motion_is_not_accused_any_more(number: int) -> None:
    if (one := honest(number)) is None:
        pytest.skip("its engine is missing")
    found = one.judged()
    assert found.explained_by == ()
    assert not found.is_beyond


#: Scenes of the library, the method by its number, and the angle of a step, rad.
ACCUSED_OF_THE_LIBRARY = {
    "ω is rounded to 20 rad/s, of an ω that is nearly constant": [("hanging-top", 2, 0.02)],
    "a column is stuck, of attitudes with a method's error": [("middle-axis-off-by-1e-8", 2, 0.02)],
    "it saturates, of an ω that is constant to an ulp": [
        ("moments-equal-to-1e-14-oblate", 0, 0.02)
    ],
    "each state is that of another time, of one that lingers": [
        ("pendulum-just-over", 2, 0.02),
        ("pendulum-just-under", 2, 0.02),
        ("pendulum-over-by-a-millionth", 2, 0.1),
    ],
    "it is beyond its method, of one that is pushed from rest": [
        ("pushed-from-rest", 1, 0.1),
        ("torque-to-high-spin", 0, 0.1),
        ("torque-to-high-spin", 1, 0.02),
    ],
}


@pytest.mark.parametrize(("name", "which", "turn"), [*chain(*ACCUSED_OF_THE_LIBRARY.values())])
def test_an_honest_run_of_the_library_is_not_accused_any_more(
    name: str, which: int, turn: float
) -> None:
    run = stepped_run(library_scene(name), which, turn)
    assert run is not None
    found = run.judged()
    assert found.explained_by == ()
    assert not found.is_beyond


#: Scenes of the library, the engine, its method, and the timestep, s.
ACCUSED_ENGINES = {
    "drag of 1e-9 N m s, of a method with ω along world axes": [
        ("book-middle-axis", "drake", "runge_kutta3", 1e-3),
        ("discus-wobble", "drake", "runge_kutta3", 1e-3),
    ],
    "it turns 1 + 2e-8 times as fast, of rounding of many steps": [
        ("gazebo-box-steady", "drake", "runge_kutta5", 1e-3)
    ],
    "it jumps, of rounding near a pole": [
        ("let-go-with-little-spin", "drake", "runge_kutta5", 1e-3)
    ],
    "drag in noise, of errors that alternate as rotors turn": [
        ("quadrotor-body", "pybullet", "multibody", 1 / 240)
    ],
    "drag, other moments and a filter, of errors within those of its method": [
        ("pivot-in-orbit", "pybullet", "maximal", 1 / 240)
    ],
}


@pytest.mark.parametrize(
    ("name", "engine", "method", "timestep"), [*chain(*ACCUSED_ENGINES.values())]
)
def test_an_honest_run_of_an_engine_is_not_accused_any_more(
    name: str, engine: str, method: str, timestep: float
) -> None:
    scenario, one = library_scene(name), installed(engine)
    steps = round(scenario.window.duration / timestep)
    samples = np.unique(np.linspace(0, steps, 201).astype(int))
    run = one.run(scenario, one.method(method), timestep, samples)
    assert run.trajectory is not None
    order = one.method(method).order
    found = OfLibrary(
        engine, scenario, arrays_of(run.trajectory), {"timestep": repr(timestep)}, order
    ).judged()
    assert found.explained_by == ()
    assert not found.is_beyond


#: Each follows an unstable motion, near which any difference grows by 10¹⁰ and more.
SENSITIVE = ("pendulum-just-under", "pendulum-on-the-separatrix", "separatrix-exactly")


@pytest.mark.parametrize("name", SENSITIVE)
@pytest.mark.parametrize("size", NOISES)
@pytest.mark.parametrize("is_stated", [False, True])
def test_noise_about_a_sensitive_motion_is_explained_by_nothing(
    name: str, size: float, is_stated: bool
) -> None:
    found = noisy(library_scene(name), size, is_stated=is_stated).judged()
    assert found.explained_by == ()
    assert not found.is_beyond
    assert found.measured is not None
    if name == "separatrix-exactly":
        assert "are left out, as a difference of the start by rounding has grown" in found.verdict


def test_an_honest_log_is_not_searched_for_what_explains_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(explained, "followed", lambda *_: pytest.fail("mistakes are tried"))
    searched = lambda *_, **__: pytest.fail("changes are fitted")  # noqa: E731
    monkeypatch.setattr(Stepwise, "from_first_samples", searched)
    found = noisy(library_scene("book-pushed"), 1e-2, is_stated=True).judged()
    assert found.measured is not None
    assert found.explained_by == ()


def test_a_blow_late_in_a_noisy_log_is_found_whatever_follows_the_hypotheses() -> None:
    """With that noise an approximate integrator would do but for a motion that multiplies it."""
    one = case(6, True, duration=30.0, samples=60)
    exact = solve(one.scenario, one.scenario.times).trajectory
    at, size, chance = 48, 1.1e-4, np.random.default_rng(1)
    first = {name: getattr(exact, name)[at] for name in State.__dataclass_fields__}
    struck = started_at(one.scenario, **first | {"omega_body": 1.02 * exact.omega_body[at]})
    later = solve(struck, exact.t[at:] - exact.t[at]).trajectory
    omega = np.vstack([exact.omega_body[:at], later.omega_body])
    q = np.vstack([exact.q_world_body_wxyz[:at], later.q_world_body_wxyz])
    speed = float(np.linalg.norm(exact.omega_body, axis=1).max())
    turned = Rotation.from_rotvec(chance.normal(0, size, omega.shape))
    q = (Rotation.from_quat(q, scalar_first=True) * turned).as_quat(scalar_first=True)
    arrays = {"t": exact.t, "q": q, "omega": omega + chance.normal(0, size * speed, omega.shape)}
    noise = {"noise_attitude": repr(size), "noise_omega": repr(size * speed)}
    assert judged_motion(one.scenario, Recording(Path("motion.csv"), arrays, noise)).explained_by


def test_what_changes_among_samples_that_are_left_out_is_found() -> None:
    """From 27 s on the body stands still; the samples after 21 s cannot be fitted."""
    honest = noisy(library_scene("separatrix-exactly"), 1e-2, is_stated=False)
    at, arrays = 270, {name: honest.arrays[name].copy() for name in ("t", "q", "omega")}
    arrays["omega"][at:] -= arrays["omega"][at:].mean(axis=0)
    found = replace(honest, arrays=arrays).judged()
    (words,) = found.explained_by
    assert words.startswith("until t = 26.9 s it is the exact motion with noise")
    assert found.is_beyond


def test_a_start_that_is_not_finite_leads_to_no_motion() -> None:
    one = case(36)
    exact = solve(one.scenario, one.scenario.times).trajectory
    has = {"is_stated": True, "has_omega": True}
    log = log_of(one.scenario, exact, exact, np.ones(2), **has)
    starts = np.zeros((3, 6))
    starts[1:, 0] = np.inf, 1e200
    made = log.made(log.base.repeated(3).of(start=starts), log.t)
    assert np.isfinite(made[0]).all()
    assert np.isnan(made[1:, 1:]).any(axis=(1, 2)).all()


def test_what_a_solver_leaves_is_no_measured_noise() -> None:
    one = case(31, duration=2.0, samples=101)
    chance = np.random.default_rng(1)
    arrays = stepped(one.scenario, rates_of(one), 1, 0.02, chance)
    arrays["omega"] += chance.normal(0, 1e-5, arrays["omega"].shape)
    turned = Rotation.from_rotvec(chance.normal(0, 1e-5, arrays["omega"].shape))
    q = Rotation.from_quat(arrays["q"], scalar_first=True) * turned
    found = judged(one.scenario, arrays | {"q": q.as_quat(scalar_first=True)}, 0.02)
    assert found.measured is None
    assert not found.is_another


@pytest.mark.parametrize("degrees", [0.0, 40.0])
def test_a_recording_that_begins_late_is_off_by_its_methods_errors_and_no_more(
    degrees: float,
) -> None:
    one = case(33)
    arrays = stepped(one.scenario, rates_of(one), 1, 0.02, np.random.default_rng(1))
    turn = Rotation.from_rotvec([np.radians(degrees), 0, 0])
    q = (turn * Rotation.from_quat(arrays["q"], scalar_first=True)).as_quat(scalar_first=True)
    late = {"t": arrays["t"][50:], "q": q[50:], "omega": arrays["omega"][50:]}
    words = judged(one.scenario, late, 0.02).explained_by
    assert [one.startswith("it started elsewhere: at t = 1 s") for one in words] == (
        [True] if degrees else []
    )


def test_an_omega_that_lags_is_told_without_noise() -> None:
    """By one and a half samples: no whole number of them."""
    fine = case(34, samples=2001)
    arrays, late = exactly(fine, rates_of(fine)), 15
    at = np.arange(20, 2001, 10)
    read = {"t": arrays["t"][at], "q": arrays["q"][at], "omega": arrays["omega"][at - late]}
    (words,) = judged(fine.scenario, read, 1e-4).explained_by
    assert words.startswith("ω lags the attitude by 0.03 s")


def test_a_first_sample_before_an_engines_correction_is_told() -> None:
    one = case(35)
    arrays = exactly(one, rates_of(one))
    arrays["omega"][0] += 0.1
    (words,) = judged(one.scenario, arrays, 1e-4).explained_by
    assert words.startswith("the first sample is off what follows by ")
