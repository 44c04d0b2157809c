"""Which rungs a method is run on, by results made up for each."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from case_loops import each_case
from scene_texts import sphere_text
from scipy.spatial.transform import Rotation
from spincheck.engines import Engine, Method, Run
from spincheck.reports.harness.convergence_study import ConvergenceStudy
from spincheck.reports.harness.executors import Answer
from spincheck.reports.harness.judging import judge
from spincheck.reports.harness.judging.ladder import RUNGS_OF_A_LIMIT
from spincheck.reports.harness.judging.ladder_end import GOAL
from spincheck.reports.harness.judging.local import CONSISTENT, SEEN
from spincheck.reports.harness.ladder import DECIDED_STEPS, MAX_STEPS, MIN_RUNGS
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.results.evidence import JudgedLadder, LocalEvidence
from spincheck.scenarios import Scenario, Trajectory, loads

METHOD = Method("made-up", 1, 1, "made up", frozenset())


class MadeUp(Engine):
    """Never asked to simulate."""

    name = "made-up"
    version = "1"
    methods = (METHOD,)

    def open(self, scenario: Scenario, method: Method, timestep: float):
        raise AssertionError("results are made up")


def study(
    speed: float = 3.0, max_steps: int = MAX_STEPS, engine: type[Engine] = MadeUp
) -> ConvergenceStudy:
    scene = loads(sphere_text((0.0, 0.0, speed), 4.0, samples=41), "sphere")
    made, (method,) = prepare(scene, [], max_steps), engine.methods
    return ConvergenceStudy(scene, engine(), method, made.solution, made.ladder)


def off_by(error: float, exact: Trajectory) -> Trajectory:
    """The exact motion, its attitude turned and its ω quickened by an error growing from 0, rad."""
    growing = error * exact.t / exact.t[-1]
    turn = Rotation.from_rotvec(np.outer(growing, [0, 0, 1]))
    omega = exact.omega_body * (1 + growing[:, None])
    q = (turn * exact.R_world_body).as_quat(scalar_first=True)
    return replace(exact, q_world_body_wxyz=q, omega_body=omega)


def go_down(
    convergence: ConvergenceStudy,
    error_of_dt: Callable[[float], float],
    dies_above: float = np.inf,
    dies_at: Callable[[float], float] = float,
):
    """Answer rungs of more than `dies_above` seconds a step by a blow-up, at a time by the step."""
    runs, row = convergence.runs(), None
    with suppress(StopIteration):
        while asked := runs.send(row):
            rung = asked.rung
            motion = off_by(error_of_dt(rung.timestep), asked.solution.trajectory)
            keywords = {"trajectory": motion, "steps": rung.steps}
            outcome = "ok"
            if rung.timestep > dies_above:
                outcome, keywords = "diverged", {"stopped_at": dies_at(rung.timestep)}
            run = Run("made-up", "1", "made-up", rung.timestep, outcome, **keywords)
            row = convergence.compare(asked, Answer(run))
    return convergence


def wandering(dt: float) -> float:
    """An error that no halving makes less."""
    return 0.9 + 0.8 * np.sin(1e4 / dt)


def test_a_limit_known_well_ends_a_ladder():
    convergence = go_down(study(), lambda dt: 0.1 * dt)
    assert judge(convergence.records).verdict == "converges"
    assert MIN_RUNGS <= len(convergence.rows) < len(convergence.ladder.rungs)
    assert judge(convergence.records).tolerance <= 2 * GOAL
    assert judge(convergence.records).ground == "over the whole window"
    assert not convergence.cut_short
    elsewhere = judge(go_down(study(), lambda dt: 0.01 + 0.1 * dt).records)
    assert (elsewhere.verdict, elsewhere.ground) == ("disagrees", "")


def test_a_blow_up_that_a_shorter_timestep_does_not_delay_ends_a_ladder():
    ended, delayed = (
        go_down(study(), lambda dt: 0.0, 0.0, dies_at=law)
        for law in (lambda dt: 0.5, lambda dt: 1e-3 / dt)
    )
    assert len(ended.rows) == 2
    assert len(delayed.rows) == len(delayed.ladder.rungs)
    verdict = judge(ended.records)
    assert verdict.verdict == "diverges"
    assert f"at 0.5 s, with a timestep of {ended.rows[-1].timestep:.3g} s" in verdict.reason


@each_case(
    ("is_open", "tolerance", "of_an_effect", "words"),
    [
        (True, 0.0, 0.0, "where next to nothing acts, steps leave what may add up"),
        (False, 2 * CONSISTENT, 0.0, f"{2 * CONSISTENT:.2e} of the largest terms only"),
        (False, 0.0, 2 * SEEN, f"{2 * SEEN:.2e} of the weakest effect only"),
        (False, 0.0, 0.0, "over 115° from exact states it is unresolved, too"),
    ],
)
def test_why_pieces_do_not_decide_is_said_where_the_window_does_not(
    is_open, tolerance, of_an_effect, words
):
    for error_of_dt, is_said in ((wandering, True), (lambda dt: 0.1 * dt, False)):
        convergence = study()
        convergence.local = LocalEvidence(
            "", 0.0, tolerance, is_open, states=1, of_an_effect=of_an_effect
        )
        reason = judge(go_down(convergence, error_of_dt).records).reason
        assert (words in reason, "pieces do not decide: " in reason) == (is_said, is_said), reason


@pytest.mark.parametrize(
    ("dies_above", "survived"), [(2.5, [True, False]), (0.75, [])], ids=["later", "at once"]
)
def test_timesteps_above_the_ladder_are_doubled_while_they_survive(dies_above, survived):
    convergence = study()
    coarsest = convergence.ladder.rungs[0].timestep
    go_down(convergence, lambda dt: 0.1 * dt, dies_above * coarsest)
    assert [row.survived for row in convergence.above_rows] == survived
    assert judge(convergence.records).verdict == "converges"


def test_what_is_run_above_takes_no_part_in_the_verdict_and_its_samples_are_not_kept():
    whole = go_down(study(), lambda dt: 0.1 * dt)
    bare = study()
    bare.ladder = replace(bare.ladder, above=())
    assert whole.above_rows
    assert judge(go_down(bare, lambda dt: 0.1 * dt).records) == judge(whole.records)
    assert all(row.motion is None for row in whole.above_rows)
    assert whole.rows[-1].timestep not in whole.discardable_timesteps()


def test_errors_that_are_large_are_followed_to_where_they_tell_if_they_shrink():
    """Given up too early it would say unresolved."""
    given_up = go_down(study(), wandering)
    assert MIN_RUNGS <= len(given_up.rows) < len(given_up.ladder.rungs)
    assert judge(given_up.records).verdict == "unresolved"
    convergence = study()
    finest = convergence.ladder.rungs[-1].timestep
    small = 0.02 / finest
    go_down(convergence, lambda dt: small * dt / (1 + small * dt))
    assert judge(convergence.records).verdict == "converges"


@pytest.mark.parametrize("speed", [3.0, 400.0, 1.5e3])
@pytest.mark.parametrize("error_of_dt", [wandering, lambda dt: dt**0.5], ids=["lost", "slow"])
def test_where_pieces_decide_a_ladder_is_as_short_as_its_limit(speed, error_of_dt):
    """Slow, so that the goal is out of reach; fast, so that the first rungs exceed its limit."""
    evidence = go_down(study(), lambda dt: 0.1 * dt).evidence
    pieces = JudgedLadder(evidence.basis, evidence.rungs)
    decided = LocalEvidence("", 0.0, 0.0, is_open=False, states=1, starts=1, pieces=pieces)
    whole, short = (study(speed, max_steps=limit) for limit in (MAX_STEPS, DECIDED_STEPS))
    for convergence in (whole, short):
        convergence.local = decided
        go_down(convergence, error_of_dt)
        assert not convergence.cut_short
    assert [row.timestep for row in whole.rows] == [row.timestep for row in short.rows]
    longer = go_down(study(speed), error_of_dt)
    assert len(longer.rows) > len(whole.rows) or error_of_dt is wandering


def test_what_a_short_ladder_or_none_left_open_is_reported_as_cut_short():
    assert go_down(study(max_steps=400), wandering).cut_short
    convergence = go_down(study(max_steps=10), lambda dt: 0.1)
    assert convergence.rows == []
    assert convergence.cut_short


@pytest.mark.parametrize("speed", [2e5, 2e8])
def test_where_no_ladder_fits_the_verdict_says_what_one_would_take(speed):
    convergence = go_down(study(speed), lambda dt: 0.1)
    verdict = judge(convergence.records)
    assert (verdict.verdict, convergence.rows) == ("unresolved", [])
    assert f"{convergence.ladder.least_steps * (2**RUNGS_OF_A_LIMIT - 1):.1e}" in verdict.reason
    assert bool(convergence.above_rows) == (speed == 2e5)


def test_where_no_ladder_fits_what_cannot_be_simulated_is_still_reported():
    class Lacking(MadeUp):
        methods = (replace(METHOD, requires=frozenset({"pivot"})),)

    assert judge(study(2e8, engine=Lacking).records).verdict == "unsupported"
