"""The study of random scenes: single scenes of it, and what it counts as wrong."""

import numpy as np
import pytest
from library_scenes import library_scene
from measure_random import is_too_sure, is_wrong, judged, random_scene
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.reports.harness import richardson
from spincheck.reports.harness.rounding import precision_in_flight
from spincheck.reports.harness.study import prepare
from spincheck.reports.results.records import Verdict
from spincheck.scenarios import radius_of_gyration

pytestmark = pytest.mark.slow

MUJOCO = engines()["mujoco"]
RK4 = MUJOCO.method("RK4")
EPS = float(np.finfo(float).eps)
#: The number of a scene whose body falls 47 km: there MuJoCo rounds positions to 7e-12 m.
FALLS_FAR = 264
#: The number of one whose motion is too uncertain by its end for any verdict but `unresolved`.
CHAOTIC = 30
STEPS = 1 << 15


def verdict_of(number: int) -> tuple[Verdict, bool]:
    scenario = random_scene(number)
    return judged(scenario, MUJOCO, RK4, prepare(scenario, [], STEPS))


def test_far_from_the_origin_a_limits_error_is_within_its_tolerance(monkeypatch) -> None:
    verdict, _ = verdict_of(FALLS_FAR)
    assert verdict.verdict == "converges"
    assert not any(is_too_sure(signal) for signal in verdict.signals)
    monkeypatch.setattr(richardson, "precision_in_flight", lambda *_: 0.0)
    verdict, _ = verdict_of(FALLS_FAR)
    assert [signal.signal for signal in verdict.signals if is_too_sure(signal)] == [
        "angular_momentum"
    ]


def test_the_precision_in_flight_is_the_rounding_of_the_distance_over_the_bodys_size() -> None:
    scenario = library_scene("far-from-the-origin")
    solution = solve(scenario, scenario.times)
    far = np.linalg.norm(solution.trajectory.com_world, axis=1).max()
    assert precision_in_flight(scenario, solution, EPS) == pytest.approx(
        EPS * far / radius_of_gyration(scenario)
    )
    top = library_scene("fast-top")
    assert precision_in_flight(top, solve(top, top.times), EPS) == 0.0


def test_a_motion_too_uncertain_for_a_verdict_is_told_from_a_ladder_that_is_too_short() -> None:
    verdict, is_too_uncertain = verdict_of(CHAOTIC)
    assert (verdict.verdict, is_too_uncertain) == ("unresolved", True)
    assert is_wrong(RK4, verdict)
    assert verdict_of(FALLS_FAR)[1] is False
