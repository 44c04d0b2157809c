"""Faults of public reports, and of people's own code, are explained in the right words.

A body in skew axes is computed by another integrator than the one that explains it; the reports are
those of engines and converters that had such a fault.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numba
import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library_scene
from measure_logs import measured as log_of_kind
from planted_motions import Case, case, exactly, product, rates_of, stepped
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from spincheck.reference import compiled, following, solve
from spincheck.reference.following import follow
from spincheck.reference.other_equations import equations_of
from spincheck.reports.harness.explaining.effect_changes import resistance
from spincheck.reports.harness.explaining.hypothesis import Change, as_it_is
from spincheck.reports.harness.explaining.search import SIGNIFICANCE, Search
from spincheck.reports.harness.recorded.files.recording import Recording, RecordingError
from spincheck.reports.harness.recorded.fits.log_fit import SHARED
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.samples.intervals import Intervals
from spincheck.scenarios import Scenario
from spincheck.scenarios.scenario import started_at

pytestmark = pytest.mark.slow

BODY = case(7)
MOMENTS = np.linalg.eigvalsh(BODY.inertia)
#: In the fewer samples of a log a body that tumbles, and one whose ω' is 0.08 rad/s² at most.
LOG, STEADY = case(1, samples=101), case(7, samples=101)
Read = Callable[[np.ndarray, np.ndarray], np.ndarray]
#: Scenes with moments that are far apart, from rest, or much faster than they change.
HARD = [
    "needle-in-skew-axes",
    "spinning-needle",
    "rod-1e-12",
    "pushed-from-rest",
    "reaction-wheel",
    "ship-stabiliser",
]
WRONG_SIDE = "q' = ½ ω q, as if ω were along world axes: the product is on the wrong side"
KINEMATICS = "ω obeys Euler's equations, but the attitude does not follow ω: "


def judged(scenario: Scenario, arrays: dict[str, np.ndarray], **stated: object) -> JudgedMotion:
    settings = {name: str(value) for name, value in stated.items()}
    return judged_motion(scenario, Recording(Path("motion.csv"), arrays, settings))


def unnormalised(q: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """ω along body axes, on the side of world axes."""
    return product(np.array([0, *omega]), q) / 2


def test_quaternions_that_are_not_normalised_are_with_a_remark() -> None:
    one = case(7, duration=2.0, samples=201)
    q, omega = one.scenario.start.q_world_body_wxyz, one.scenario.start.omega_body
    rates, states = rates_of(one), []
    for _ in one.scenario.times:
        states.append(np.concatenate([q, omega]))
        dq, domega = rates(q / np.linalg.norm(q), omega)
        q, omega = q + 0.01 * dq * np.linalg.norm(q), omega + 0.01 * domega
    table = np.array(states)
    arrays = {"t": one.scenario.times, "q": table[:, :4], "omega": table[:, 4:]}
    found = judged(one.scenario, arrays, timestep=0.01)
    assert found.made_by == "what explicit Euler at 0.01 s makes"
    (remark,) = found.remarks
    length = np.linalg.norm(table[-1, :4])
    assert remark.startswith("the quaternions drift off the unit sphere, by ")
    assert f"to a norm of {length:.4g} at 2 s; they were normalised" in remark


def measured(
    one: Case, attitude: float, omega: float, read: Read = lambda omega, t: omega, **changes: object
) -> dict[str, np.ndarray]:
    """A motion with noise, rad and rad/s, with ω as a gyroscope reads it."""
    arrays, chance = exactly(one, rates_of(one, **changes)), np.random.default_rng(1)
    n = len(arrays["t"])
    noise = Rotation.from_rotvec(chance.normal(0, attitude, (n, 3)))
    turned = Rotation.from_quat(arrays["q"], scalar_first=True) * noise
    return arrays | {
        "q": turned.as_quat(scalar_first=True),
        "omega": read(arrays["omega"], arrays["t"]) + chance.normal(0, omega, (n, 3)),
    }


NOISE = np.radians(0.3), 0.02
#: What a gyroscope makes of ω, the words, and the numbers in them.
GYROSCOPES: dict[str, tuple[Read, str, list[float]]] = {
    "nothing": (lambda omega, t: omega, "", []),
    "a bias": (
        lambda omega, t: omega + 0.1 * np.eye(3)[0],
        "the gyroscope has a bias of ",
        [0.1, 0, 0],
    ),
    "a scale": (
        lambda omega, t: omega * [1.05, 1, 1],
        "the gyroscope's axes read ",
        [1.05, 1, 1],
    ),
    "other axes": (
        lambda omega, t: omega @ Rotation.from_rotvec([0.05, 0, 0]).as_matrix(),
        "the gyroscope's axes are turned against the body's by ",
        [np.degrees(0.05), 0, 0],
    ),
    "a lag": (
        lambda omega, t: omega - 0.03 * np.gradient(omega, t, axis=0),
        "ω lags the attitude by ",
        [0.03],
    ),
}


@pytest.mark.parametrize(
    ("error", "is_stated"), [("nothing", False), ("a lag", False), *((e, True) for e in GYROSCOPES)]
)
def test_a_gyroscopes_mistake_is_named_and_nothing_that_noise_explains(
    error: str, is_stated: bool
) -> None:
    read, words, numbers = GYROSCOPES[error]
    stated = {"noise_attitude": NOISE[0], "noise_omega": NOISE[1]} if is_stated else {}
    found = judged(LOG.scenario, measured(LOG, *NOISE, read), **stated)
    assert len(found.explained_by) == bool(words)
    sentence = "".join(found.explained_by).replace("[", "")
    assert sentence.startswith(words)
    # In so much noise a lag is not told from a low-pass filter, which is named beside it.
    each = re.findall(r"(\S+) ± ([\d.e-]+)", sentence.partition(", or ")[0])
    assert len(each) == len(numbers)
    for (number, off), wanted in zip(each, numbers, strict=True):
        # Five standard errors are exceeded by chance once in a million logs.
        assert abs(float(number) - wanted) < 5 * float(off)
    assert not found.is_beyond
    assert f"which is {'stated' if is_stated else 'estimated'}: χ² is " in found.verdict


@pytest.mark.parametrize("is_stated", [False, True])
def test_a_lag_of_a_steady_body_is_no_other_start(is_stated: bool) -> None:
    """Another start makes much of the same difference, with six numbers instead of one."""
    noise, read = (NOISE[0], 0.002), GYROSCOPES["a lag"][0]
    stated = {"noise_attitude": noise[0], "noise_omega": noise[1]} if is_stated else {}
    (words,) = judged(STEADY.scenario, measured(STEADY, *noise, read), **stated).explained_by
    assert words.startswith("ω lags the attitude by 0.03")


def test_another_start_is_found_in_noise_with_its_size() -> None:
    start = STEADY.scenario.start
    faster = np.add(start.omega_body, [0.1, 0, 0])
    elsewhere = started_at(
        STEADY.scenario,
        *(start.q_world_body_wxyz, faster),
        *(start.position_world, start.velocity_world),
    )
    found = judged(STEADY.scenario, measured(replace(STEADY, scenario=elsewhere), *NOISE))
    (words,) = found.explained_by
    assert words.startswith("it started elsewhere: at t = 0 s the attitude is off by 0.")
    assert 0.05 < float(words.split()[-2]) < 0.15


def test_a_log_that_another_change_explains_is_within_its_estimated_noise() -> None:
    found = judged(LOG.scenario, measured(LOG, *NOISE, turning=unnormalised), timestep=1e-4)
    assert found.verdict.startswith("within a noise of 0.")
    assert "which is estimated" in found.verdict
    assert list(found.explained_by) == [KINEMATICS + WRONG_SIDE]


def test_another_moment_is_found_in_noise_with_its_standard_error() -> None:
    moments, axes = np.linalg.eigh(LOG.inertia)
    heavier = (axes * (moments * [1.0, 1.05, 1.0])) @ axes.T
    found = judged(LOG.scenario, measured(LOG, np.radians(0.06), 0.001, inertia=heavier))
    assert [words.partition(" were ")[0] for words in found.explained_by] == [
        "it moves as if the tensor"
    ]
    assert found.measured is not None
    entries, errors = found.measured.tensor_entries()
    scaled = heavier * np.trace(LOG.inertia) / np.trace(heavier)
    wanted = scaled[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    # Of six numbers none is off by five standard errors, but by chance in a million logs.
    assert np.all(np.abs(entries - wanted) < 5 * errors)
    assert np.all(errors < 0.01 * np.trace(LOG.inertia))


@pytest.mark.parametrize("log", [10, 46])
def test_where_a_log_hardly_shows_a_tensor_its_errors_are_as_large(log: int) -> None:
    """Of moments within 3 %, others hundreds of errors off are hidden by noise, or nearly."""
    _, fit, tensor, _ = log_of_kind(log)
    assert fit is not None
    assert not fit.is_beyond
    entries, errors = fit.tensor_entries()
    # Of six numbers none is off by five standard errors, but by chance in a million logs.
    assert np.all(np.abs(entries - tensor) < 5 * errors)


def test_a_log_is_measured_if_its_attitudes_alone_are_seen_to_be() -> None:
    """Its ω hardly alternates, as by the guess of the tensor it is off by a smooth part besides."""
    _, fit, tensor, _ = log_of_kind(117)
    assert fit is not None
    entries, errors = fit.tensor_entries()
    assert np.all(np.abs(entries - tensor) < 5 * errors)


def test_mistakes_of_a_gyroscope_that_a_log_does_not_tell_apart_are_both_named() -> None:
    """ω of log 358 hardly changes: by its noise a scale is likelier than the bias that it has."""
    _, fit, _, bias = log_of_kind(358)
    assert fit is not None
    (sentence,) = (words for words in fit.explained() if "gyroscope" in words)
    first, _, (second, likely) = *sentence.partition(", or ")[:2], sentence.rsplit(" (", 1)
    assert first.startswith("the gyroscope's axes read ")
    assert ", or the gyroscope has a bias of " in second
    assert re.fullmatch(r"0\.\d+ times as likely\)", likely)
    scale = next(change for change in fit.fit.changes if change.kind == "scale")
    ((times, other, instead),) = fit.alternatives(scale)
    falls = np.sum(fit.found.residuals**2) - np.sum(instead.residuals**2)
    # The noise is estimated: its variance is known to five standard errors of so many numbers.
    assert np.log(times) == pytest.approx(falls / 2, rel=5 * np.sqrt(2 * SHARED / fit.freedom))
    rows = instead.columns(other)
    assert np.all(np.abs(instead.parameters[rows] - bias) < 5 * instead.errors[rows])


def test_a_timestep_longer_than_samples_are_apart_is_refused() -> None:
    arrays = exactly(BODY, rates_of(BODY))
    with pytest.raises(RecordingError, match=r"stated as 0\.021 s, but .* than 0\.02 s apart"):
        judged(BODY.scenario, arrays, timestep=0.021)
    assert not judged(BODY.scenario, arrays, timestep=0.02).is_another


def test_noise_is_estimated_to_its_standard_error() -> None:
    one = case(7, samples=1201)
    found = judged(one.scenario, measured(one, *NOISE)).measured
    assert found is not None
    # Each is of three numbers a sample.
    assert found.log.noise == pytest.approx(NOISE, rel=5 / np.sqrt(2 * 3 * 1201))


@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_an_omega_that_alternates_is_no_noise(noise: float) -> None:
    """As of a trapezoidal rule that begins with accelerations of zero; it turns with the body."""
    arrays, size = measured(BODY, noise, noise), 0.01
    axis = Rotation.from_quat(arrays["q"], scalar_first=True).apply([0, 0, 1], inverse=True)
    arrays["omega"] += size * axis * (-1.0) ** np.arange(len(axis))[:, None]
    found = judged(BODY.scenario, arrays, timestep=1e-4)
    assert found.is_beyond
    assert found.measured is None
    (words,) = found.explained_by
    assert words.startswith(f"ω alternates from one sample to the next, by ± {size:.2g} rad/s")


def test_noise_that_is_stated_too_small_is_told() -> None:
    arrays = measured(LOG, *NOISE)
    found = judged(LOG.scenario, arrays, noise_attitude=NOISE[0] / 2, noise_omega=NOISE[1])
    assert found.verdict.startswith("beyond a noise of 0.15° in attitude")
    assert found.is_beyond


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_an_honest_method_is_not_accused(order: int) -> None:
    one = case(30 + order, is_pivoted=order % 2 == 0, duration=2.0, samples=101)
    arrays = stepped(one.scenario, rates_of(one), order, 0.01, np.random.default_rng(order))
    found = judged(one.scenario, arrays, timestep=0.01)
    assert found.explained_by == ()
    assert not found.is_beyond


@each_case("name", HARD)
def test_an_exact_motion_of_a_hard_scene_is_not_accused(name: str) -> None:
    """Rounding of ω moves a needle by as much as its moments are apart."""
    scene = library_scene(name)
    rate = max(equations_of(scene).rate, float(np.linalg.norm(scene.start.omega_body)))
    times = np.linspace(0.0, min(scene.window.duration, 20 / (rate or 1.0)), 121)
    motion = solve(scene, times).trajectory
    arrays = {"t": times, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    found = judged(scene, arrays, timestep=float(times[1] / 64))
    assert not found.is_another
    assert not found.made_by


@pytest.mark.parametrize("is_alone", [True, False])
def test_one_change_among_a_hundred_must_be_a_hundred_times_less_likely_by_chance(
    is_alone: bool,
) -> None:
    """The fall of χ² is between what is called for of one change, and of a hundred."""
    base = as_it_is(BODY.scenario)
    (drag,) = resistance(BODY.scenario, base)
    starts = np.tile([1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 2.0], (12, 1))
    spans = np.linspace(0.01, 0.2, 12)[:, None]
    ends = follow(drag.apply(base[None], np.array([[1e-3]]))[0], starts, spans)[:, 0]
    fall = chi2.isf(SIGNIFICANCE / 10, 1)
    exact = Intervals(base, starts, spans[:, 0], spans, ends, np.ones(2), np.zeros((12, 2)))
    noise = np.full(2, np.linalg.norm(exact.apart(base)) / np.sqrt(fall))
    others = [] if is_alone else [Change("sphere", lambda h, _: h, np.empty(0))] * 99
    found = Search(replace(exact, noise=noise), [drag, *others]).one_or_two()
    assert (found is not None) == is_alone


def test_what_judge_follows_is_compiled_with_the_other_kernels(monkeypatch) -> None:
    """By the types of arguments: what an earlier test compiled makes no difference."""
    calls, follow = [], following._follow

    def noted(*args: object) -> None:
        calls.append(tuple(map(numba.typeof, args)))
        follow(*args)

    monkeypatch.setattr(following, "_follow", noted)
    compiled.compile_flow()
    of_compiled = set(calls)
    found = judged(BODY.scenario, exactly(BODY, rates_of(BODY, inertia=MOMENTS.mean() * np.eye(3))))
    judged(LOG.scenario, measured(LOG, *NOISE))
    assert found.explained_by
    assert len(calls) > 100
    assert set(calls) == of_compiled
