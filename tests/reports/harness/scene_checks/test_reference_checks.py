"""The checks of the exact motion accept a right one and report what is wrong with a faulty one."""

from dataclasses import replace

import pytest
from library_scenes import library_scene
from spincheck.reference import Solution, solve
from spincheck.reports.harness.scene_checks import reference_checks
from spincheck.reports.harness.scene_checks.reference_checks import complaints
from spincheck.scenarios import FloatArray, Scenario, loads

pytestmark = pytest.mark.slow

#: Well conditioned; beside a saddle; rotation that no rounding may disturb; ill-conditioned; long.
SCENES = (
    "book-with-drag",
    "middle-axis-off-by-1e-8",
    "middle-axis-exactly",
    "rod-1e-12",
    "needle-in-skew-axes",
    "million-turns",
)


@pytest.mark.parametrize("name", SCENES)
def test_one_that_turns_too_fast_is_complained_of_and_the_exact_motion_is_not(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a hundredth: at its coarsest a second method still tells so much."""
    assert list(complaints(library_scene(name))) == []

    def faster(scenario: Scenario, times: FloatArray) -> Solution:
        solution = solve(scenario, times)
        early = solve(scenario, times * 1.01).trajectory
        exact = solution.trajectory
        motion = replace(early, t=exact.t, omega_body=early.omega_body * 1.01)
        return replace(solution, trajectory=motion)

    monkeypatch.setattr(reference_checks, "solve", faster)
    words = list(complaints(library_scene(name)))
    assert any("second method" in complaint for complaint in words)


def test_a_printed_value_that_the_exact_motion_misses_is_complained_of() -> None:
    text = library_scene("detest-b5").text.replace(
        "[[published]]\nt = 20.0", "[[published]]\nt = 19.9"
    )
    assert any("they differ by" in complaint for complaint in complaints(loads(text, "late")))
