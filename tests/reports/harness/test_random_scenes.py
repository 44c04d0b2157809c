"""The study of random scenes: single scenes of it, and what it counts as wrong."""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from measure_random import is_too_sure, is_wrong, judged, random_scene
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.reports.harness.judging import contradictions
from spincheck.reports.harness.measuring import richardson
from spincheck.reports.harness.measuring.rounding import roundings_in_flight
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.results.verdicts import Verdict

pytestmark = pytest.mark.slow

MUJOCO = engines()["mujoco"]
RK4 = MUJOCO.method("RK4")
#: The number of a scene whose body falls for 98 s, up to 957 m/s.
FALLS_FAST = 264
#: The number of one whose motion is too uncertain by its end for any verdict but `unresolved`.
CHAOTIC = 30
STEPS = 1 << 15
#: One that methods of first order lose, and whose defects then scatter.
LOST = 18


def verdict_of(number: int) -> tuple[Verdict, bool]:
    """The verdict on a ladder alone, without single steps and pieces, which decide all of these."""
    scenario = random_scene(number)
    return judged(scenario, MUJOCO, RK4, replace(prepare(scenario, [], STEPS), places=None))


def test_defects_of_a_run_that_lost_the_motion_scatter_without_a_fault(monkeypatch) -> None:
    method, scenario = MUJOCO.method("implicit"), random_scene(LOST)
    prepared = prepare(scenario, [], STEPS)
    assert judged(scenario, MUJOCO, method, prepared)[0].verdict == "converges"
    monkeypatch.setattr(contradictions, "_own", lambda *_: 0.0)
    assert judged(scenario, MUJOCO, method, prepared)[0].verdict == "disagrees"


def test_the_limits_error_of_a_fast_fall_is_within_its_tolerance(monkeypatch) -> None:
    verdict, _ = verdict_of(FALLS_FAST)
    assert verdict.verdict == "converges"
    assert not any(is_too_sure(signal) for signal in verdict.signals)
    monkeypatch.setattr(richardson, "roundings_in_flight", lambda *_: 0.0)
    verdict, _ = verdict_of(FALLS_FAST)
    too_sure = [signal.signal for signal in verdict.signals if is_too_sure(signal)]
    assert too_sure == ["angular_momentum"]


def test_a_flights_roundings_are_those_of_its_momentum_flux_by_a_random_walk() -> None:
    hammer = library_scene("hammer")
    solution = solve(hammer, hammer.times)
    fast = np.linalg.norm(solution.trajectory.velocity_world, axis=1).max()
    L = np.linalg.norm(solution.trajectory.omega_body @ hammer.body.inertia_com, axis=1).max()
    flux = hammer.body.mass * fast**2
    assert roundings_in_flight(hammer, solution, 1) == pytest.approx(flux * hammer.times[-1] / L)
    assert roundings_in_flight(hammer, solution, 4) == pytest.approx(
        roundings_in_flight(hammer, solution, 1) / 2
    )
    top = library_scene("fast-top")
    assert roundings_in_flight(top, solve(top, top.times), 1) == 0.0


def test_a_motion_too_uncertain_for_a_verdict_is_told_from_a_ladder_that_is_too_short() -> None:
    verdict, is_too_uncertain = verdict_of(CHAOTIC)
    assert (verdict.verdict, is_too_uncertain) == ("unresolved", True)
    assert is_wrong(RK4, verdict)
    assert verdict_of(FALLS_FAST)[1] is False
