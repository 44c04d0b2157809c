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
from spincheck.reports.harness.judging.ladder_end import GOAL
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.timesteps.ladder import DECIDED_STEPS, MAX_STEPS, MIN_RUNGS
from spincheck.reports.results.evidence import CONSISTENT, SEEN, StepEvidence
from spincheck.scenarios import Scenario, Trajectory, loads

#: What steps of a method that converges show.
KNOWN = StepEvidence(17, 0.5, 0.0, 0.0, 1)
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
    return ConvergenceStudy(scene, engine(), method, made.solution, made.ladder, steps=KNOWN)


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


def test_small_errors_end_a_ladder():
    convergence = go_down(study(), lambda dt: 0.1 * dt**4)
    assert judge(convergence.records).verdict == "converges"
    assert MIN_RUNGS <= len(convergence.rows) < len(convergence.ladder.rungs)
    last = convergence.rows[-1]
    assert max(value for _, value in last.errors) <= GOAL
    assert not convergence.cut_short


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
    ("known_to", "of_an_effect", "words"),
    [
        (2 * CONSISTENT, 0.0, f"is known to {2 * CONSISTENT:.2g} of the largest terms only"),
        (0.0, 2 * SEEN, f"is known to {2 * SEEN:.2g} of the weakest effect only"),
        (0.0, 0.0, ""),
    ],
)
def test_what_is_not_known_well_enough_is_said_whatever_the_ladder(known_to, of_an_effect, words):
    for error_of_dt in (wandering, lambda dt: 0.1 * dt):
        convergence = study()
        convergence.steps = replace(KNOWN, known_to=known_to, of_an_effect=of_an_effect)
        verdict = judge(go_down(convergence, error_of_dt).records)
        assert verdict.verdict == ("unresolved" if words else "converges")
        assert words in verdict.reason


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


@pytest.mark.parametrize("speed", [3.0, 400.0])
def test_a_ladder_is_no_longer_than_what_decides_takes(speed):
    """Of errors whose goal is out of reach."""
    whole, short = (
        go_down(study(speed, max_steps=limit), lambda dt: dt**0.5)
        for limit in (MAX_STEPS, DECIDED_STEPS)
    )
    assert not whole.cut_short
    assert not short.cut_short
    assert [row.timestep for row in whole.rows] == [row.timestep for row in short.rows]


def test_what_a_short_ladder_or_none_left_open_is_reported_as_cut_short():
    assert go_down(study(max_steps=400), wandering).cut_short
    convergence = go_down(study(max_steps=10), lambda dt: 0.1)
    assert convergence.rows == []
    assert convergence.cut_short


@pytest.mark.parametrize("speed", [2e5, 2e8])
def test_where_no_ladder_fits_single_steps_decide(speed):
    convergence = go_down(study(speed), lambda dt: 0.1)
    assert (judge(convergence.records).verdict, convergence.rows) == ("converges", [])
    convergence.steps = None
    assert judge(convergence.records).verdict == "unresolved"
    assert bool(convergence.above_rows) == (speed == 2e5)


def test_where_no_ladder_fits_what_cannot_be_simulated_is_still_reported():
    class Lacking(MadeUp):
        methods = (replace(METHOD, requires=frozenset({"pivot"})),)

    assert judge(study(2e8, engine=Lacking).records).verdict == "unsupported"
