"""Verdicts on made-up ladders whose errors are known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scene_texts import sphere_text
from scipy.spatial.transform import Rotation
from spincheck.reference import Solution
from spincheck.reports.harness.judging.best_window import SHARP
from spincheck.reports.harness.judging.observed_order import observed_order
from spincheck.reports.harness.judging.sequences import sequence
from spincheck.reports.harness.judging.signal_ladder import Judgement, judge_signal
from spincheck.reports.harness.measuring.asymptotic import DISTINCT
from spincheck.reports.harness.measuring.richardson import RichardsonLadder
from spincheck.scenarios import EVERYWHERE, SIGNAL, Errors, Trajectory, loads

SCENE = loads(sphere_text((0.0, 0.0, 3.0), duration=5.0, samples=51), "sphere")
TIMES = SCENE.times
EPS = float(np.finfo(float).eps)
SPIN = 3.0
COARSEST = 0.05
#: To which body and start are held, relative: a few ulp.
PRECISION = 4 * EPS
TURNED = ["omega", "attitude"]

Shape = Callable[[float], np.ndarray]


def turning(error: np.ndarray, **shifted: np.ndarray) -> Trajectory:
    """A steady spin about z, its angle (rad) and its speed (relative) off by `error`, (n,)."""
    q = Rotation.from_rotvec(np.outer(SPIN * TIMES + error, [0, 0, 1])).as_quat(scalar_first=True)
    still = np.zeros((len(TIMES), 3))
    omega = np.outer(SPIN * (1 + error), [0, 0, 1])
    columns = {"com_world": still, "velocity_world": still} | shifted
    return Trajectory(TIMES, q, omega, **columns)


EXACT = turning(0 * TIMES)


def ladder(
    error_of_dt: Shape, order: int, rungs: int = 8, growth: float = EPS, uncertainty: float = EPS
) -> RichardsonLadder:
    """Rungs whose angle and speed are off by `error_of_dt(dt)`, (n,)."""
    solution = Solution(EXACT, "made up", Errors(*[uncertainty] * 6), Errors(*[growth] * 6))
    rungs_of = RichardsonLadder(SCENE, solution, order, order, PRECISION)
    for k in range(rungs):
        dt = COARSEST / 2**k
        rungs_of.add(dt, turning(error_of_dt(dt)), round(TIMES[-1] / dt))
    return rungs_of


def judge_in(rungs: RichardsonLadder, signal: str) -> Judgement:
    return judge_signal(sequence(rungs.judged, signal))


def judged(error_of_dt: Callable[[float], float], order: int, signal: str = "omega", **noise):
    """Of rungs that are off by `error_of_dt(dt)` times a shape in time."""
    return judge_in(ladder(lambda dt: error_of_dt(dt) * np.sin(TIMES), order, **noise), signal)


@pytest.mark.parametrize("signal", TURNED)
@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_method_of_its_declared_order_converges_to_a_limit_known_to_a_few_times_its_error(
    signal, order
):
    judgement = judged(lambda dt: dt**order + dt ** (order + 1), order, signal)
    assert judgement.word == "converges"
    assert judgement.order == pytest.approx(order, abs=0.25)
    assert judgement.limit_error <= judgement.tolerance
    assert judgement.extrapolation_tolerance <= 8 * judgement.limit_error


@pytest.mark.parametrize("signal", TURNED)
@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_limit_that_is_not_the_exact_motion_disagrees(signal, order):
    offset = 10 * (COARSEST / 2**5) ** order
    judgement = judged(lambda dt: offset + dt**order + dt ** (order + 1), order, signal)
    assert judgement.word == "disagrees"
    assert judgement.limit_error == pytest.approx(offset, rel=0.1)
    assert SIGNAL[signal].words(judgement.limit_error) in judgement.reason


def test_a_limit_far_off_disagrees_however_large_or_small_the_other_errors_are():
    judgement = judged(lambda dt: 0.5 + 2 * dt, order=1, rungs=5)
    assert judgement.tolerance > SHARP or judgement.extrapolation_tolerance < 0.5
    assert judgement.word == "disagrees"
    # Such as of a rule that is exact for parabolas, on a wrong parabola.
    assert judged(lambda dt: 0.5 + EPS * np.sign(np.sin(1 / dt)), order=4).word == "disagrees"


def test_a_limit_that_leaves_the_exact_motion_midway_says_when():
    late = np.where(TIMES > 3.0, 1e-3, 0.0)
    judgement = judge_in(ladder(lambda dt: late + dt**2 * np.sin(TIMES), 2), "omega")
    assert judgement.word == "disagrees"
    since = float(judgement.reason.partition("from t = ")[2].split()[0])
    assert since == TIMES[TIMES > 3.0][0]


def test_the_numbers_of_a_limit_that_is_wrong_are_those_that_show_it():
    """Later on, rungs that do not settle make its tolerance larger than its error."""
    wild = TIMES > 4.0

    def error(dt: float) -> np.ndarray:
        return 1e-2 * (TIMES > 1.0) + dt * np.sin(TIMES) + np.sin(1 / dt) * wild

    judgement = judge_in(ladder(error, order=1), "omega")
    assert judgement.word == "disagrees"
    assert judgement.limit_error > DISTINCT * judgement.tolerance
    assert f"error is {judgement.limit_error:.1e}" in judgement.reason


def test_a_damping_that_every_rung_is_through_with_is_not_taken_for_a_limit():
    """A wobble that first order damps at Ω (hΩ) / 2 a second, seen when all of it is gone."""
    fast = replace(EXACT, omega_body=100 * EXACT.omega_body, t=400 * EXACT.t)
    solution = Solution(fast, "made up", Errors(*[EPS] * 6), Errors(*[EPS] * 6))
    sequences = RichardsonLadder(SCENE, solution, 1, 1, PRECISION)
    gap = 1e-3 * 300 * np.outer(TIMES > 0, [1, 0, 0])
    for k in range(8):
        run = replace(fast, omega_body=fast.omega_body - gap * (1 + 1e-3 / 2**k))
        sequences.add(1e-3 / 2**k, run, 1 << k)
    assert judge_in(sequences, "omega").word == "unresolved"


def test_a_signal_that_is_zero_but_for_rounding_in_finer_runs_is_undefined():
    still = np.zeros((len(TIMES), 3))
    rest = replace(EXACT, omega_body=still)
    solution = Solution(rest, "made up", Errors(*[EPS] * 6), Errors(*[EPS] * 6))
    sequences = RichardsonLadder(SCENE, solution, 4, 4, PRECISION)
    for k in range(6):
        creeping = replace(
            rest, omega_body=still + (k > 2) * EPS**2 * np.sin(2.0**k * TIMES)[:, None]
        )
        sequences.add(COARSEST / 2**k, creeping, 100 << k)
    judgement = judge_in(sequences, "omega")
    words = "undefined: the exact angular velocity is zero, that of runs is not"
    assert (judgement.word, judgement.reason) == ("unresolved", words)


@pytest.mark.parametrize(("declared", "seen_order"), [(4, 1), (4, 2), (2, 1)])
def test_an_order_below_the_declared_one_disagrees(declared, seen_order):
    judgement = judged(lambda dt: 0.1 * dt**seen_order, declared)
    assert judgement.word == "disagrees"
    assert f"order {seen_order}.00 over 4 rungs, though {declared} is declared" in judgement.reason
    # Of the finest rungs, however many there are; those that rounding may make show no order.
    assert judged(lambda dt: 0.1 * dt**seen_order, declared, rungs=5).word == "disagrees"
    assert judged(lambda dt: 1e-6 * dt**seen_order, declared, growth=1e-11).word == "converges"


def test_an_order_that_is_still_rising_or_above_the_declared_one_converges():
    assert judged(lambda dt: 1e3 * dt**4 + 1e1 * dt**3 * (dt > 0.02), 4).word == "converges"
    judgement = judged(lambda dt: dt**2, order=1)
    assert judgement.word == "converges"
    assert "or better" in judgement.reason


def test_errors_that_grow_as_steps_shrink_disagree_and_are_reported():
    judgement = judged(lambda dt: 1e-6 / dt, order=1)
    assert judgement.word == "disagrees"
    assert judgement.order == pytest.approx(-1, abs=0.01)
    assert "errors grow as the timestep shrinks" in judgement.reason
    # Those of rounding do not disagree.
    rounding = judged(lambda dt: 1e-3 * dt**4 + 1e-16 * np.sin(1e6 / dt) / dt, order=4)
    assert rounding.word == "converges"


def test_a_ladder_too_coarse_to_tell_is_unresolved_and_says_what_would_resolve_it():
    judgement = judged(lambda dt: 0.5 + 0.5 * np.sin(2000 * dt**0.5), order=1, rungs=4)
    assert judgement.word == "unresolved"
    assert judgement.needed_timestep < COARSEST / 2**3
    assert f"{TIMES[-1] / judgement.needed_timestep:.1e} steps" in judgement.reason


def test_errors_that_are_all_too_large_are_not_said_to_be_at_round_off():
    judgement = judged(lambda dt: 0.8 + 0.2 * np.sin(1 / dt), order=1, rungs=4)
    assert "too large to show an order" in judgement.reason
    assert "round-off" not in judgement.reason
    # Nor is a blurred limit a convergence.
    assert judged(lambda dt: 0.5 * dt**0.3, order=1).word == "unresolved"


def test_errors_at_round_off_throughout_converge_without_an_order_if_that_is_small():
    judgement = judged(lambda dt: 2 * EPS * np.sign(np.sin(1 / dt)), order=4)
    assert (judgement.word, judgement.order) == ("converges", None)
    assert judged(lambda dt: 0.5 + 0.1 * np.sin(1 / dt), 2, growth=1e-2).word == "unresolved"


@pytest.mark.parametrize("floor", [1e-12, 1e-9])
def test_rounding_above_its_bound_hides_neither_order_nor_limit(floor):
    """The finest rungs touch the floor; the order is that of the clean ones before."""
    judgement = judged(lambda dt: dt**4 + floor * np.sin(1e6 / dt), order=4)
    assert judgement.word == "converges"
    assert judgement.order == pytest.approx(4, abs=0.25)
    # Nor does a bound that is far too wide.
    assert judged(lambda dt: dt**4 + dt**5, order=4, growth=1e-4).word == "converges"


STEADY = ladder(lambda dt: dt * np.sin(TIMES), 1)


@pytest.mark.parametrize("signal", ["com", "velocity"])
def test_a_path_that_is_another_one_disagrees_in_that_signal_alone(signal):
    assert {judge_in(STEADY, one).word for one in EVERYWHERE} == {"converges"}
    solution = Solution(EXACT, "made up", Errors(*[EPS] * 6), Errors(*[EPS] * 6))
    sequences = RichardsonLadder(SCENE, solution, 1, 1, PRECISION)
    for k in range(8):
        dt = COARSEST / 2**k
        drift = np.outer(TIMES * (1 + dt), [1e-3, 0, 0])
        run = turning(dt * np.sin(TIMES), **{f"{signal}_world": drift})
        sequences.add(dt, run, round(TIMES[-1] / dt))
    words = {one: judge_in(sequences, one).word for one in EVERYWHERE}
    assert words[signal] == "disagrees"
    # What moves has energy too.
    disagreeing = {one for one, word in words.items() if word == "disagrees"}
    assert disagreeing <= {signal, "energy"}


@pytest.mark.parametrize("signal", TURNED)
def test_rungs_added_one_by_one_are_judged_as_all_at_once(signal):
    def error(dt: float) -> np.ndarray:
        return (dt + dt**2) * np.sin(TIMES)

    whole = ladder(error, 1)
    sequences = ladder(error, 1, rungs=4)
    for k in range(4, 8):
        judge_in(sequences, signal)
        dt = COARSEST / 2**k
        sequences.add(dt, turning(error(dt)), round(TIMES[-1] / dt))
    one_by_one, at_once = (judge_in(rungs, signal) for rungs in (sequences, whole))
    assert one_by_one.record == at_once.record
    assert one_by_one.extrapolation_tolerance == at_once.extrapolation_tolerance
    assert one_by_one.needed_timestep == at_once.needed_timestep


@pytest.mark.parametrize(
    ("source_of_noise", "size", "words"),
    [("growth", 1e-3, "a step's rounding"), ("uncertainty", 2 * SHARP, "the uncertainty of")],
)
def test_where_rounding_or_the_reference_hides_the_limit_no_timestep_is_recommended(
    source_of_noise, size, words
):
    judgement = judged(lambda dt: 0.3 * np.sin(1 / dt), 2, **{source_of_noise: size})
    assert (judgement.word, judgement.needed_timestep) == ("unresolved", None)
    assert f"no finer one would resolve it: {words}" in judgement.reason
    assert f"has grown to {size:.1e} by the end" in judgement.reason
    assert "and gets worse below it" in judgement.reason


def test_a_limit_off_by_less_than_shows_another_motion_is_said_to_be_so():
    """By twice what the uncertainty of the exact motion allows: no finer timestep would decide."""
    uncertainty = 1e-6
    judgement = judged(lambda dt: dt**4 + 2 * uncertainty, 4, uncertainty=uncertainty)
    assert (judgement.word, judgement.needed_timestep) == ("unresolved", None)
    assert "another motion is 4 tolerances off" in judgement.reason


def test_an_offset_below_the_derived_bound_of_rounding_disagrees_if_rungs_are_clean():
    """The bound adds all roundings in one direction; clean rungs show that they are less."""
    growth = 1e-14
    bound = growth * TIMES[-1] / (COARSEST / 2**7)
    judgement = judged(lambda dt: bound + dt**4 + dt**5, 4, growth=growth)
    assert judgement.word == "disagrees"
    assert judgement.limit_error == pytest.approx(bound, rel=0.1)


def test_what_conditioning_makes_as_large_as_the_motion_is_said_to_be_so():
    judgement = judged(lambda dt: 1.9 + 1e-3 * np.sin(1 / dt), 2, uncertainty=1e3)
    assert "has grown to the size of the motion itself by the end" in judgement.reason
    assert "gets worse" not in judgement.reason


def test_the_timestep_recommended_above_round_off_resolves_the_ladder():
    """All in one direction, the roundings of its steps would come to more than may be unknown."""
    growth = 2e-5

    def judged_with(rungs: int) -> Judgement:
        return judged(lambda dt: np.tanh(1e6 * dt**4), 4, rungs=rungs, growth=growth)

    judgement = judged_with(4)
    assert judgement.word == "unresolved"
    assert growth * TIMES[-1] / judgement.needed_timestep > SHARP
    rungs = 1 + int(np.ceil(np.log2(COARSEST / judgement.needed_timestep)))
    assert judged_with(rungs).word == "converges"


def test_an_order_above_the_declared_one_makes_no_limit_surer_than_declared():
    """It need not last."""

    def declared(order: int) -> Judgement:
        return judged(lambda dt: dt**2 + dt**3, order)

    assert declared(1).limit_error == declared(2).limit_error
    assert declared(1).extrapolation_tolerance > declared(2).extrapolation_tolerance


def test_an_order_is_fitted_where_it_can_be_seen():
    timesteps = COARSEST / 2.0 ** np.arange(8)
    errors = timesteps**4 + 1e-10
    bounds = np.full(8, 1e-13)
    assert observed_order(timesteps, errors, bounds, EPS) == pytest.approx(4, abs=0.25)


def test_a_judgement_is_stored_with_its_numbers():
    judgement = judge_in(STEADY, "omega")
    record = judgement.record
    assert (record.signal, record.verdict, record.declared_order) == ("omega", "converges", 1)
    assert (record.limit_error, record.tolerance) == (judgement.limit_error, judgement.tolerance)


def test_of_unresolved_signals_the_one_that_no_timestep_would_resolve_decides():
    steady = sequence(STEADY.judged, "omega")
    signals = [
        Judgement(steady, "unresolved", "never", tolerance=1.0),
        Judgement(steady, "unresolved", "never", tolerance=0.1),
        Judgement(steady, "unresolved", "late", tolerance=2.0, needed_timestep=1e-6),
        Judgement(steady, "unresolved", "soon", tolerance=2.0, needed_timestep=1e-3),
        Judgement(steady, "converges", "", tolerance=1e-3),
    ]
    assert sorted(signals, key=lambda one: one.severity, reverse=True) == signals
