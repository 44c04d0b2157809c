"""Which effects a scene can test: those whose absence changes its motion."""

import pytest
from library_scenes import library_scene
from spincheck.reports.harness.scene_checks.power import powerless

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
