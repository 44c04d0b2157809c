"""Which effects a scene can test: those whose absence changes its motion."""

import pytest
from library_scenes import library_scene
from spincheck.reference import IntegrationError
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.scene_checks.power import powerless
from spincheck.scenarios.scenario import with_tables

#: A scene of the library for every effect that can be taken away.
WITH_POWER = {
    "gravity": "fast-top",
    "drag": "book-with-drag",
    "torque_body": "stuck-thruster",
    "torque_world": "book-pushed",
}


@pytest.mark.parametrize("effect", WITH_POWER)
def test_the_library_can_test_every_effect(effect: str) -> None:
    scenario = library_scene(WITH_POWER[effect])
    assert effect in scenario.called_for
    assert list(powerless(scenario)) == []


def test_a_sleeping_top_cannot_test_gravity() -> None:
    (sentence,) = powerless(library_scene("asleep-at-the-threshold"))
    assert "cannot tell whether there is gravity" in sentence


def test_a_chaotic_motion_that_is_not_known_until_its_window_ends_is_said_to_be_so() -> None:
    (sentence,) = powerless(library_scene("chaos-beyond-the-horizon"))
    assert "it is chaotic, and from t = 34." in sentence
    assert "before the window ends at 40 s: nothing is compared from there on" in sentence


def test_a_chaotic_motion_of_which_no_sample_is_known_is_said_to_be_chaotic() -> None:
    """Of three samples the second is beyond the horizon, and nothing could be compared."""
    scenario = library_scene("chaos-beyond-the-horizon")
    window = scenario.document.window.model_copy(update={"duration": 400.0, "samples": 3})
    scenario = with_tables(scenario, window=window)
    for check in (lambda: list(powerless(scenario)), lambda: prepare(scenario, [0.01], 4096)):
        with pytest.raises(IntegrationError, match="no sample but the first is known: it is chao"):
            check()
